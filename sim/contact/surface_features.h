// Vertices, edges and triangles of a body's surface as indices of surface points.
#pragma once

#include <array>
#include <span>

#include "bsi/proximity.h"
#include "sim/contact/contact_search.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// Converts the numbers of features in a body's mesh to indices of surface points of the scene. Each
// sphere of a group of particles counts as a quad and a triangle, whose corners are its centre.
class SurfaceFeatures {
 public:
  explicit SurfaceFeatures(const SceneBody& body)
      : mesh_(body.surface_mesh()), first_(body.first_point), spheres_(body.spheres != nullptr) {}

  const bsi::Mesh& mesh() const { return mesh_; }
  bool are_spheres() const { return spheres_; }
  int vertex(int v) const { return v + first_; }
  std::array<int, 2> edge(int e) const {
    const auto& [a, b] = mesh_.edges[e].vertex;
    return {a + first_, b + first_};
  }
  std::array<int, 3> triangle(int t) const {
    if (spheres_) return {t + first_, t + first_, t + first_};
    const auto& [a, b, c] = mesh_.triangles[t];
    return {a + first_, b + first_, c + first_};
  }

 private:
  const bsi::Mesh& mesh_;
  int first_;
  bool spheres_;
};

// Returns the points of a pair from a candidate list: a vertex and a triangle, or two edges.
inline std::array<int, 4> points_of(bool edges, const SurfaceFeatures& first,
                                    const SurfaceFeatures& second, const FeaturePair& pair) {
  if (edges) {
    const auto [a, b] = first.edge(pair.a);
    const auto [c, d] = second.edge(pair.b);
    return {a, b, c, d};
  }
  const auto [a, b, c] = second.triangle(pair.b);
  return {first.vertex(pair.a), a, b, c};
}

// Returns the closest points of a pair of surface points.
inline bsi::Closest closest_of(bool edges, const std::array<int, 4>& nodes,
                               std::span<const Vec3> x) {
  return edges ? bsi::closest_edge_edge(x[nodes[0]], x[nodes[1]], x[nodes[2]], x[nodes[3]])
               : bsi::closest_vertex_triangle(x[nodes[0]], x[nodes[1]], x[nodes[2]], x[nodes[3]]);
}

}  // namespace weft::sim
