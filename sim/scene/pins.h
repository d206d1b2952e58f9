// The vertices that a pin or a tie of a case file names.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "bsi/geometry_image.h"
#include "sim/case/case.h"

namespace weft::sim {

// Returns the particles of the body (local indices, sorted, each once) that corners, edges, ranges
// of rows and columns, or the box select. Row and column ranges together select the block where
// they meet; several selectors add up. Throws CaseError at `where` if a range lies outside the
// image, a closed axis has no such edge, or nothing is selected; `owner`, "pin" or "tie", is then
// named.
std::vector<int> select_vertices(const VertexSelection& vertices, const SourceLocation& where,
                                 const std::string& owner, const bsi::Atlas& atlas,
                                 std::span<const Vec3> positions);
inline std::vector<int> select_pinned(const PinCase& pin, const bsi::Atlas& atlas,
                                      std::span<const Vec3> positions) {
  return select_vertices(pin.vertices, pin.location, "pin", atlas, positions);
}

}  // namespace weft::sim
