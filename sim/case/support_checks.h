// Checks loads, and pins that hold only some directions.
#pragma once

#include "sim/case/case.h"
#include "sim/case/case_locations.h"

namespace weft::sim {

// Throws CaseError for a load that names no body, selects nothing, or selects a place on which its
// type cannot act. Also throws it for a pin whose directions cannot be held.
void check_loads_and_supports(const Case& target, const Locations& locations);

}  // namespace weft::sim
