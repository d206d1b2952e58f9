// The exact test of candidates, one at a time in float64, for libraries without their own.
#pragma once

#include <array>
#include <span>

#include "bsi/geometry_image.h"
#include "bsi/leaf_pair.h"

namespace weft::bench {

using Triangle = std::array<bsi::Vec3, 3>;

// True if the triangles come within `distance` (m, > 0) of each other, intersecting or not. Most
// pairs are settled by a separating plane: that of either triangle, or one perpendicular to it
// through an edge. The others are settled by the first small distance between a vertex and a
// triangle, or between two edges.
bool triangles_within(const Triangle& a, const Triangle& b, double distance);

// Positions and triangles of a body; particles have no triangles.
struct TriangleBody {
  std::span<const bsi::Vec3> positions;
  std::span<const std::array<int, 3>> triangles;
};

// Returns the number of pairs within the distance. If the first body consists of particles, it
// counts their distances from the triangles.
long count_hits(const TriangleBody& first, const TriangleBody& second,
                std::span<const bsi::LeafPair> pairs, double distance);

}  // namespace weft::bench
