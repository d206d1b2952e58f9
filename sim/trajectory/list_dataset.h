// Datasets of numbers or vectors by frame or step, which grow. Private to sim/.
#pragma once

#include <span>
#include <string>

#include "sim/base/hdf5_handle.h"

namespace weft::sim {

// Creates an empty float64 dataset: [0], or [0, components] for more than one. Throws FileError.
hdf5::Handle create_list(const hdf5::Access& access, hid_t group, const std::string& name,
                         int components = 1);

// Appends `values`, `components` numbers per entry, behind the first `start` entries. `action`
// names the write in errors. Throws FileError.
void append_to_list(const hdf5::Access& access, hid_t dataset, hsize_t start,
                    std::span<const double> values, int components, const std::string& action);

// Properties of groups that record the order in which their members are created; readers list them
// in that order.
hdf5::Handle ordered_group();
// Creates the groups that a path names above its last part, unless they exist. Throws FileError.
void create_groups_above(const hdf5::Access& access, hid_t file, const std::string& path);

}  // namespace weft::sim
