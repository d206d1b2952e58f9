// Whether two triangles have a point in common, decided exactly.
#pragma once

#include <array>

#include "bsi/exact_predicates.h"

namespace weft::bsi {

// Triangles are closed sets; those without area are the segment or point that they are.
using Triangle3 = std::array<Point3, 3>;

// Do the triangles have a point in common?
bool triangles_meet(const Triangle3& a, const Triangle3& b);
// The same of triangles with the same first corner, which does not count: does the edge across from
// it in one meet the other triangle?
bool triangles_meet_beyond_corner(const Triangle3& a, const Triangle3& b);

}  // namespace weft::bsi
