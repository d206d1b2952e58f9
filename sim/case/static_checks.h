// Checks of the table [static].
#pragma once

#include "sim/case/case.h"
#include "sim/case/case_locations.h"

namespace weft::sim {

// Throws CaseError if keys of [static] contradict each other or the rest of the case. The error is
// placed at the value that breaks a rule.
void check_static(const Case& target, const Locations& locations);

}  // namespace weft::sim
