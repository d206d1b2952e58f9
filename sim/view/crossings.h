// Exact detection of surfaces that pass through each other.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "bsi/geometry_image.h"

namespace weft::sim {

struct CrossingSurface {
  std::span<const bsi::Vec3> positions;           // m, one per particle, finite
  std::span<const std::array<int, 3>> triangles;  // indices into `positions`
  bool check_self = true;  // if false, pairs within this surface are not tested
};

// A pair of triangles that cross. surface_a <= surface_b holds, and triangle_a < triangle_b if both
// triangles belong to the same surface.
struct Crossing {
  int surface_a = 0, triangle_a = 0;
  int surface_b = 0, triangle_b = 0;
};

// Returns all pairs of triangles that cross: they have a point in common. The triangles belong to
// different surfaces, or to one surface with check_self. Touching and coplanar overlap count like
// piercing. A triangle without area counts as a segment or a point.
//
// Triangles of one surface that share particles always have points in common. Two triangles that
// share one particle cross only if, in one of them, the edge opposite to that particle meets the
// other triangle. Triangles that share two or three particles never cross: they have further points
// in common only if they are folded exactly flat.
//
// Every decision is the sign of an exact determinant, without rounding, for positions in the range
// of float32 (bsi/detail/exact_predicates.h). The result is sorted and does not depend on the order
// of a triangle's corners. Cost: O(n log n + p) for n triangles and p pairs of triangles whose
// bounding boxes overlap.
std::vector<Crossing> find_crossings(std::span<const CrossingSurface> surfaces);

// Returns all pairs of triangles whose bounding boxes are within `distance` (m) of each other along
// every axis, without pairs of one surface that share a particle. Sorted. Cost: that of
// find_crossings().
std::vector<Crossing> find_near_triangles(std::span<const CrossingSurface> surfaces,
                                          double distance);

}  // namespace weft::sim
