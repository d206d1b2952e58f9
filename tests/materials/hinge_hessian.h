// The Hessian of one hinge's angle, assembled from the parts of its two triangles.
#pragma once

#include "materials/hinge.h"

namespace weft::materials {

// Returns the sum over all three hinges of a triangle, in node-major order.
template <class Real>
Eigen::Matrix<Real, 9, 9> hinge_stress(const NodesOf<Real, 3>& x, const Vec3Of<Real>& moments) {
  HingeStress<Real> stress(x, 0, moments[0]);
  for (int i = 1; i < 3; ++i) stress.add(i, moments[i]);
  Eigen::Matrix<Real, 9, 9> all;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) all.template block<3, 3>(3 * a, 3 * b) = stress.block(a, b);
  }
  return all;
}

inline Eigen::Matrix<double, 12, 12> hinge_hessian(const Nodes4& x) {
  Eigen::Matrix<double, 12, 12> sum = Eigen::Matrix<double, 12, 12>::Zero();
  for (const std::array<int, 3>& nodes : {std::array{2, 0, 1}, std::array{3, 1, 0}}) {
    const Nodes3 triangle = x(Eigen::all, nodes);
    const HingeStress<double> part(triangle, 0, 1.0);
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) sum.block<3, 3>(3 * nodes[a], 3 * nodes[b]) += part.block(a, b);
    }
  }
  return sum;
}

}  // namespace weft::materials
