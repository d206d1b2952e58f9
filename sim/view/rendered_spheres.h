// Makes surfaces of the spheres of bodies' pyramids. For rendered_body.cpp.
#pragma once

#include <vector>

#include "sim/view/rendered_body.h"

namespace weft::sim {

// Sets RenderedBody::spheres and touching_spheres for one level of the pyramids. A patch with fewer
// levels uses its last one. A sphere is touching if it meets a sphere of another body.
// Precondition: the pyramids are built and hold spheres.
void surround_bodies(int level, std::vector<RenderedBody>& bodies);

// Returns the spheres of one level of a body's pyramid, with the same preconditions.
std::vector<bsi::Sphere> spheres_of_level(const bsi::Pyramid& pyramid, int level);

}  // namespace weft::sim
