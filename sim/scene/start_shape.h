// The shape in which a body starts.
#pragma once

#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// Returns the positions (m) of a body's particles at the start, in the frame of its shape, before
// stretch and rotation. They are those of body.start, or of the rest shape if there is none. Throws
// CaseError at the place of start.shape if its image is not like that of the rest shape, and as
// build_shape().
std::vector<Vec3> start_shape(const BodyCase& from, const SceneBody& body, const Case& source);

// Bends points (m) onto a cylinder. Let s be the coordinate of a point along the direction in the
// x-y plane, from the middle of the body's extent, and z its height. The point moves to
//   s' = (R - z) sin(s / R),  z' = R - (R - z) cos(s / R)
// and keeps its coordinate along the cylinder's axis. Lengths in the plane z = 0 do not change.
// Precondition: the radius R is not 0.
std::vector<Vec3> bend(const std::vector<Vec3>& points, double radius, double direction_deg);

}  // namespace weft::sim
