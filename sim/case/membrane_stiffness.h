// The stiffness of cloth in its plane, whatever its law.
#pragma once

#include "sim/case/case.h"

namespace weft::sim {

// Returns the largest stiffness of cloth in its plane, N/m: of triangles, or of springs along rows
// and columns. Precondition: its curves are valid (fabric_checks.h).
double largest_membrane_stiffness(const MaterialCase& material);

}  // namespace weft::sim
