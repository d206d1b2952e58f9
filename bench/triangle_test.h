// The exact test of candidates, one by one in float64: what libraries without one of their own are
// given.
#pragma once

#include <array>
#include <span>

#include "bsi/geometry_image.h"
#include "bsi/leaf_pair.h"

namespace weft::bench {

using Triangle = std::array<bsi::Vec3, 3>;

// Whether the triangles come within `distance` (metres, > 0) of each other, intersecting or not.
// Planes of either, or through its edges across it, that the other keeps away from settle most
// pairs; the first of the distances of vertices and triangles, of edges and edges that is small
// enough settles the others.
bool triangles_within(const Triangle& a, const Triangle& b, double distance);

// Positions and triangles of a body; particles have no triangles.
struct TriangleBody {
  std::span<const bsi::Vec3> positions;
  std::span<const std::array<int, 3>> triangles;
};

// How many of the pairs come within the distance. Of particles (the first body) their distance from
// the triangles.
long count_hits(const TriangleBody& first, const TriangleBody& second,
                std::span<const bsi::LeafPair> pairs, double distance);

}  // namespace weft::bench
