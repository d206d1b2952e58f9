// Checks of loads and of pins that hold some directions only.
#pragma once

#include "sim/case/case.h"
#include "sim/case/case_locations.h"

namespace weft::sim {

// Throws CaseError for loads that name nothing, or select what their type does not act on, and for
// pins whose directions cannot be held.
void check_loads_and_supports(const Case& target, const Locations& locations);

}  // namespace weft::sim
