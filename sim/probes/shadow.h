// Areas of triangulated surfaces and of their shadows.
#pragma once

#include <array>
#include <span>

#include "sim/base/vectors.h"

namespace weft::sim {

// Returns the area (m^2) of the shadow that the triangles throw along an axis (0: x, 1: y, 2: z):
// the area of the union of their projections. Points (m) are finite.
//
// The result is exact but for rounding. A line sweeps over the plane of the shadow. The number of
// triangles under a point of the line changes only at the contour: borders and folds. Between the
// ends and the crossings of the contour's edges, the length under which there is a triangle is
// linear. O(triangles log + (edges of the contour + their crossings) * edges under the line).
double shadow_area(std::span<const Vec3> points, std::span<const std::array<int, 3>> triangles,
                   int axis);

// Returns the sum of the areas (m^2) of the triangles.
double surface_area(std::span<const Vec3> points, std::span<const std::array<int, 3>> triangles);

}  // namespace weft::sim
