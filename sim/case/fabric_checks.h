// Rules between the keys of cloth that differs by direction.
#pragma once

#include "sim/case/case_locations.h"

namespace weft::sim {

// Throws CaseError at the key of a [material.NAME.orthotropic_membrane], its curves, a
// [material.NAME.measured_membrane] or a [material.NAME.orthotropic_bending] that does not go with
// the others.
void check_fabrics(const Case& target, const Locations& locations);

}  // namespace weft::sim
