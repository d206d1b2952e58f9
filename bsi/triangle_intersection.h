// The intersection of two triangles, decided exactly.
#pragma once

#include <array>

#include "bsi/detail/exact_predicates.h"

namespace weft::bsi {

// A triangle as a closed set. A triangle without area is a segment or a point.
using Triangle3 = std::array<Point3, 3>;

// Returns true if two triangles have a common point.
bool triangles_meet(const Triangle3& a, const Triangle3& b);
// Returns true if two triangles with the same first corner have another common point. They have one
// if and only if the edge opposite that corner in one triangle meets the other triangle.
bool triangles_meet_beyond_corner(const Triangle3& a, const Triangle3& b);

// The kind of an intersection: none, one point, a segment (`edge`), or a part of a common plane
// with positive area (`surface`).
enum class IntersectionKind { none, point, edge, surface };

struct TriangleIntersection {
  IntersectionKind kind = IntersectionKind::none;
  std::array<Point3, 2> ends{};  // the point twice, or the ends of the edge; else unused
};

// Returns the intersection of two triangles. The kind is exact: `none` if and only if
// triangles_meet() is false. A touching corner gives a point. Triangles of one mesh that share an
// edge and are not folded onto each other give an edge. An end that is a corner of a triangle has
// exactly the coordinates of that corner. Other ends are rounded, to within 1e-14 of the size of
// the pair and an ulp of the coordinates unless the triangles meet at a grazing angle. Takes about
// 0.3 us.
TriangleIntersection intersect_triangles(const Triangle3& a, const Triangle3& b);

}  // namespace weft::bsi
