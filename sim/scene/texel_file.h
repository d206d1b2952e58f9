// Shapes from HDF5 files.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "sim/base/vectors.h"

namespace weft::sim {

// The vertices of a shape (m), ordered by patch, row and column.
struct TexelFile {
  int patches = 0, rows = 0, cols = 0;
  std::vector<Vec3> texels;
};

// Reads a dataset [rows, cols, 3] or [patches, rows, cols, 3]. A separate process reads the file,
// because HDF5 crashes on some damaged files. Throws FileError if the file cannot be read, or if
// the process crashes. Also throws it, before memory is allocated, if the file stores fewer numbers
// than the dataset's shape claims or if the numbers take more than `most_bytes`.
TexelFile read_texels(const std::string& path, const std::string& dataset,
                      double most_bytes = std::numeric_limits<double>::infinity());
// Reads a dataset [n, 3] of points (m) likewise: one patch of one row.
TexelFile read_points(const std::string& path, const std::string& dataset,
                      double most_bytes = std::numeric_limits<double>::infinity());

// Reads a dataset as read_texels() does, but in this process, which ends if HDF5 crashes on the
// file. A fuzzer sees the code that this function reaches.
TexelFile read_texels_unguarded(const std::string& path, const std::string& dataset,
                                double most_bytes = std::numeric_limits<double>::infinity());

}  // namespace weft::sim
