#include "sim/scene/clamps.h"

#include <algorithm>

#include "sim/case/case_error.h"
#include "sim/scene/scene.h"

namespace weft::sim {

std::vector<ClampedEdge> find_clamped_edges(const SceneBody& body, std::span<const int> held,
                                            std::span<const Vec3> position, const RigidPose& pose) {
  std::vector<ClampedEdge> edges;
  const auto& triangles = body.mesh.triangles;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto node = [&](int i) { return body.first_particle + triangles[t][i % 3]; };
    const auto is_held = [&](int i) { return std::ranges::binary_search(held, node(i)); };
    for (int i = 0; i < 3; ++i) {
      if (is_held(i) || !is_held(i + 1) || !is_held(i + 2)) continue;
      const Vec3 ghost = position[node(i + 1)] + position[node(i + 2)] - position[node(i)];
      edges.push_back({static_cast<int>(t), i, pose.start_of(ghost)});
    }
  }
  return edges;
}

std::vector<ClampedBy> clamped_edges_of(const Scene& scene, int body) {
  std::vector<ClampedBy> edges;
  for (const PrescribedMotion& held : scene.prescribed) {
    if (held.clamped.empty() || scene.body_index_of_particle(held.particles.front()) != body)
      continue;
    for (const ClampedEdge& edge : held.clamped) edges.push_back({&held, &edge});
  }
  std::ranges::stable_sort(edges, {}, [](const ClampedBy& each) { return each.edge->triangle; });
  return edges;
}

std::vector<char> triangles_at_clamps(const Scene& scene, int body) {
  const auto& triangles = scene.bodies[body].mesh.triangles;
  std::vector<char> marks;
  for (const ClampedBy& each : clamped_edges_of(scene, body)) {
    marks.resize(triangles.size(), 0);
    marks[each.edge->triangle] = 1;
  }
  if (marks.empty()) return marks;
  for (const PrescribedMotion& held : scene.prescribed) {
    if (held.clamped.empty()) continue;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      marks[t] |= static_cast<char>(std::ranges::all_of(triangles[t], [&](int node) {
        return std::ranges::binary_search(held.particles, scene.bodies[body].first_particle + node);
      }));
    }
  }
  return marks;
}

std::vector<char> triangles_at_edges(const Scene& scene, int body) {
  std::vector<char> marks = triangles_at_clamps(scene, body);
  for (const SeamFold* fold : seam_folds_of(scene, body)) {
    marks.resize(scene.bodies[body].mesh.triangles.size(), 0);
    marks[fold->triangle] = 1;
  }
  return marks;
}

void require_clamped_edges(const PinCase& pin, const std::vector<ClampedEdge>& edges) {
  if (!pin.clamp || !edges.empty()) return;
  throw CaseError(pin.location, "this clamp holds no edge of the surface",
                  "expected a pin that holds neighbouring vertices, with free ones beside them");
}

}  // namespace weft::sim
