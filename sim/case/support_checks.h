// Checks loads, and pins that hold only some directions.
#pragma once

#include "sim/case/case.h"
#include "sim/case/case_locations.h"

namespace weft::sim {

// Throws CaseError for a load that names no body, for a type of load that the body does not allow,
// and for selectors that do not suit the type of a load. Also throws it for a pin with faulty
// `axes` or `symmetry_normal`, or with one of these keys where the body does not allow it.
void check_loads_and_supports(const Case& target, const Locations& locations);

}  // namespace weft::sim
