// The speed at which spheres may hit something.
#pragma once

#include "sim/scene/scene.h"

namespace weft::sim {

// Returns the largest speed (m/s) that is expected when spheres of the scene hit other bodies: that
// of a fall, from the start, to the lowest place of the scene, with the largest speed at the start,
// the largest speed of pins and obstacles, and that of the wind, if it acts on a body. Gravity
// counts as it is when it would make the deepest fall. At least 0.5 m/s, for particles at rest
// without gravity. Precondition: the scene has all its bodies, motions and timed pins. O(particles
// + keyframes).
double expected_impact_speed(const Scene& scene);

}  // namespace weft::sim
