// Growing datasets with one number or vector per frame or step. Private to sim/.
#pragma once

#include <span>
#include <string>

#include "sim/base/hdf5_handle.h"

namespace weft::sim {

// Creates an empty float64 dataset of shape [0], or [0, components] for more than one component.
// Throws FileError.
hdf5::Handle create_list(const hdf5::Access& access, hid_t group, const std::string& name,
                         int components = 1);

// Appends `values`, with `components` numbers per entry, after the first `start` entries. `action`
// names the write in error messages. Throws FileError.
void append_to_list(const hdf5::Access& access, hid_t dataset, hsize_t start,
                    std::span<const double> values, int components, const std::string& action);

// Returns properties of a group that records the order in which its members are created. Readers
// list the members in that order.
hdf5::Handle ordered_group();
// Creates the missing groups among those that `path` names before its last part. Throws FileError.
void create_groups_above(const hdf5::Access& access, hid_t file, const std::string& path);

}  // namespace weft::sim
