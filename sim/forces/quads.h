// The quads of geometry images, each split into two triangles.
#pragma once

#include <array>

#include "materials/types.h"
#include "sim/scene/scene.h"

namespace weft::sim {

using Quad = std::array<int, 4>;
// Nodes of the two triangles of a quad, as indices into its corners. The triangles are those of
// bsi::quad_triangles().
inline constexpr std::array<std::array<int, 3>, 2> corners_of = {{{0, 1, 2}, {1, 3, 2}}};

// Returns the particles at the corners of a quad of a body (local indices): (r,c), (r,c+1),
// (r+1,c), (r+1,c+1).
inline Quad quad_corners(const SceneBody& body, int quad) {
  const auto* triangles = &body.mesh.triangles[2 * static_cast<std::size_t>(quad)];
  return {triangles[0][0], triangles[0][1], triangles[0][2], triangles[1][1]};
}
inline int quad_count(const SceneBody& body) {
  return static_cast<int>(body.mesh.triangles.size() / 2);
}

template <class Real>
materials::NodesOf<Real, 3> triangle_nodes(const materials::NodesOf<Real, 4>& corners,
                                           int triangle) {
  materials::NodesOf<Real, 3> nodes;
  for (int i = 0; i < 3; ++i) nodes.col(i) = corners.col(corners_of[triangle][i]);
  return nodes;
}

}  // namespace weft::sim
