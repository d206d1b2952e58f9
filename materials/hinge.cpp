#include "materials/hinge.h"

#include <array>

namespace weft::materials {

namespace {

// Columns of outer products over the nodes of a hinge, four pairs of them: the Hessian is minus the
// sum of left_k right_k^T + right_k left_k^T. One product of tall matrices is faster than its
// blocks.
using Factors = Eigen::Matrix<double, 12, 8>;

void add_to_factor(Factors& factors, int column, const std::array<int, 3>& nodes,
                   const Vec3& weights, const Vec3& vector) {
  for (int i = 0; i < 3; ++i) factors.block<3, 1>(3 * nodes[i], column) += weights[i] * vector;
}

// The part of the Hessian that triangle (p, q, r) with the hinge edge p -> q gives. With the unit
// normal N, the unit edge e of length l, the in-plane unit vector m from the edge to r, the height
// h of r, the foot t of that height, w = (t - 1, -t, 1) and s = (-1, 1, 0), the gradient is w_i N /
// h,
//   dN = -(m/h) N.D - (e/l) N.d(q - p), dh = m.D, dt = e.D / l + h/l^2 m.d(q - p), D = sum w_j
//   dx_j,
// so block (i, j) is -w_i w_j/h^2 (m N^T + N m^T) - (s_i w_j N e^T + w_i s_j e N^T)/(h l)
// - s_i s_j/l^2 N m^T. The last term alone is not symmetric, but its sum over both triangles is, so
// each may give its symmetric part.
void add_triangle(const std::array<int, 3>& nodes, const Vec3& edge, const Vec3& arm,
                  const Vec3& normal, int column, Factors& left, Factors& right) {
  const double length = std::sqrt(squared_norm(edge));
  const double double_area = std::sqrt(squared_norm(normal));
  const double inverse_height = length / double_area;
  const double inverse_length = 1 / length;
  const Vec3 unit_normal = normal / double_area;
  const Vec3 unit_edge = edge * inverse_length;
  const Vec3 inward = unit_normal.cross(unit_edge);
  const double foot = dot(edge, arm) * inverse_length * inverse_length;
  const Vec3 lever(foot - 1, -foot, 1);
  const Vec3 along(-1, 1, 0);
  add_to_factor(left, column, nodes, lever, unit_normal);
  add_to_factor(right, column, nodes, lever, inward * (inverse_height * inverse_height));
  add_to_factor(left, column + 1, nodes, along, unit_normal);
  add_to_factor(right, column + 1, nodes, lever, unit_edge * (inverse_height * inverse_length));
  add_to_factor(right, column + 1, nodes, along, inward * (0.5 * inverse_length * inverse_length));
}

}  // namespace

Mat12 hinge_hessian(const Nodes4& x) {
  const HingeVectors h = hinge_vectors(x);
  if (h.flat_triangle) return Mat12::Zero();
  Factors left = Factors::Zero();   // and the right ones again in its second half
  Factors right = Factors::Zero();  // and the left ones
  add_triangle({0, 1, 2}, h.edge, h.arm2, h.normal2, 0, left, right);
  // The second triangle runs x1 -> x0 -> x3.
  add_triangle({1, 0, 3}, -h.edge, x.col(3) - x.col(1), h.normal3, 2, left, right);
  left.rightCols<4>() = right.leftCols<4>();
  right.rightCols<4>() = left.leftCols<4>();
  return -left.lazyProduct(right.transpose());
}

}  // namespace weft::materials
