// The spheres of the pyramids of bodies, to look at. For rendered_body.cpp.
#pragma once

#include <vector>

#include "sim/view/rendered_body.h"

namespace weft::sim {

// Makes RenderedBody::spheres and touching_spheres of one level of the pyramids, which are built
// and hold spheres; of the last level of a patch that has fewer. A sphere touches where it meets
// one of another body: any sphere meets its neighbours.
void surround_bodies(int level, std::vector<RenderedBody>& bodies);

}  // namespace weft::sim
