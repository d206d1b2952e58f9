// The check of an initial state.
#pragma once

#include "sim/scene/scene.h"

namespace weft::sim {

// Throws CaseError, with a list of the pairs, for an initial state whose surfaces intersect or
// leave no gap, and for a rest shape whose own features lie within contact range of each other.
void check_initial_state(const Scene& scene);

}  // namespace weft::sim
