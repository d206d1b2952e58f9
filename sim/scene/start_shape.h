// The shape of a body at t = 0.
#pragma once

#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// Returns the positions (m) of a body's particles at t = 0, in the frame of its shape, before
// stretch and rotation. They come from body.start, or from the rest shape if the case has no
// body.start. Throws CaseError at start.shape if its image differs from the image of the rest shape
// in size, closed axes or seams. Also throws as build_shape() does.
std::vector<Vec3> start_shape(const BodyCase& from, const SceneBody& body, const Case& source);

// Bends points (m) onto a cylinder of radius R. `direction_deg` (degrees, from the x-axis) is the
// direction in the x-y plane in which the points are bent. s is the coordinate of a point in this
// direction, from the middle of the points' extent, and z its height. The point moves to
//   s' = (R - z) sin(s / R),  z' = R - (R - z) cos(s / R)
// and keeps its coordinate along the cylinder's axis. Lengths in the plane z = 0 do not change.
// Precondition: R is not 0; a negative R bends downwards.
std::vector<Vec3> bend(const std::vector<Vec3>& points, double radius, double direction_deg);

}  // namespace weft::sim
