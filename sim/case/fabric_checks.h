// Checks of materials whose stiffness depends on the direction.
#pragma once

#include "sim/case/case_locations.h"

namespace weft::sim {

// Checks the tables orthotropic_membrane, measured_membrane and orthotropic_bending of all
// materials of `target`. Throws CaseError at the first value that breaks a rule, or at the header
// of a table that lacks a key.
void check_fabrics(const Case& target, const Locations& locations);

}  // namespace weft::sim
