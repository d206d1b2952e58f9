// Checks of the keys of cloth that depend on each other, and of seams.
#pragma once

#include "sim/case/case.h"
#include "sim/case/case_locations.h"

namespace weft::sim {

// Throws CaseError for loss factors without a frequency, limits and creases without a stiffness to
// which they belong, and seams whose sides do not exist or are not of cloth.
void check_cloth(const Case& target, const Locations& locations);

}  // namespace weft::sim
