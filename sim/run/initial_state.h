// The check of an initial state.
#pragma once

#include "sim/scene/scene.h"

namespace weft::sim {

// Throws CaseError for an initial state in which surfaces intersect or have no gap, and lists the
// places. Also throws it if features of one body that share no vertex lie within contact range.
// Does nothing without contact.
void check_initial_state(const Scene& scene);

}  // namespace weft::sim
