#include "sim/trajectory/list_dataset.h"

#include <vector>

namespace weft::sim {
namespace {

using hdf5::Handle;
using hdf5::make_space;

// Number of entries per chunk of a list. A commit rewrites the last chunk, which is 1 KiB for
// numbers.
constexpr hsize_t list_chunk = 128;

// Returns the shape of the dataset of a list with `entries` entries.
std::vector<hsize_t> shape_of(hsize_t entries, int components) {
  if (components == 1) return {entries};
  return {entries, static_cast<hsize_t>(components)};
}

}  // namespace

Handle create_list(const hdf5::Access& access, hid_t group, const std::string& name,
                   int components) {
  const Handle properties(H5Pcreate(H5P_DATASET_CREATE));
  H5Pset_obj_track_times(properties.get(), false);
  const std::vector<hsize_t> chunk = shape_of(list_chunk, components);
  H5Pset_chunk(properties.get(), static_cast<int>(chunk.size()), chunk.data());
  const Handle space = make_space(shape_of(0, components), shape_of(H5S_UNLIMITED, components));
  return access.handle(H5Dcreate2(group, name.c_str(), H5T_IEEE_F64LE, space.get(), H5P_DEFAULT,
                                  properties.get(), H5P_DEFAULT),
                       "create dataset " + name);
}

void append_to_list(const hdf5::Access& access, hid_t dataset, hsize_t start,
                    std::span<const double> values, int components, const std::string& action) {
  const hsize_t entries = values.size() / static_cast<hsize_t>(components);
  const std::vector<hsize_t> count = shape_of(entries, components);
  const std::vector<hsize_t> size = shape_of(start + entries, components);
  std::vector<hsize_t> from(count.size(), 0);
  from[0] = start;
  access.check(H5Dset_extent(dataset, size.data()), action);
  const Handle target(H5Dget_space(dataset));
  access.check(H5Sselect_hyperslab(target.get(), H5S_SELECT_SET, from.data(), nullptr, count.data(),
                                   nullptr),
               action);
  access.check(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, make_space(count).get(), target.get(),
                        H5P_DEFAULT, values.data()),
               action);
}

Handle ordered_group() {
  Handle properties(H5Pcreate(H5P_GROUP_CREATE));
  H5Pset_link_creation_order(properties.get(), H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED);
  H5Pset_obj_track_times(properties.get(), false);
  return properties;
}

void create_groups_above(const hdf5::Access& access, hid_t file, const std::string& path) {
  const Handle ordered = ordered_group();
  for (std::size_t end = path.find('/'); end != std::string::npos; end = path.find('/', end + 1)) {
    const std::string group = path.substr(0, end);
    if (H5Lexists(file, group.c_str(), H5P_DEFAULT) > 0) continue;
    access.handle(H5Gcreate2(file, group.c_str(), H5P_DEFAULT, ordered.get(), H5P_DEFAULT),
                  "create group " + group);
  }
}

}  // namespace weft::sim
