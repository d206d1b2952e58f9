#include "materials/orthotropic_membrane.h"

#include <Eigen/LU>
#include <cassert>

namespace weft::materials {

Mat3 green_strain_map(const Nodes3& rest, const Vec3& warp) {
  const Nodes3 edges = opposite_edges(rest);
  const Vec3 normal = edges.col(0).cross(edges.col(1)).normalized();
  const Vec3 first = (warp - normal.dot(warp) * normal).normalized();
  const Vec3 second = normal.cross(first);
  Mat3 squares;
  for (int i = 0; i < 3; ++i) {
    const double a = first.dot(edges.col(i)), b = second.dot(edges.col(i));
    squares.row(i) << 2 * a * a, 2 * b * b, 2 * a * b;
  }
  return squares.inverse();
}

OrthotropicMembrane make_orthotropic_membrane(const Nodes3& rest, const Vec3& warp,
                                              const OrthotropicModuli& moduli,
                                              double damping_time) {
  const Nodes3 edges = opposite_edges(rest);
  const double area = 0.5 * edges.col(0).cross(edges.col(1)).norm();
  assert(area > 0);
  const Mat3 map = green_strain_map(rest, warp);
  const Mat3 modulus = area * map.transpose() * moduli.matrix() * map;
  OrthotropicMembrane membrane;
  membrane.damping_time = damping_time;
  membrane.rest_squared_length = squared_lengths(edges);
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) membrane.edge_modulus(i, j) = modulus(i, j);
  }
  return membrane;
}

}  // namespace weft::materials
