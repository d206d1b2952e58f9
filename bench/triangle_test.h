// The exact test of candidates, one by one in float64, for libraries without one of their own.
#pragma once

#include <array>
#include <span>

#include "bsi/geometry_image.h"
#include "bsi/leaf_pair.h"

namespace weft::bench {

using Triangle = std::array<bsi::Vec3, 3>;

// True if the triangles come within `distance` (metres, > 0) of each other, intersecting or not.
// Most pairs are settled by a plane that separates them: that of either triangle, or one
// perpendicular to it through an edge. The others are settled by the first small distance between a
// vertex and a triangle, or between two edges.
bool triangles_within(const Triangle& a, const Triangle& b, double distance);

// Positions and triangles of a body; particles have no triangles.
struct TriangleBody {
  std::span<const bsi::Vec3> positions;
  std::span<const std::array<int, 3>> triangles;
};

// Returns how many of the pairs come within the distance. If the first body is made of particles,
// their distances from the triangles count.
long count_hits(const TriangleBody& first, const TriangleBody& second,
                std::span<const bsi::LeafPair> pairs, double distance);

}  // namespace weft::bench
