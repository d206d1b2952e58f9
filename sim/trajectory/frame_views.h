// Virtual datasets for ParaView, called views. A view shows one frame of one dataset of a body.
// Private to sim/.
#pragma once

#include <string>
#include <vector>

#include "sim/base/hdf5_handle.h"
#include "sim/trajectory/trajectory.h"
#include "sim/trajectory/xdmf_file.h"

namespace weft::sim {

// Returns the path of the group of a body or a group of spheres.
std::string home_of(const TrajectoryBody& body);

// Returns the shape of one frame of a dataset: [rows, cols, 3], [patches, rows, cols, 3] for
// several patches, or [spheres, 3]. With one component the last axis is absent.
std::vector<hsize_t> frame_shape(const bsi::Atlas& atlas, int components = 3);

// The group /frame of a trajectory, with one subgroup of views per frame. All functions may throw
// FileError.
class FrameViews {
 public:
  // Creates the group /frame in the open `file`. Keeps references to `access` and `bodies`.
  FrameViews(const hdf5::Access& access, hid_t file, const std::vector<TrajectoryBody>& bodies,
             Precision precision);

  // Returns the surfaces of the bodies that do not move, for the sidecar. These bodies have no
  // views.
  std::vector<XdmfSurface> surfaces_at_rest() const;
  // Adds the views of the next frame. Returns the surfaces of the bodies that move, for the
  // sidecar.
  std::vector<XdmfSurface> add_frame();
  // Closes the groups. Call it before the file is closed.
  void close();

 private:
  XdmfSurface surface_of(const TrajectoryBody& body) const;
  // Creates the groups that will contain the next frame's group, unless they exist.
  void open_groups();
  // Adds a view of the next frame of a body's dataset to `group`. Returns the path of the view.
  std::string link_view(hid_t group, const TrajectoryBody& body, const std::string& dataset,
                        hid_t type, int components) const;
  // Returns the path of the next frame's group.
  std::string frame_path() const;
  hdf5::Handle make_group(hid_t parent, const std::string& name,
                          const hdf5::Handle& properties) const;

  const hdf5::Access& access_;
  const std::vector<TrajectoryBody>& bodies_;
  Precision precision_;                // precision of positions
  std::vector<std::string> datasets_;  // names of datasets with views: position and all fields
  int frame_ = 0;                      // index of the next frame
  // Creation properties of groups whose members are frames or groups of frames, datasets, or
  // bodies.
  hdf5::Handle of_frames_, of_datasets_, of_bodies_;
  hdf5::Handle frame_group_, shelf_group_, block_group_;  // /frame, /frame/A and /frame/A/B
};

}  // namespace weft::sim
