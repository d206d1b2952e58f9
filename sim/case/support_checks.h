// Checks loads, and pins that hold only some directions.
#pragma once

#include "sim/case/case.h"
#include "sim/case/case_locations.h"

namespace weft::sim {

// Throws CaseError for a load that names no body, selects nothing, or uses a selector that its type
// does not allow. Also throws it for a pin whose `axes` or `symmetry_normal` its body does not
// allow.
void check_loads_and_supports(const Case& target, const Locations& locations);

}  // namespace weft::sim
