// The spheres of bodies' pyramids as surfaces. For rendered_body.cpp.
#pragma once

#include <vector>

#include "sim/view/rendered_body.h"

namespace weft::sim {

// Makes RenderedBody::spheres and touching_spheres for one level of the pyramids, or the last level
// of a patch that has fewer. A sphere counts as touching if it meets one of another body; spheres
// of one body always meet their neighbours. Precondition: the pyramids are built and hold spheres.
void surround_bodies(int level, std::vector<RenderedBody>& bodies);

// Returns the spheres of that level of a body's pyramid. Preconditions as above.
std::vector<bsi::Sphere> spheres_of_level(const bsi::Pyramid& pyramid, int level);

}  // namespace weft::sim
