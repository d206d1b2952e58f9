// Bending of triangles at clamped edges (sim/scene/clamps.h).
#include <algorithm>

#include "sim/forces/border_bending.h"
#include "sim/forces/force_arrays.h"

namespace weft::sim {

namespace {

bool has_clamps(const Case& source) {
  return std::ranges::any_of(source.body, [](const BodyCase& body) {
    return std::ranges::any_of(body.pin, &PinCase::clamp);
  });
}

void add_clamped_body(const Scene& scene, int b, BorderTriangles& all) {
  const SceneBody& body = scene.bodies[b];
  const std::vector<ClampedBy> edges = clamped_edges_of(scene, b);
  if (edges.empty()) return;
  const std::size_t first = all.triangles.size();
  const bsi::Mesh mesh = bsi::build_mesh(body.atlas);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const ClampedEdge& edge = *edges[e].edge;
    const bool again = e > 0 && edges[e - 1].edge->triangle == edge.triangle;
    if (!again) {
      all.triangles.push_back(border_triangle(scene, b, mesh, edge.triangle));
      join_folds(scene, all.triangles.back(), all.ghosts);
    }
    BorderTriangle& triangle = all.triangles.back();
    triangle.particles[edge.edge + 3] = no_particle;
    triangle.is_sewn[edge.edge] = false;
    triangle.ghosts[edge.edge] = all.ghosts.add(*edges[e].held, edge.ghost);
    triangle.pins[edge.edge] = edges[e].held->pin;
    triangle.factors[edge.edge] = 2;
    triangle.rest_angles[edge.edge] = 0;
    triangle.closing_times[edge.edge] = 0;
    find_laws(scene, mesh, triangle);
  }
  const Varying<double> damping = body.material->bending_damping_time();
  all.damping_times.append(static_cast<int>(all.triangles.size() - first), damping);
  all.is_damped |= !damping.is_zero();
}

}  // namespace

// Returns null only if the case has no clamps. While no clamp holds an edge of a dynamic body, the
// force has no triangles, and the trajectory still records its energy.
std::unique_ptr<Force> make_clamp_force(const Scene& scene) {
  if (!has_clamps(scene.source)) return nullptr;
  BorderTriangles all;
  for (int b = 0; b < scene.dynamic_bodies; ++b) add_clamped_body(scene, b, all);
  return make_border_bending("clamp", std::move(all), scene);
}

}  // namespace weft::sim
