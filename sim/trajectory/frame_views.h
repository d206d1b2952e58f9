// Virtual datasets for ParaView. Each shows one frame of one body. Private to sim/.
#pragma once

#include <string>
#include <vector>

#include "sim/base/hdf5_handle.h"
#include "sim/trajectory/trajectory.h"
#include "sim/trajectory/xdmf_file.h"

namespace weft::sim {

// Returns the shape of one frame: [rows, cols, 3], or [patches, rows, cols, 3] for several patches.
// With one component the last axis is absent.
std::vector<hsize_t> frame_shape(const bsi::Atlas& atlas, int components = 3);

// The group /frame, with one subgroup of views per frame. Functions throw FileError.
class FrameViews {
 public:
  // Creates the group /frame in the open `file`. Keeps references to `access` and `bodies`.
  FrameViews(const hdf5::Access& access, hid_t file, const std::vector<TrajectoryBody>& bodies,
             Precision precision);

  // Returns the surfaces of bodies at rest for the sidecar. They have no views.
  std::vector<XdmfSurface> surfaces_at_rest() const;
  // Adds the views of the next frame and returns its moving surfaces for the sidecar.
  std::vector<XdmfSurface> add_frame();
  // Closes the groups. To be called before the file is closed.
  void close();

 private:
  XdmfSurface surface_of(const TrajectoryBody& body) const;
  // Creates the groups that contain the next frame's group, if that frame is their first.
  void open_groups();
  // Adds a view of one dataset of the body to `group`, and returns the path of the view.
  std::string link_view(hid_t group, const TrajectoryBody& body, const std::string& dataset,
                        hid_t type, int components) const;
  // Returns the path of the next frame's group.
  std::string frame_path() const;
  hdf5::Handle make_group(hid_t parent, const std::string& name,
                          const hdf5::Handle& properties) const;

  const hdf5::Access& access_;
  const std::vector<TrajectoryBody>& bodies_;
  Precision precision_;                // of positions
  std::vector<std::string> datasets_;  // with views: position, and the fields of all bodies
  int frame_ = 0;
  // Properties of the groups that contain frames, datasets and bodies.
  hdf5::Handle of_frames_, of_datasets_, of_bodies_;
  hdf5::Handle frame_group_, shelf_group_, block_group_;
};

}  // namespace weft::sim
