// The quads of cloth that resists bending, with the laws of their triangles over the angles of
// their edges.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "materials/strain_map.h"
#include "sim/forces/quad_hinges.h"
#include "sim/forces/varying_numbers.h"
#include "sim/scene/scene.h"

namespace weft::sim {

struct BendingQuads {
  std::vector<std::array<int, QuadSurroundings::count>> nodes;
  // The modulus of each triangle over its hinges or, where it depends on the curvature, its map
  // from the angles to the curvature.
  std::vector<std::array<materials::Mat3, 2>> moduli;
  std::vector<std::array<materials::StrainMapOf<double>, 2>> maps;
  VaryingNumbers damping_times;  // s
  bool is_damped = false;        // at any time
};

// Collects the quads of the dynamic bodies whose materials are selected, body by body. Triangles at
// clamps have no stiffness: clamps bend those.
BendingQuads bending_quads(const Scene& scene,
                           const std::function<bool(const MaterialCase& material)>& selects);

}  // namespace weft::sim
