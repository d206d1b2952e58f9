// The stiffness of membranes of cloth.
#pragma once

#include "sim/case/case.h"

namespace weft::sim {

// Returns the largest stiffness of the membrane along warp or weft, N/m. For a spring membrane it
// is membrane_stiffness or, if larger, structural_stiffness. The curves must be valid
// (fabric_checks.h).
double largest_membrane_stiffness(const MaterialCase& material);

}  // namespace weft::sim
