#include "sim/trajectory/frame_views.h"

#include <algorithm>

namespace weft::sim {
namespace {

using hdf5::Handle;
using hdf5::make_space;

// Links of a group below /frame: as many as fit, with their names, into one page of metadata.
constexpr int links_per_group = 128;
constexpr int frame_name_length = 8;
constexpr int body_name_length = 16;
// Groups have three levels, so none outgrows its page before the two-millionth frame.
constexpr int frames_per_shelf = links_per_group * links_per_group;

// Properties of a group whose links stay in its object header, as the commit driver requires. The
// header has room for `links` of them from the start.
Handle growing_group_properties(int links, int name_length) {
  Handle properties(H5Pcreate(H5P_GROUP_CREATE));
  H5Pset_link_phase_change(properties.get(), 65535, 0);
  H5Pset_est_link_info(properties.get(), static_cast<unsigned>(links),
                       static_cast<unsigned>(name_length));
  H5Pset_obj_track_times(properties.get(), false);
  return properties;
}

bool has_velocity(const TrajectoryBody& body) {
  return std::ranges::find(body.fields, "velocity", &TrajectoryField::name) != body.fields.end();
}

// Counts the bodies that have views. Bodies at rest have none: their links would take room in the
// header of every frame.
int moving_count(const std::vector<TrajectoryBody>& bodies) {
  return static_cast<int>(std::ranges::count_if(bodies, &TrajectoryBody::moves));
}

std::string home_of(const TrajectoryBody& body) { return "/body/" + body.name; }

XdmfSurface surface_of(const TrajectoryBody& body) {
  XdmfSurface surface;
  surface.name = body.name;
  surface.points = body.atlas.texel_count();
  surface.triangles = 2 * body.atlas.quad_count();
  surface.triangle_dataset = home_of(body) + "/triangles";
  surface.position_dataset = home_of(body) + "/position";
  return surface;
}

}  // namespace

std::vector<hsize_t> frame_shape(const bsi::Atlas& atlas, int components) {
  const bsi::Patch& first = atlas.patches().front();
  std::vector<hsize_t> shape = {static_cast<hsize_t>(first.rows), static_cast<hsize_t>(first.cols)};
  if (components > 1) shape.push_back(static_cast<hsize_t>(components));
  if (atlas.patches().size() > 1) shape.insert(shape.begin(), atlas.patches().size());
  return shape;
}

FrameViews::FrameViews(const hdf5::Access& access, hid_t file,
                       const std::vector<TrajectoryBody>& bodies)
    : access_(access),
      bodies_(bodies),
      has_velocity_(std::ranges::any_of(bodies, has_velocity)),
      of_frames_(growing_group_properties(links_per_group, frame_name_length)),
      of_bodies_(growing_group_properties(moving_count(bodies) + 1, body_name_length)),
      frame_group_(make_group(file, "frame", of_frames_)) {}

Handle FrameViews::make_group(hid_t parent, const std::string& name,
                              const Handle& properties) const {
  return access_.handle(
      H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, properties.get(), H5P_DEFAULT),
      "create group " + name);
}

void FrameViews::open_groups() {
  if (frame_ % frames_per_shelf == 0) {
    shelf_group_ =
        make_group(frame_group_.get(), std::to_string(frame_ / frames_per_shelf), of_frames_);
  }
  if (frame_ % links_per_group == 0) {
    block_group_ =
        make_group(shelf_group_.get(), std::to_string(frame_ / links_per_group), of_frames_);
  }
}

// Makes a virtual dataset [texels, 3] that shows one frame of `source`. All readers of ParaView
// understand it, unlike XDMF hyperslabs.
std::string FrameViews::link_view(hid_t group, const std::string& group_name,
                                  const TrajectoryBody& body, const std::string& source) const {
  const std::string action = "write frame " + std::to_string(frame_);
  std::vector<hsize_t> shape = frame_shape(body.atlas);
  shape.insert(shape.begin(), static_cast<hsize_t>(frame_) + 1);
  std::vector<hsize_t> start(shape.size(), 0);
  start[0] = static_cast<hsize_t>(frame_);
  const Handle source_space = make_space(shape);
  shape[0] = 1;
  H5Sselect_hyperslab(source_space.get(), H5S_SELECT_SET, start.data(), nullptr, shape.data(),
                      nullptr);
  const Handle view_space = make_space({static_cast<hsize_t>(body.atlas.texel_count()), 3});
  const Handle properties(H5Pcreate(H5P_DATASET_CREATE));
  H5Pset_obj_track_times(properties.get(), false);
  access_.check(
      H5Pset_virtual(properties.get(), view_space.get(), ".", source.c_str(), source_space.get()),
      action);
  const Handle view =
      access_.handle(H5Dcreate2(group, body.name.c_str(), H5T_IEEE_F32LE, view_space.get(),
                                H5P_DEFAULT, properties.get(), H5P_DEFAULT),
                     action);
  return group_name + "/" + body.name;
}

std::vector<XdmfSurface> FrameViews::surfaces_at_rest() const {
  std::vector<XdmfSurface> surfaces;
  for (const TrajectoryBody& body : bodies_) {
    if (!body.moves) surfaces.push_back(surface_of(body));
  }
  return surfaces;
}

std::vector<XdmfSurface> FrameViews::add_frame() {
  open_groups();
  const std::string frame = std::to_string(frame_);
  const std::string frame_name = "/frame/" + std::to_string(frame_ / frames_per_shelf) + "/" +
                                 std::to_string(frame_ / links_per_group) + "/" + frame;
  const Handle group = make_group(block_group_.get(), frame, of_bodies_);
  const Handle positions = make_group(group.get(), "position", of_bodies_);
  const Handle velocities =
      has_velocity_ ? make_group(group.get(), "velocity", of_bodies_) : Handle();
  std::vector<XdmfSurface> surfaces;
  for (const TrajectoryBody& body : bodies_) {
    if (!body.moves) continue;
    XdmfSurface& surface = surfaces.emplace_back(surface_of(body));
    surface.position_dataset =
        link_view(positions.get(), frame_name + "/position", body, home_of(body) + "/position");
    if (has_velocity(body)) {
      surface.velocity_dataset =
          link_view(velocities.get(), frame_name + "/velocity", body, home_of(body) + "/velocity");
    }
  }
  ++frame_;
  return surfaces;
}

void FrameViews::close() {
  for (Handle* handle : {&block_group_, &shelf_group_, &frame_group_}) handle->close();
}

}  // namespace weft::sim
