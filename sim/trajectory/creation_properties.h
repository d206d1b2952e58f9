// Creation properties of the objects in a trajectory. None has time stamps, so equal runs write
// equal bytes. Private to sim/.
#pragma once

#include "sim/base/hdf5_handle.h"

namespace weft::sim {

// While an object of this class lives, HDF5's default properties of groups have no time stamps.
// HDF5 creates the root group with the default properties, whatever the caller asks for.
class DefaultGroupsWithoutTimes {
 public:
  DefaultGroupsWithoutTimes() {
    H5Pget_obj_track_times(H5P_GROUP_CREATE_DEFAULT, &tracked_before_);
    H5Pset_obj_track_times(H5P_GROUP_CREATE_DEFAULT, false);
  }
  ~DefaultGroupsWithoutTimes() {
    H5Pset_obj_track_times(H5P_GROUP_CREATE_DEFAULT, tracked_before_);
  }
  DefaultGroupsWithoutTimes(const DefaultGroupsWithoutTimes&) = delete;
  DefaultGroupsWithoutTimes& operator=(const DefaultGroupsWithoutTimes&) = delete;

 private:
  hbool_t tracked_before_ = true;
};

// Returns creation properties of datasets.
inline hdf5::Handle dataset_properties() {
  hdf5::Handle properties(H5Pcreate(H5P_DATASET_CREATE));
  H5Pset_obj_track_times(properties.get(), false);
  return properties;
}

// Returns creation properties of the group /run. They reserve room in its header for the attributes
// that are written when the run ends.
inline hdf5::Handle end_properties() {
  hdf5::Handle properties(H5Pcreate(H5P_GROUP_CREATE));
  H5Pset_obj_track_times(properties.get(), false);
  H5Pset_attr_phase_change(properties.get(), 64, 0);
  H5Pset_est_link_info(properties.get(), 32, 32);
  return properties;
}

}  // namespace weft::sim
