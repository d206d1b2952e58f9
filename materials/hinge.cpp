#include "materials/hinge.h"

#include <array>

namespace weft::materials {

namespace {

using Vec9 = Eigen::Matrix<double, 9, 1>;

Vec9 per_node(const Vec3& weights, const Vec3& vector) {
  Vec9 result;
  result << weights[0] * vector, weights[1] * vector, weights[2] * vector;
  return result;
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
Mat9 triangle_part(const Vec3& edge, const Vec3& arm, const Vec3& normal) {
  const double squared_edge = edge.squaredNorm();
  const double length = std::sqrt(squared_edge);
  const double double_area = normal.norm();
  const double height = double_area / length;
  const double foot = edge.dot(arm) / squared_edge;
  const Vec3 unit_normal = normal / double_area;
  const Vec3 unit_edge = edge / length;
  const Vec3 inward = unit_normal.cross(unit_edge);
  const Vec3 lever(foot - 1, -foot, 1);
  const Vec3 along(-1, 1, 0);
  const Vec9 lever_normal = per_node(lever, unit_normal);
  const Vec9 along_normal = per_node(along, unit_normal);
  const Vec9 lever_inward = per_node(lever, inward / (height * height));
  const Vec9 mixed =
      per_node(lever, unit_edge / (height * length)) + per_node(along, inward / (2 * squared_edge));
  Mat9 result;
  for (int column = 0; column < 9; ++column) {
    result.col(column) = -lever_inward[column] * lever_normal -
                         lever_normal[column] * lever_inward - mixed[column] * along_normal -
                         along_normal[column] * mixed;
  }
  return result;
}

}  // namespace

Mat12 hinge_hessian(const Nodes4& x) {
  const HingeVectors h = hinge_vectors(x);
  Mat12 hessian = Mat12::Zero();
  if (h.flat_triangle) return hessian;
  hessian.topLeftCorner<9, 9>() = triangle_part(h.edge, h.arm2, h.normal2);
  // The second triangle runs x1 -> x0 -> x3.
  const Mat9 part = triangle_part(-h.edge, x.col(3) - x.col(1), h.normal3);
  constexpr std::array<int, 3> nodes = {1, 0, 3};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      hessian.block<3, 3>(3 * nodes[i], 3 * nodes[j]) += part.block<3, 3>(3 * i, 3 * j);
    }
  }
  return hessian;
}

}  // namespace weft::materials
