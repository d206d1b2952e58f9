// The Hessian of one hinge's angle from what its two triangles contribute.
#pragma once

#include "materials/hinge.h"

namespace weft::materials {

inline Eigen::Matrix<double, 12, 12> hinge_hessian(const Nodes4& x) {
  Eigen::Matrix<double, 12, 12> sum = Eigen::Matrix<double, 12, 12>::Zero();
  for (const std::array<int, 3>& nodes : {std::array{2, 0, 1}, std::array{3, 1, 0}}) {
    const Nodes3 triangle = x(Eigen::all, nodes);
    const auto part = hinge_hessians<double>(triangle, Vec3(1, 0, 0)).dense();
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b)
        sum.block<3, 3>(3 * nodes[a], 3 * nodes[b]) += part.block<3, 3>(3 * a, 3 * b);
    }
  }
  return sum;
}

}  // namespace weft::materials
