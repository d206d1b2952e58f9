// Compares two trajectories dataset by dataset, by plain HDF5, without Weft's code.
#pragma once

#include <gtest/gtest.h>
#include <hdf5.h>

#include <cstring>
#include <set>
#include <string>
#include <vector>

namespace weft::sim {

// Returns the paths of the datasets that a file has, without those of wall times.
inline std::set<std::string> dataset_paths(hid_t file) {
  std::set<std::string> paths;
  H5Ovisit(
      file, H5_INDEX_NAME, H5_ITER_NATIVE,
      [](hid_t, const char* name, const H5O_info_t* info, void* into) {
        const bool is_clock = std::strstr(name, "wall_") != nullptr;
        if (info->type == H5O_TYPE_DATASET && !is_clock)
          static_cast<std::set<std::string>*>(into)->insert(name);
        return herr_t{0};
      },
      &paths);
  return paths;
}

struct RawDataset {
  std::vector<hsize_t> shape;
  std::string bytes;
  bool operator==(const RawDataset&) const = default;
};

inline RawDataset read_raw(hid_t file, const std::string& path) {
  RawDataset result;
  const hid_t dataset = H5Dopen2(file, path.c_str(), H5P_DEFAULT);
  const hid_t space = H5Dget_space(dataset), type = H5Dget_type(dataset);
  result.shape.resize(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
  if (!result.shape.empty()) H5Sget_simple_extent_dims(space, result.shape.data(), nullptr);
  if (H5Tis_variable_str(type) > 0) {
    char* text = nullptr;
    EXPECT_GE(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, &text), 0) << path;
    result.bytes = text == nullptr ? "" : text;
    H5free_memory(text);
  } else {
    result.bytes.resize(H5Tget_size(type) *
                        static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
    EXPECT_GE(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, result.bytes.data()), 0)
        << path;
  }
  H5Tclose(type);
  H5Sclose(space);
  H5Dclose(dataset);
  return result;
}

// Returns the paths of the datasets in which the two files differ, or that only one of them has.
// Datasets of wall times are not compared.
inline std::vector<std::string> differing_datasets(const std::string& one,
                                                   const std::string& other) {
  const hid_t a = H5Fopen(one.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t b = H5Fopen(other.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  EXPECT_GE(a, 0) << one;
  EXPECT_GE(b, 0) << other;
  if (a < 0 || b < 0) return {"unreadable"};
  const std::set<std::string> paths = dataset_paths(a), of_other = dataset_paths(b);
  std::set<std::string> all = paths;
  all.insert(of_other.begin(), of_other.end());
  std::vector<std::string> differing;
  for (const std::string& path : all) {
    if (!paths.contains(path) || !of_other.contains(path) || read_raw(a, path) != read_raw(b, path))
      differing.push_back(path);
  }
  H5Fclose(a);
  H5Fclose(b);
  return differing;
}

}  // namespace weft::sim
