// Quads of cloth that resists bending, with the bending laws of their triangles.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "materials/crease.h"
#include "materials/strain_map.h"
#include "sim/forces/quad_hinges.h"
#include "sim/forces/varying_numbers.h"
#include "sim/scene/scene.h"

namespace weft::sim {

struct BendingQuads {
  std::vector<std::array<int, QuadSurroundings::count>> nodes;  // global indices, or no_node
  // Bending moduli of a quad's triangles over the angles of their hinges, N m. Zero for triangles
  // whose stiffness depends on the curvature, and for triangles that triangles_at_clamps() marks.
  std::vector<std::array<materials::Mat3, 2>> moduli;
  // Maps from hinge angles to curvature, for triangles whose stiffness depends on the curvature.
  // Zero for other triangles, and for triangles that triangles_at_clamps() marks.
  std::vector<std::array<materials::StrainMapOf<double>, 2>> maps;
  VaryingNumbers damping_times;  // s, by quad
  bool is_damped = false;        // true if damped at any time
  // A body that yields, and its range of quads.
  struct Body {
    int case_body = 0;        // index into Case::body
    int first = 0, last = 0;  // quads [first, last)
  };
  std::vector<Body> yielding;
  // Laws of yielding of both triangles of a quad, by quad.
  std::vector<std::array<materials::YieldLaw, 2>> laws;
};

// Returns the quads of all dynamic bodies of cloth that resist bending and for which
// selects(material) is true. The order is that of the bodies. Triangles that triangles_at_edges()
// marks have zero stiffness.
BendingQuads bending_quads(const Scene& scene,
                           const std::function<bool(const MaterialCase& material)>& selects);

}  // namespace weft::sim
