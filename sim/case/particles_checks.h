// Checks of particles, of their method and of contact between named partners.
#pragma once

#include "sim/case/case.h"
#include "sim/case/case_locations.h"

namespace weft::sim {

// Throws CaseError for a case that simulates nothing, for particles or bodies that the method does
// not simulate, for places that cannot hold the particles, and for pairs whose names are unknown,
// are both obstacles or are listed twice.
void check_particles(const Case& target, const Locations& locations);

}  // namespace weft::sim
