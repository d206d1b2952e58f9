#include "sim/forces/bending_quads.h"

#include "materials/bending.h"
#include "sim/forces/crease_history.h"
#include "sim/forces/quads.h"
#include "sim/forces/stencil_layout.h"
#include "sim/scene/clamps.h"
#include "sim/scene/cloth_laws.h"

namespace weft::sim {

namespace {

using materials::Mat3;
using materials::Nodes3;

// The edges of a triangle that are hinges, and the node beyond each of them. Index i stands for the
// edge opposite node i.
struct TriangleHinges {
  std::array<bool, 3> has_angle{};
  std::array<int, 3> across{no_node, no_node, no_node};
};
TriangleHinges hinges_of(const bsi::Mesh& mesh, int triangle) {
  TriangleHinges hinges;
  for (int i = 0; i < 3; ++i) {
    const bsi::Edge& edge = mesh.edges[mesh.triangle_edges[triangle][i]];
    hinges.has_angle[i] = edge.triangle[1] >= 0;
    if (hinges.has_angle[i]) hinges.across[i] = edge.opposite[edge.triangle[0] == triangle ? 1 : 0];
  }
  return hinges;
}

// Sets the bending law of a triangle in the last quad of `quads`, and how it yields. `is_held` is
// true for a triangle that triangles_at_edges() marks; its stiffness stays zero.
void add_bending_triangle(const SceneBody& body, int triangle, const Nodes3& rest,
                          const std::array<bool, 3>& has_angle, bool is_held, BendingQuads& quads) {
  const MaterialCase& material = *body.material;
  const int t = triangle % 2;
  if (is_held) return;
  if (material.yields()) quads.laws.back()[t] = yield_law_of(rest, material);
  if (!material.orthotropic_bending) {
    quads.moduli.back()[t] = materials::triangle_bending_modulus(
        rest, has_angle, material.bending_stiffness, material.poisson_ratio);
    return;
  }
  const Vec3 warp = warp_direction(body, triangle);
  const materials::OrthotropicModuli moduli = flat_bending_moduli(material);
  if (material.orthotropic_bending->warp.size() == 1) {
    quads.moduli.back()[t] = materials::triangle_bending_modulus(rest, warp, has_angle, moduli);
  } else {
    quads.maps.back()[t] = materials::bending_map(rest, warp, has_angle, moduli);
  }
}

void add_body(const Scene& scene, int index, BendingQuads& quads) {
  const SceneBody& body = scene.bodies[index];
  const MaterialCase& material = *body.material;
  const std::vector<char> at_edges = triangles_at_edges(scene, index);
  if (material.yields()) {
    const int first = static_cast<int>(quads.nodes.size());
    quads.yielding.push_back({scene.case_index(index), first, first + quad_count(body)});
  }
  const bsi::Mesh mesh = bsi::build_mesh(body.atlas);  // body.mesh may have no edges
  for (int q = 0; q < quad_count(body); ++q) {
    std::array<int, QuadSurroundings::count> nodes;
    nodes.fill(no_node);
    const Quad corners = quad_corners(body, q);
    for (int i = 0; i < 4; ++i) nodes[quad_corner_nodes[i]] = corners[i];
    quads.moduli.push_back({Mat3::Zero(), Mat3::Zero()});
    quads.maps.emplace_back();
    if (material.yields()) quads.laws.emplace_back();
    for (int t = 0; t < 2; ++t) {
      const TriangleHinges hinges = hinges_of(mesh, 2 * q + t);
      Nodes3 rest;
      for (int i = 0; i < 3; ++i) {
        const auto& of_hinge = hinge_nodes[hinged_triangles[t].hinges[i]];
        rest.col(i) = body.rest[corners[corners_of[t][i]]];
        if (hinged_triangles[t].hinges[i] != 0) nodes[of_hinge[3]] = hinges.across[i];
      }
      const bool is_at_edge = !at_edges.empty() && at_edges[2 * q + t] != 0;
      add_bending_triangle(body, 2 * q + t, rest, hinges.has_angle, is_at_edge, quads);
    }
    for (int& node : nodes) {
      if (node != no_node) node += body.first_particle;
    }
    quads.nodes.push_back(nodes);
  }
  quads.damping_times.append(quad_count(body), material.bending_damping_time());
  quads.is_damped |= !material.bending_damping_time().is_zero();
}

}  // namespace

BendingQuads bending_quads(const Scene& scene,
                           const std::function<bool(const MaterialCase& material)>& selects) {
  BendingQuads quads;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const MaterialCase& material = *scene.bodies[b].material;
    if (!material.is_shell() && material.resists_bending() && selects(material))
      add_body(scene, b, quads);
  }
  return quads;
}

}  // namespace weft::sim
