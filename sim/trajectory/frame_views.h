// Virtual datasets that each show one frame of one body, for ParaView. Private to sim/.
#pragma once

#include <string>
#include <vector>

#include "sim/base/hdf5_handle.h"
#include "sim/trajectory/trajectory.h"
#include "sim/trajectory/xdmf_file.h"

namespace weft::sim {

// The shape of one frame: [rows, cols, 3] or [patches, rows, cols, 3]; with one component, without
// the last axis.
std::vector<hsize_t> frame_shape(const bsi::Atlas& atlas, int components = 3);

// The group /frame, which gets one group per frame. Functions throw FileError.
class FrameViews {
 public:
  // Creates the group /frame. `bodies` is kept by reference; `file` is the open file.
  FrameViews(const hdf5::Access& access, hid_t file, const std::vector<TrajectoryBody>& bodies,
             Precision precision);

  // Returns the surfaces of bodies at rest, which have no views, for the sidecar.
  std::vector<XdmfSurface> surfaces_at_rest() const;
  // Adds the views of the next frame, counted from 0, and returns its moving surfaces for the
  // sidecar.
  std::vector<XdmfSurface> add_frame();
  // Closes the groups, so that the file can be closed.
  void close();

 private:
  XdmfSurface surface_of(const TrajectoryBody& body) const;
  // Creates the groups that hold the next frame's group, if that frame is the first in them.
  void open_groups();
  // Adds a view of one dataset of the body to the group of that name, and returns its path.
  std::string link_view(hid_t group, const TrajectoryBody& body, const std::string& dataset,
                        hid_t type, int components) const;
  // The path of the group of the next frame.
  std::string frame_path() const;
  hdf5::Handle make_group(hid_t parent, const std::string& name,
                          const hdf5::Handle& properties) const;

  const hdf5::Access& access_;
  const std::vector<TrajectoryBody>& bodies_;
  Precision precision_;                // of positions
  std::vector<std::string> datasets_;  // that have views: position, and the fields of all bodies
  int frame_ = 0;
  // Properties of groups that hold frames, datasets, and bodies.
  hdf5::Handle of_frames_, of_datasets_, of_bodies_;
  hdf5::Handle frame_group_, shelf_group_, block_group_;
};

}  // namespace weft::sim
