// The vertices that a pin, a tie or a load of a case file selects.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim/case/case.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// Returns the particles of a body (local indices, sorted, each once) that a case file selects by
// corners, edges, ranges of rows and columns, or a box. Several selectors select the union of their
// vertices. A range of rows together with a range of columns selects the block where both meet. The
// box selects the vertices whose points of the surface it holds at `positions` (m, by particle of
// the body). For a shell these points are those of its image, because its control points, which
// `positions` are, lie beside the surface. Throws CaseError at `where` if the body lacks the
// patch, a range lies outside the image, a selected corner or edge does not exist because an axis
// is closed, or nothing is selected. `owner` names the selecting table in messages: "pin", "tie" or
// "load".
std::vector<int> select_vertices(const VertexSelection& vertices, const SourceLocation& where,
                                 const std::string& owner, const SceneBody& body,
                                 std::span<const Vec3> positions);
inline std::vector<int> select_pinned(const PinCase& pin, const SceneBody& body,
                                      std::span<const Vec3> positions) {
  return select_vertices(pin.vertices, pin.location, "pin", body, positions);
}

}  // namespace weft::sim
