// Distances between vertices, edges and triangles.
#pragma once

#include <array>

#include "bsi/geometry_image.h"

namespace weft::bsi {

// The closest points of a vertex and a triangle, or of two edges. With the four points x_i as
// given, the vector between the closest points is separation = sum_i weight[i] * x_i, and
// squared_distance its square. The weights of each side sum to +1 and -1.
//
// The first derivative of the distance follows from the weights (d|s|/dx_i = weight_i s/|s|); the
// second needs to know how the closest points may slide: `free_directions` of the columns of
// `free_weights` say so. When x moves, the closest point slides along sum_i free_weights[k][i] *
// x_i.
struct Closest {
  double squared_distance = 0;
  Vec3 separation = Vec3::Zero();
  std::array<double, 4> weight{};
  int free_directions = 0;  // 0: point-point, 1: point-edge, 2: interior
  std::array<std::array<double, 4>, 2>
      free_weights{};  // d weight / d parameter, one row a free direction
};

// x0 against the triangle (x1, x2, x3): weight[0] = 1. Degenerate triangles are treated as their
// edges.
Closest closest_vertex_triangle(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& x3);
// The edge (x0, x1) against the edge (x2, x3): weight[0] + weight[1] = 1. Parallel and degenerate
// edges give one of their closest pairs.
Closest closest_edge_edge(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& x3);

}  // namespace weft::bsi
