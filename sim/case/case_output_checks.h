// Checks the rules of [output], between its keys and with the rest of the case.
#pragma once

#include "sim/case/case.h"
#include "sim/case/case_locations.h"

namespace weft::sim {

// Throws CaseError, placed at the value that breaks a rule.
void check_output(const Case& target, const Locations& locations);

}  // namespace weft::sim
