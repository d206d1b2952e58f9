// Axis-aligned boxes around the straight paths of points, for cheap tests of features.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "sim/base/vectors.h"

namespace weft::sim {

// A box, m. The fourth number of both corners is 0.
struct PathBox {
  Eigen::Array4d low, high;

  friend PathBox united(const PathBox& a, const PathBox& b) {
    return {a.low.min(b.low), a.high.max(b.high)};
  }
  // Returns the squared distance of two boxes, m^2.
  friend double squared_gap(const PathBox& a, const PathBox& b) {
    return (a.low - b.high).max(b.low - a.high).max(0.0).square().sum();
  }
};

// Returns the gap between two sets of boxes along an axis from the first to the second, times the
// length of the axis; negative if they overlap.
inline double gap_along(const Eigen::Array4d& axis, std::span<const PathBox* const> first,
                        std::span<const PathBox* const> second) {
  const Eigen::Array4d forward = axis.max(0.0), backward = axis.min(0.0);
  double end = -std::numeric_limits<double>::infinity();
  for (const PathBox* box : first)
    end = std::max(end, (forward * box->high + backward * box->low).sum());
  double start = std::numeric_limits<double>::infinity();
  for (const PathBox* box : second)
    start = std::min(start, (forward * box->low + backward * box->high).sum());
  return start - end;
}

// Returns the boxes around the paths start -> end of points, m.
inline std::vector<PathBox> path_boxes(std::span<const Vec3> start, std::span<const Vec3> end) {
  std::vector<PathBox> boxes(end.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Eigen::Array3d from = start[i].array(), to = end[i].array();
    boxes[i].low << from.min(to), 0.0;
    boxes[i].high << from.max(to), 0.0;
  }
  return boxes;
}

}  // namespace weft::sim
