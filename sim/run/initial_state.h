// The check of a scene's initial state.
#pragma once

#include "sim/scene/scene.h"

namespace weft::sim {

// Throws CaseError if surfaces intersect or touch in the initial state; obstacles may intersect
// each other. The message lists the first intersections. Also throws it if features of one body
// that share no vertex are closer than thickness + contact.range. Does nothing if contact is
// disabled.
void check_initial_state(const Scene& scene);

}  // namespace weft::sim
