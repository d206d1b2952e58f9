// Checks of particles and of their method.
#pragma once

#include "sim/case/case.h"
#include "sim/case/case_locations.h"

namespace weft::sim {

// Throws CaseError for a case that simulates nothing, for particles or bodies that the method does
// not simulate, for particles that the method does not turn, for a restart or an accuracy of
// particles, and for places that cannot hold the particles.
void check_particles(const Case& target, const Locations& locations);

}  // namespace weft::sim
