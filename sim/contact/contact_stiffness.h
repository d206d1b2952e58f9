// The stiffness of barriers from the areas that they stand for, and the threshold of the mollifier.
#pragma once

#include <array>
#include <span>

#include "sim/contact/contact_search.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// Returns the mean area (m^2) around the vertices of the dynamic feature of a pair, or of both
// features if both are dynamic. The resolution of obstacles therefore does not change the stiffness
// of contact. Points 0 .. split - 1 belong to the first feature.
inline double pair_area(const Scene& scene, const std::array<int, 4>& nodes, int split) {
  double sum[2] = {0, 0};
  for (int i = 0; i < 4; ++i) sum[i < split ? 0 : 1] += scene.contact_area[nodes[i]];
  sum[0] /= split;
  sum[1] /= 4 - split;
  const bool first = nodes[0] < scene.dynamic_points, second = nodes[3] < scene.dynamic_points;
  if (first && second) return 0.5 * (sum[0] + sum[1]);
  return first ? sum[0] : sum[1];
}

// Returns ContactLaw::stiffness (N/m) of a sample beside a surface. Two dynamic surfaces have
// samples that count half.
inline double sample_stiffness(const Scene& scene, const SceneBody& surface, int vertex) {
  return (surface.dynamic ? 0.5 : 1.0) * scene.source.contact.stiffness *
         scene.contact_area[vertex];
}

// Returns ContactLaw::stiffness (N/m) of a pair without a sample, whose range is shorter.
inline double pair_stiffness(const Scene& scene, const std::array<int, 4>& nodes, bool edges) {
  return scene.source.contact.stiffness / (short_range * short_range) *
         pair_area(scene, nodes, edges ? 2 : 1);
}

// Returns the threshold (m^4) of the mollifier of two edges. `rest` has the positions of all
// surface points, m.
inline double parallel_threshold(std::span<const Vec3> rest, const std::array<int, 4>& nodes) {
  const auto& [p0, p1, q0, q1] = nodes;
  return 1e-3 * (rest[p1] - rest[p0]).squaredNorm() * (rest[q1] - rest[q0]).squaredNorm();
}

}  // namespace weft::sim
