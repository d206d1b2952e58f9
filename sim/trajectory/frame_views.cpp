#include "sim/trajectory/frame_views.h"

#include <algorithm>

#include "sim/trajectory/image_storage.h"

namespace weft::sim {
namespace {

using hdf5::Handle;
using hdf5::make_space;

// Number of links for which a group of frames has room in its header. The header, with the names of
// the links, fits into one page of metadata.
constexpr int links_per_group = 128;
// Lengths of names for which the headers of groups have room (characters).
constexpr int frame_name_length = 8;
constexpr int body_name_length = 16;
constexpr int dataset_name_length = 32;
// Number of frames in a group /frame/A. With the three levels /frame, A and B, no group outgrows
// its page before the two-millionth frame.
constexpr int frames_per_shelf = links_per_group * links_per_group;

// Returns creation properties of a group whose links stay in its object header, as the commit
// driver requires. The header has room for `links` links with names of `name_length` characters.
Handle growing_group_properties(int links, int name_length) {
  Handle properties(H5Pcreate(H5P_GROUP_CREATE));
  H5Pset_link_phase_change(properties.get(), 65535, 0);
  H5Pset_est_link_info(properties.get(), static_cast<unsigned>(links),
                       static_cast<unsigned>(name_length));
  H5Pset_obj_track_times(properties.get(), false);
  return properties;
}

// Returns the names of the datasets that have views, each name once.
std::vector<std::string> viewed_datasets(const std::vector<TrajectoryBody>& bodies) {
  std::vector<std::string> names{"position"};
  for (const TrajectoryBody& body : bodies) {
    for (const TrajectoryField& field : body.fields) {
      if (std::ranges::find(names, field.name) == names.end()) names.push_back(field.name);
    }
  }
  return names;
}

// Returns the number of bodies that move. Only these have views: links to other bodies would take
// room in the headers of every frame.
int moving_count(const std::vector<TrajectoryBody>& bodies) {
  return static_cast<int>(std::ranges::count_if(bodies, &TrajectoryBody::moves));
}

}  // namespace

std::string home_of(const TrajectoryBody& body) {
  return (body.is_of_spheres() ? "/particles/" : "/body/") + body.name;
}

std::vector<hsize_t> frame_shape(const bsi::Atlas& atlas, int components) {
  if (atlas.is_of_points()) {
    std::vector<hsize_t> points = {static_cast<hsize_t>(atlas.texel_count())};
    if (components > 1) points.push_back(static_cast<hsize_t>(components));
    return points;
  }
  const bsi::Patch& first = atlas.patches().front();
  std::vector<hsize_t> shape = {static_cast<hsize_t>(first.rows), static_cast<hsize_t>(first.cols)};
  if (components > 1) shape.push_back(static_cast<hsize_t>(components));
  if (atlas.patches().size() > 1) shape.insert(shape.begin(), atlas.patches().size());
  return shape;
}

FrameViews::FrameViews(const hdf5::Access& access, hid_t file,
                       const std::vector<TrajectoryBody>& bodies, Precision precision)
    : access_(access),
      bodies_(bodies),
      precision_(precision),
      datasets_(viewed_datasets(bodies)),
      of_frames_(growing_group_properties(links_per_group, frame_name_length)),
      of_datasets_(
          growing_group_properties(static_cast<int>(datasets_.size()), dataset_name_length)),
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

// The view is a virtual dataset [texels, 3] or [texels]. All of ParaView's XDMF readers understand
// virtual datasets, but not all of them understand XDMF hyperslabs.
std::string FrameViews::link_view(hid_t group, const TrajectoryBody& body,
                                  const std::string& dataset, hid_t type, int components) const {
  const std::string action = "write frame " + std::to_string(frame_);
  const std::string source = home_of(body) + "/" + dataset;
  std::vector<hsize_t> shape = frame_shape(body.atlas, components);
  shape.insert(shape.begin(), static_cast<hsize_t>(frame_) + 1);
  std::vector<hsize_t> start(shape.size(), 0);
  start[0] = static_cast<hsize_t>(frame_);
  const Handle source_space = make_space(shape);
  shape[0] = 1;
  H5Sselect_hyperslab(source_space.get(), H5S_SELECT_SET, start.data(), nullptr, shape.data(),
                      nullptr);
  std::vector<hsize_t> view_shape{static_cast<hsize_t>(body.atlas.texel_count())};
  if (components > 1) view_shape.push_back(static_cast<hsize_t>(components));
  const Handle view_space = make_space(view_shape);
  const Handle properties(H5Pcreate(H5P_DATASET_CREATE));
  H5Pset_obj_track_times(properties.get(), false);
  access_.check(
      H5Pset_virtual(properties.get(), view_space.get(), ".", source.c_str(), source_space.get()),
      action);
  const Handle view = access_.handle(H5Dcreate2(group, body.name.c_str(), type, view_space.get(),
                                                H5P_DEFAULT, properties.get(), H5P_DEFAULT),
                                     action);
  return frame_path() + "/" + dataset + "/" + body.name;
}

std::string FrameViews::frame_path() const {
  return "/frame/" + std::to_string(frame_ / frames_per_shelf) + "/" +
         std::to_string(frame_ / links_per_group) + "/" + std::to_string(frame_);
}

XdmfSurface FrameViews::surface_of(const TrajectoryBody& body) const {
  XdmfSurface surface;
  surface.name = body.name;
  surface.points = body.atlas.texel_count();
  surface.triangles = 2 * body.atlas.quad_count();
  if (!body.is_of_spheres()) surface.triangle_dataset = home_of(body) + "/triangles";
  surface.position_dataset = home_of(body) + "/position";
  if (precision_ == Precision::float64) surface.position_bytes = 8;
  return surface;
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
  const Handle group = make_group(block_group_.get(), std::to_string(frame_), of_datasets_);
  std::vector<Handle> groups;  // one per entry of datasets_
  for (const std::string& dataset : datasets_)
    groups.push_back(make_group(group.get(), dataset, of_bodies_));
  std::vector<XdmfSurface> surfaces;
  for (const TrajectoryBody& body : bodies_) {
    if (!body.moves) continue;
    XdmfSurface& surface = surfaces.emplace_back(surface_of(body));
    surface.position_dataset =
        link_view(groups.front().get(), body, datasets_.front(), file_type(precision_), 3);
    for (const auto& [name, units, channel, components] : body.fields) {
      const auto place = std::ranges::find(datasets_, name) - datasets_.begin();
      surface.attributes.push_back(
          {name, components,
           link_view(groups[place].get(), body, name, H5T_IEEE_F32LE, components)});
    }
  }
  ++frame_;
  return surfaces;
}

void FrameViews::close() {
  for (Handle* handle : {&block_group_, &shelf_group_, &frame_group_}) handle->close();
}

}  // namespace weft::sim
