// Checks of contact between named partners ([[contact.pair]]).
#pragma once

#include "sim/case/case.h"
#include "sim/case/case_locations.h"

namespace weft::sim {

// Throws CaseError for a pair whose names are unknown, stand for a body and a material at once, mix
// both, are both obstacles or were paired before. Also throws for a pair of cloth that has no
// friction, or a restitution. Preconditions: names are unique among bodies, obstacles and
// particles, and time.method suits them.
void check_contact_pairs(const Case& target, const Locations& locations);

}  // namespace weft::sim
