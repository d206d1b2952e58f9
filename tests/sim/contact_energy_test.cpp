// The forces of contact against an energy that is summed feature by feature.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "bsi/proximity.h"
#include "materials/contact.h"
#include "sim/contact/contact.h"
#include "tests/sim/contact_oracle.h"
#include "tests/sim/contact_scenes.h"

namespace weft::sim::contact_energy_test {
namespace {

using namespace contact_scenes;  // NOLINT: scenes of this test

// The energy of contact by its definition (docs/theory.md, section 7): feature by feature, without
// lists, pyramids or cancelled terms.
class EnergyByFeature {
 public:
  explicit EnergyByFeature(const Scene& scene) : scene_(scene) {
    const auto lists = searched_pairs(scene);
    const ContactOracle oracle(scene);
    for (const OraclePair& pair : oracle.pairs()) {
      if (!pair.neighbours) continue;
      auto& found = pair.edges() ? near_edges_ : near_triangles_;
      found.insert({lists[pair.list].body_a, pair.a, pair.b});
    }
  }

  double energy(const Positions& x) const {
    double sum = 0;
    const int bodies = static_cast<int>(scene_.bodies.size());
    for (int a = 0; a < scene_.dynamic_bodies; ++a) {
      for (int b = a; b < bodies; ++b) {
        sum += samples(a, b, x) + edges(a, b, x);
        if (a == b) continue;
        sum += scene_.bodies[b].dynamic ? samples(b, a, x) : obstacle_vertices(a, b, x);
      }
    }
    return sum;
  }

 private:
  static double barrier(double distance, double share) {
    const double gap = distance - thickness, end = share * range;
    return gap < end ? materials::barrier(gap, end, 1).value : 0;
  }
  double stiffness() const { return scene_.source.contact.stiffness; }
  double area(const SceneBody& body, int vertex) const {
    return scene_.contact_area[body.first_particle + vertex];
  }

  // Sums over the vertices of one body against the surface of another, or of itself.
  double samples(int of, int against, const Positions& x) const {
    const SceneBody& from = scene_.bodies[of];
    double sum = 0;
    for (int v = 0; v < from.particle_count(); ++v) {
      sum += (scene_.bodies[against].dynamic ? 0.5 : 1) * stiffness() * area(from, v) *
             surface(against, x[from.first_particle + v], of == against ? v : -1, x);
    }
    return sum;
  }

  double surface(int number, const Vec3& point, int own, const Positions& x) const {
    const SceneBody& body = scene_.bodies[number];
    const Vec3* at = x.data() + body.first_particle;
    const auto holds = [&](int t) {
      const auto& corners = body.mesh.triangles[t];
      return std::find(corners.begin(), corners.end(), own) != corners.end() ||
             (own >= 0 && near_triangles_.contains({number, own, t}));
    };
    std::vector<char> is_inner(body.particle_count(), 1);
    double sum = 0;
    for (int t = 0; t < static_cast<int>(body.mesh.triangles.size()); ++t) {
      const auto& [a, b, c] = body.mesh.triangles[t];
      if (holds(t)) is_inner[a] = is_inner[b] = is_inner[c] = 0;
      if (!holds(t)) sum += barrier(distance(point, at[a], at[b], at[c]), 1);
    }
    for (const bsi::Edge& edge : body.mesh.edges) {
      const auto [a, b] = edge.vertex;
      if (edge.triangle[1] < 0) is_inner[a] = is_inner[b] = 0;
      if (edge.triangle[1] < 0 || holds(edge.triangle[0]) || holds(edge.triangle[1])) continue;
      sum -= barrier(distance(point, at[a], at[b], at[b]), 1);
    }
    for (int v = 0; v < body.particle_count(); ++v) {
      if (is_inner[v] != 0) sum += barrier((point - at[v]).norm(), 1);
    }
    return sum;
  }
  static double distance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
    return std::sqrt(bsi::closest_vertex_triangle(p, a, b, c).squared_distance);
  }

  double obstacle_vertices(int dynamic, int obstacle, const Positions& x) const {
    const SceneBody &body = scene_.bodies[dynamic], &other = scene_.bodies[obstacle];
    const Vec3* at = x.data() + body.first_particle;
    double sum = 0;
    for (int v = 0; v < other.particle_count(); ++v) {
      for (const auto& [a, b, c] : body.mesh.triangles) {
        const double mean = (area(body, a) + area(body, b) + area(body, c)) / 3;
        sum += 16 * stiffness() * mean *
               barrier(distance(x[other.first_particle + v], at[a], at[b], at[c]), 0.25);
      }
    }
    return sum;
  }

