// Axis-aligned boxes around the straight paths of points, for cheap tests of features.
#pragma once

#include <Eigen/Core>
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
