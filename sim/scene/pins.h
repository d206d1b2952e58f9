// The vertices that a pin, a tie or a load of a case file selects.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "bsi/geometry_image.h"
#include "sim/case/case.h"

namespace weft::sim {

// Returns the particles of the body (local indices, sorted, each once) that the selectors name:
// corners, edges, ranges of rows and columns, and the box. Several selectors select the union of
// their vertices. A range of rows together with one of columns selects the block where they meet.
// `positions` (m, by particle) are compared with the box. Throws CaseError at `where` if the body
// lacks the patch, a range lies outside the image, a closed axis has no such corner or edge, or
// nothing is selected. `owner` is the name in the message: "pin", "tie" or "load".
std::vector<int> select_vertices(const VertexSelection& vertices, const SourceLocation& where,
                                 const std::string& owner, const bsi::Atlas& atlas,
                                 std::span<const Vec3> positions);
inline std::vector<int> select_pinned(const PinCase& pin, const bsi::Atlas& atlas,
                                      std::span<const Vec3> positions) {
  return select_vertices(pin.vertices, pin.location, "pin", atlas, positions);
}

}  // namespace weft::sim
