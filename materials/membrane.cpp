#include "materials/membrane.h"

#include <cassert>
#include <cmath>

namespace weft::materials {

namespace {

// d q_i / d x as columns, m: edge i starts at node i + 1 and ends at node i + 2.
using Gradients = Eigen::Matrix<double, 9, 3>;
Gradients squared_length_gradients(const Nodes3& edges) {
  Gradients gradients;
  for (int i = 0; i < 3; ++i) {
    const Vec3 twice = 2 * edges.col(i);
    gradients.block<3, 1>(3 * i, i).setZero();
    gradients.block<3, 1>(3 * ((i + 1) % 3), i) = -twice;
    gradients.block<3, 1>(3 * ((i + 2) % 3), i) = twice;
  }
  return gradients;
}

// G C G^T.
Mat9 material_stiffness(const Mat3& modulus, const Nodes3& edges) {
  const Gradients gradients = squared_length_gradients(edges);
  const Gradients stresses = gradients.lazyProduct(modulus);
  return stresses.lazyProduct(gradients.transpose());
}

}  // namespace

TriangleMembrane make_triangle_membrane(const Nodes3& rest, double stiffness, double poisson_ratio,
                                        double damping_time) {
  assert(poisson_ratio > -1 && poisson_ratio < 1);
  const Nodes3 edges = opposite_edges(rest);
  const double double_area = edges.col(0).cross(edges.col(1)).norm();
  assert(double_area > 0);
  // Delingette 2008 writes mu for twice the shear modulus of the usual Lame pair.
  const double plane_stress = stiffness / (1 - poisson_ratio * poisson_ratio);
  const double lambda = plane_stress * poisson_ratio;
  const double mu = plane_stress * (1 - poisson_ratio);
  TriangleMembrane membrane;
  membrane.damping_time = damping_time;
  Vec3 cotangents;
  for (int i = 0; i < 3; ++i) {
    membrane.rest_squared_length[i] = edges.col(i).squaredNorm();
    cotangents[i] = -dot(edges.col((i + 1) % 3), edges.col((i + 2) % 3)) / double_area;
  }
  // k_i / 2 on the diagonal, c_ij / 2 beside it.
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double sign = i == j ? 1 : -1;
      membrane.modulus(i, j) =
          (2 * cotangents[i] * cotangents[j] * (lambda + mu) + sign * mu) / (16 * double_area);
    }
  }
  return membrane;
}

Mat9 membrane_stiffness(const TriangleMembrane& membrane, const Nodes3& x, const Nodes3& v,
                        bool pull_only) {
  const Nodes3 edges = opposite_edges(x);
  Vec3 tensions = edge_tensions(membrane, edges, v);
  if (pull_only) tensions = tensions.cwiseMax(0);
  Mat9 result = material_stiffness(membrane.modulus, edges);
  // d^2 q_i / dx dx is 2 I on the diagonal of either end of edge i and -2 I between them.
  for (int i = 0; i < 3; ++i) {
    const int start = 3 * ((i + 1) % 3);
    const int end = 3 * ((i + 2) % 3);
    for (int axis = 0; axis < 3; ++axis) {
      result(start + axis, start + axis) += 2 * tensions[i];
      result(end + axis, end + axis) += 2 * tensions[i];
      result(start + axis, end + axis) -= 2 * tensions[i];
      result(end + axis, start + axis) -= 2 * tensions[i];
    }
  }
  return result;
}

Mat9 membrane_damping(const TriangleMembrane& membrane, const Nodes3& x) {
  return material_stiffness(membrane.damping_time * membrane.modulus, opposite_edges(x));
}

}  // namespace weft::materials
