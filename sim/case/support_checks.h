// Checks loads, and pins that hold only some directions.
#pragma once

#include "sim/case/case.h"
#include "sim/case/case_locations.h"

namespace weft::sim {

// Throws CaseError for a load that names no body, selects nothing, or uses a selector on which its
// type cannot act. Also throws it for a pin with `axes` or `symmetry_normal` that contradicts the
// rest of its body.
void check_loads_and_supports(const Case& target, const Locations& locations);

}  // namespace weft::sim
