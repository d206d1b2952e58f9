// Distances between vertices, edges and triangles, and the first derivatives of these distances.
#pragma once

#include <array>

#include "bsi/geometry_image.h"

namespace weft::bsi {

// The four points (m) of a pair of features: a vertex and the corners of a triangle, or the ends of
// two edges.
using FourPoints = std::array<Vec3, 4>;

// The closest points of a vertex and a triangle, or of two edges, given by four points x_i (m).
// `separation` = sum_i weight[i] * x_i is the vector from the closest point of the second feature
// to that of the first. Its square is `squared_distance` (m^2). Weights sum to +1 over the first
// feature and to -1 over the second.
//
// With s = separation, the first derivative of the distance |s| is d|s|/dx_i = weight_i s/|s|. It
// does not exist at |s| = 0.
struct Closest {
  double squared_distance = 0;
  Vec3 separation = Vec3::Zero();
  std::array<double, 4> weight{};
  // Number of directions in which the closest points can slide: 0 for two vertices, 1 along one
  // edge, 2 in the interior of a triangle or of two edges.
  int free_directions = 0;
};

// Both functions need finite points whose differences are zero or between 1e-75 and 1e75 m in size.
// Products of lengths would overflow or underflow otherwise, and distances be wrong.
//
// Returns the closest points of x0 and the triangle (x1, x2, x3). weight[0] is 1. A degenerate
// triangle (sine of the corner at x1 below 1e-10) is treated as its three edges. No allocation;
// 20-30 ns.
Closest closest_vertex_triangle(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& x3);
// Returns the closest points of the edges (x0, x1) and (x2, x3). weight[0] + weight[1] is 1. On
// parallel edges (sine below 1e-10) and degenerate ones, one closest point is an end of its edge.
// At most one direction is then free. No allocation; 20-30 ns.
Closest closest_edge_edge(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& x3);

}  // namespace weft::bsi
