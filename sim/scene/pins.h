// The vertices that a pin, a tie or a load of a case file selects.
#pragma once

#include <Eigen/Geometry>
#include <span>
#include <string>
#include <vector>

#include "sim/case/case.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// Returns the particles of an image (sorted, each once) that a case file selects by corners, edges,
// ranges of rows and columns, or a box. Several selectors select the union of their vertices. A
// range of rows together with a range of columns selects the block where both meet. The box selects
// the vertices whose `points` of the surface (m, by particle) it holds. Throws CaseError at `where`
// if the image lacks the patch, a range lies outside it, a selected corner or edge does not exist
// because an axis is closed, or nothing is selected. `owner` names the selecting table in messages:
// "pin", "tie" or "load".
std::vector<int> select_vertices(const VertexSelection& vertices, const SourceLocation& where,
                                 const std::string& owner, const bsi::Atlas& atlas,
                                 std::span<const Vec3> points);
// Returns the box that a case file gives, with a margin of 1e-9 of the size of a body with these
// `points`: points on a face of the box are then in it, whatever rounding says.
Eigen::AlignedBox3d selecting_box(const Vec3& lowest, const Vec3& highest,
                                  std::span<const Vec3> points);
// Selects particles of a body (local indices). `positions` are those of its particles, m. The
// points of a shell are those of its image, because its control points lie beside the surface.
std::vector<int> select_vertices(const VertexSelection& vertices, const SourceLocation& where,
                                 const std::string& owner, const SceneBody& body,
                                 std::span<const Vec3> positions);
inline std::vector<int> select_pinned(const PinCase& pin, const SceneBody& body,
                                      std::span<const Vec3> positions) {
  return select_vertices(pin.vertices, pin.location, "pin", body, positions);
}

}  // namespace weft::sim
