// Spheres of bodies' pyramids, and surfaces that represent them.
#pragma once

#include <vector>

#include "sim/view/rendered_body.h"

namespace weft::sim {

// Sets RenderedBody::spheres and RenderedBody::touching_spheres of all bodies, for one level of
// their pyramids. A patch with fewer levels uses its last level. Precondition: the pyramids are
// built and hold spheres.
void surround_bodies(int level, std::vector<RenderedBody>& bodies);

// Sets RenderedBody::spheres of a group of particles, which are its particles at the present
// positions.
void draw_particles(RenderedBody& body);

// Returns the spheres of one level of a body's pyramid. A patch with fewer levels uses its last
// level. Precondition: the pyramid is built and holds spheres.
std::vector<bsi::Sphere> spheres_of_level(const bsi::Pyramid& pyramid, int level);

}  // namespace weft::sim