  double edges(int first, int second, const Positions& x) const {
    const SceneBody &one = scene_.bodies[first], &two = scene_.bodies[second];
    double sum = 0;
    for (std::size_t e = 0; e < one.mesh.edges.size(); ++e) {
      for (std::size_t f = first == second ? e + 1 : 0; f < two.mesh.edges.size(); ++f) {
        const auto [a, b] = one.mesh.edges[e].vertex;
        const auto [c, d] = two.mesh.edges[f].vertex;
        if (first == second && (a == c || a == d || b == c || b == d)) continue;
        const std::array<int, 3> pair{first, static_cast<int>(e), static_cast<int>(f)};
        if (first == second && near_edges_.contains(pair)) continue;
        const double mean_one = (area(one, a) + area(one, b)) / 2;
        const double mean =
            two.dynamic ? (mean_one + (area(two, c) + area(two, d)) / 2) / 2 : mean_one;
        sum += 16 * stiffness() * mean * edge_pair(one, {a, b}, two, {c, d}, x);
      }
    }
    return sum;
  }
  static double edge_pair(const SceneBody& one, const std::array<int, 2>& e, const SceneBody& two,
                          const std::array<int, 2>& f, const Positions& x) {
    const Vec3 *at = x.data() + one.first_particle, *to = x.data() + two.first_particle;
    const double gap =
        std::sqrt(bsi::closest_edge_edge(at[e[0]], at[e[1]], to[f[0]], to[f[1]]).squared_distance);
    const double threshold = 1e-3 * (one.rest[e[1]] - one.rest[e[0]]).squaredNorm() *
                             (two.rest[f[1]] - two.rest[f[0]]).squaredNorm();
    const double sine = (at[e[1]] - at[e[0]]).cross(to[f[1]] - to[f[0]]).squaredNorm() / threshold;
    return (sine < 1 ? sine * (2 - sine) : 1) * barrier(gap, 0.25);
  }

  const Scene& scene_;
  // Body, vertex and triangle, or body and two edges, of neighbours at rest.
  std::set<std::array<int, 3>> near_triangles_, near_edges_;
};

// Checks the energy and, as its slope, the forces on every 13th particle.
void expect_forces_by_feature(const Scene& scene, Positions x) {
  Statistics statistics;
  Contact contact(scene, statistics);
  const EnergyByFeature oracle(scene);
  const Positions rest(x.size(), Vec3::Zero());
  ASSERT_FALSE(contact.evaluate(x, rest, 1));
  const double energy = oracle.energy(x);
  ASSERT_GT(energy, 0);
  EXPECT_NEAR(contact.energy(), energy, 1e-9 * energy);
  Positions force(scene.dynamic_particles, Vec3::Zero());
  contact.add_forces(force);
  double largest = 0;
  for (const Vec3& f : force) largest = std::max(largest, f.norm());
  for (int i = 0; i < scene.dynamic_particles; i += 13) {
    for (int axis = 0; axis < 3; ++axis) {
      const double step = 1e-7, place = x[i][axis];
      x[i][axis] = place + step;
      const double above = oracle.energy(x);
      x[i][axis] = place - step;
      const double below = oracle.energy(x);
      x[i][axis] = place;
      EXPECT_NEAR(force[i][axis], (below - above) / (2 * step), 1e-5 * largest) << i;
    }
  }
}

TEST(ContactEnergy, ForcesAreThoseOfTheEnergyByFeature) {
  const auto scene = scene_of(one_sheet);
  expect_forces_by_feature(*scene, shifted(folded(*scene, 0.02), 0.002, 1));
  expect_forces_by_feature(*scene, crumpled(*scene, 3));
  const auto fine = scene_of(fine_sheet);
  expect_forces_by_feature(*fine, shifted(rolled(*fine, 7.2, 0.045), 0.001, 4));
  const auto bodies = scene_of(one_sheet + R"(
[[body]]
name = "upper"
thickness = 0.004
position = [0.03, 0.02, 0.02]
rotation_deg = [0, 0, 40]
shape = { type = "rectangle", size = [0.6, 0.6], resolution = [6, 6] }
[[obstacle]]
name = "ball"
thickness = 0.004
position = [0.1, 0, -0.2075]
shape = { type = "sphere", radius = 0.2, resolution = [9] }
)");
  expect_forces_by_feature(*bodies, shifted(bodies->initial_position, 0.001, 5));
}

}  // namespace
}  // namespace weft::sim::contact_energy_test
