// Exact count of surfaces that pass through each other: the referee, which shares no code with
// contact.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bsi/geometry_image.h"

namespace weft::sim {

struct CrossingSurface {
  std::span<const bsi::Vec3> positions;           // by particle
  std::span<const std::array<int, 3>> triangles;  // particle indices
  bool check_self = true;
};

struct Crossing {
  int surface_a = 0, triangle_a = 0;
  int surface_b = 0, triangle_b = 0;
};

// Pairs of triangles (of two surfaces, or of one and sharing no particle) that intersect, counted
// with exact arithmetic where rounding could decide. Touching counts as intersecting. O(n log n)
// for scattered triangles.
std::vector<Crossing> find_crossings(std::span<const CrossingSurface> surfaces);

}  // namespace weft::sim
