// Lists: growing datasets with one number or vector per frame or step. Private to sim/.
#pragma once

#include <span>
#include <string>

#include "sim/base/hdf5_handle.h"

namespace weft::sim {

// Creates an empty float64 dataset of shape [0], or [0, components] for more than one component.
// Throws FileError.
hdf5::Handle create_list(const hdf5::Access& access, hid_t group, const std::string& name,
                         int components = 1);

// Writes `values` to a list of `start` entries as further entries of `components` numbers each.
// `action` describes the write in error messages. Throws FileError.
void append_to_list(const hdf5::Access& access, hid_t dataset, hsize_t start,
                    std::span<const double> values, int components, const std::string& action);

// Returns creation properties of a group that records the order in which its members are created.
hdf5::Handle ordered_group();
// Creates the groups that contain the object at `path`, as far as they are missing. Throws
// FileError.
void create_groups_above(const hdf5::Access& access, hid_t file, const std::string& path);

}  // namespace weft::sim
