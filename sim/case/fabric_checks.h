// Checks of materials whose stiffness depends on the direction.
#pragma once

#include "sim/case/case_locations.h"

namespace weft::sim {

// Throws CaseError at the first key that is missing, out of order or in contradiction to another
// one. Covers the tables orthotropic_membrane, measured_membrane and orthotropic_bending of all
// materials of `target`.
void check_fabrics(const Case& target, const Locations& locations);

}  // namespace weft::sim
