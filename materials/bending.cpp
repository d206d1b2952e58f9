#include "materials/bending.h"

#include <cassert>

#include "materials/membrane.h"

namespace weft::materials {

namespace {

// Returns C after elimination of t_k: the Schur complement of C_kk, with a zero row and column k.
// It belongs to the t_k that minimises 1/2 t^T C t. Precondition: C_kk > 0.
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
  // With g_i = m_i m_i^T / h_i, the entries follow from g_i : g_j = (m_i . m_j)^2 / (h_i h_j) and
  // tr g_i = 1 / h_i. Each m_i is a unit edge rotated by a right angle, so m_i . m_j is the dot
  // product of two unit edges.
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

StrainMapOf<double> bending_map(const Nodes3& rest, const Vec3& warp,
                                const std::array<bool, 3>& has_angle,
                                const OrthotropicModuli& moduli) {
  const Nodes3 edges = opposite_edges(rest);
  const Vec3 area_vector = edges.col(0).cross(edges.col(1));
  const double double_area = area_vector.norm();
  assert(double_area > 0);
  const Vec3 normal = area_vector / double_area;
  const Vec3 first = (warp - normal.dot(warp) * normal).normalized();
  const Vec3 second = normal.cross(first);
  Mat3 map;
  for (int i = 0; i < 3; ++i) {
    const Vec3 outward = edges.col(i).cross(normal);  // m_i times the length l_i
    const double a = first.dot(outward), b = second.dot(outward);
    map.col(i) = Vec3(a * a, b * b, 2 * a * b) / (double_area * outward.norm());
  }
  // Border edges are eliminated one by one. The angle of edge k takes the value of least energy,
  // given the angles of the edges that are not eliminated yet.
  const Mat3 stiffness = moduli.matrix();
  for (int k = 0; k < 3; ++k) {
    if (has_angle[k]) continue;
    const Vec3 column = map.col(k);
    const double own = column.dot(stiffness * column);
    map -= column * ((column.transpose() * stiffness * map) / own);
    map.col(k).setZero();
  }
  return {map, 0.5 * double_area};
}

Mat3 triangle_bending_modulus(const Nodes3& rest, const Vec3& warp,
                              const std::array<bool, 3>& has_angle,
                              const OrthotropicModuli& moduli) {
  if (!has_angle[0] && !has_angle[1] && !has_angle[2]) return Mat3::Zero();
  const auto [map, area] = bending_map(rest, warp, has_angle, moduli);
  return area * map.transpose() * moduli.matrix() * map;
}

}  // namespace weft::materials
