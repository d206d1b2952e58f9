#include "materials/bending.h"

#include <cassert>

#include "materials/membrane.h"

namespace weft::materials {

namespace {

// Condenses C by setting t_k to the value that minimises 1/2 t^T C t: the Schur complement of C_kk.
// C_kk > 0 if the curvature energy is positive definite, as -1 < nu < 1 ensures.
Mat3 condensed(const Mat3& modulus, int k) {
  Mat3 result = modulus - modulus.col(k) * (modulus.row(k) / modulus(k, k));
  result.row(k).setZero();
  result.col(k).setZero();
  return result;
}

}  // namespace

Mat3 triangle_bending_modulus(const Nodes3& rest, const std::array<bool, 3>& has_angle,
                              double stiffness, double poisson_ratio) {
  assert(stiffness >= 0 && poisson_ratio > -1 && poisson_ratio < 1);
  if (stiffness == 0) return Mat3::Zero();
  const Nodes3 edges = opposite_edges(rest);
  const double double_area = edges.col(0).cross(edges.col(1)).norm();
  assert(double_area > 0);
  // With g_i = m_i m_i^T / h_i: g_i : g_j = (m_i . m_j)^2 / (h_i h_j) and tr g_i = 1 / h_i. The m_i
  // are the unit edges rotated by a right angle, so their products are those of the unit edges.
  const Vec3 lengths = edges.colwise().norm();
  Mat3 modulus;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double cosine = edges.col(i).dot(edges.col(j)) / (lengths[i] * lengths[j]);
      modulus(i, j) = stiffness * lengths[i] * lengths[j] / (2 * double_area) *
                      ((1 - poisson_ratio) * cosine * cosine + poisson_ratio);
    }
  }
  int angles = 0;
  for (int i = 0; i < 3; ++i) {
    if (has_angle[i]) {
      ++angles;
    } else {
      modulus = condensed(modulus, i);
    }
  }
  if (angles == 0) return Mat3::Zero();
  return modulus;
}

}  // namespace weft::materials
