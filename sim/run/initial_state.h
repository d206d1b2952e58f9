// The check of a scene's initial state.
#pragma once

#include "sim/scene/scene.h"

namespace weft::sim {

// Throws CaseError if surfaces intersect or touch in the initial state. Obstacles may intersect
// each other, and a body without self_contact may intersect itself. The message lists the first
// intersections. Also throws CaseError if features of one body with self_contact that share no
// vertex are closer than thickness + contact.range. Does nothing if contact is disabled.
void check_initial_state(const Scene& scene);

}  // namespace weft::sim
