// The vertices that a pin of a case file names.
#pragma once

#include <span>
#include <vector>

#include "bsi/geometry_image.h"
#include "sim/case/case.h"

namespace weft::sim {

// Particles of the body (local indices, sorted, each once) named by corners, edges, row and column
// ranges (both given: where they meet) or the box; several selectors add up. Throws CaseError when
// a range lies outside the image, a wrapped axis has no such edge, or nothing is selected.
std::vector<int> select_pinned(const PinCase& pin, const bsi::Atlas& atlas,
                               std::span<const Vec3> positions);

}  // namespace weft::sim
