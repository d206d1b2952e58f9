// Checks the rules of equilibria, between keys of [static] and with the rest of the case.
#pragma once

#include "sim/case/case.h"
#include "sim/case/case_locations.h"

namespace weft::sim {

// Throws CaseError, placed at the value that breaks a rule.
void check_static(const Case& target, const Locations& locations);

}  // namespace weft::sim
