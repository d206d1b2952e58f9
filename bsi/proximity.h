// Distances between vertices, edges and triangles, and their derivatives.
#pragma once

#include <Eigen/Core>
#include <array>

#include "bsi/geometry_image.h"

namespace weft::bsi {

// The four points of a pair: a vertex and a triangle's corners, or the ends of one edge and of
// another.
using FourPoints = std::array<Vec3, 4>;

// The closest points of a vertex and a triangle, or of two edges. With the four points x_i as
// given, the vector between the closest points is separation = sum_i weight[i] * x_i, and
// squared_distance its square. The weights of each side sum to +1 and -1.
//
// The first derivative of the distance follows from the weights (d|s|/dx_i = weight_i s/|s|); the
// second needs to know how the closest points may slide: the first `free_directions` rows of
// `free_weights` say so. When x moves, the separation changes by sum_i free_weights[k][i] * x_i for
// every unit that the closest points slide along direction k. The directions are never parallel.
struct Closest {
  double squared_distance = 0;
  Vec3 separation = Vec3::Zero();
  std::array<double, 4> weight{};
  int free_directions = 0;  // 0: point-point, 1: point-edge, 2: interior
  std::array<std::array<double, 4>, 2>
      free_weights{};  // d weight / d parameter, one row a free direction
};

// x0 against the triangle (x1, x2, x3): weight[0] = 1. Degenerate triangles (a corner's sine below
// 1e-10) are treated as their edges. Finite points wanted. No allocation; 20-30 ns.
Closest closest_vertex_triangle(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& x3);
// The edge (x0, x1) against the edge (x2, x3): weight[0] + weight[1] = 1. Parallel edges (a sine
// below 1e-10) and degenerate ones give one of their closest pairs, which holds an end of an edge,
// so that at most one direction is free. Finite points wanted. No allocation; 20-30 ns.
Closest closest_edge_edge(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& x3);

using Hessian12 = Eigen::Matrix<double, 12, 12>;

// The second derivative (1/m) of the distance d = |s| itself with respect to the four points, three
// rows a point: symmetric, in general indefinite. `closest` must be that of `points`, and d > 0.
// Exact within a feature (free_directions fixed); across features d is only C1.
//
// The closest points slide so that d stays least: with F = |s|^2 / 2, slides a and directions
// e_k = sum_i f_ki x_i, the implicit function theorem gives H_F = F_xx - F_xa F_aa^-1 F_ax, and
// H = (H_F - grad d grad d^T) / d. Since s is normal to every e_k the 1/d terms that cancel can be
// taken out: with n = s/d, G = (E^T E)^-1, u_k = sum_l G_kl e_l and P the projector normal to n and
// to all e_k, block (i, j) is
//   w_i w_j P / d - sum_k (w_i f_kj u_k n^T + f_ki w_j n u_k^T) - d sum_kl f_ki G_kl f_lj n n^T,
// which stays accurate however small d is.
Hessian12 distance_hessian(const Closest& closest, const FourPoints& points);

}  // namespace weft::bsi
