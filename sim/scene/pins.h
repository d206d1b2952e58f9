// The vertices that a pin of a case file names.
#pragma once

#include <span>
#include <vector>

#include "bsi/geometry_image.h"
#include "sim/case/case.h"

namespace weft::sim {

// Returns the particles of the body (local indices, sorted, each once) that corners, edges, ranges
// of rows and columns, or the box select. Row and column ranges together select the block where
// they meet; several selectors add up. Throws CaseError if a range lies outside the image, a closed
// axis has no such edge, or nothing is selected.
std::vector<int> select_pinned(const PinCase& pin, const bsi::Atlas& atlas,
                               std::span<const Vec3> positions);

}  // namespace weft::sim
