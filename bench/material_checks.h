// Materials: laws of membranes, limits of strain, damping and creases.
#pragma once

#include <vector>

#include "bench/table_part.h"

namespace weft::bench {

std::vector<CaseCheck> material_checks();

// Moduli of lattices of springs on finer and finer images, and extrapolated to cells of no size
// from an image and one of half its cells.
std::vector<CaseCheck> lattice_checks();

// The energy of triangle springs on random triangles, without a case.
TablePart triangle_springs_part();

}  // namespace weft::bench
