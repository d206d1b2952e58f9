// Seams in meshes finer than the thickness: neighbours at rest across seams are not in contact, and
// still never pass through each other.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "materials/contact.h"
#include "sim/contact/contact.h"
#include "sim/contact/seam_neighbours.h"
#include "sim/run/initial_state.h"
#include "tests/sim/joint_cases.h"

namespace weft::sim::seam_neighbours_test {
namespace {

using Positions = std::vector<Vec3>;

// Thickness and range are 1 mm and 2 mm.
constexpr const char* setting = R"(
[time]
duration = 0.1
[world]
gravity = [0, 0, 0]
[contact]
range = 2e-3
[material.cloth]
density = 0.2
membrane_stiffness = 500
bending_stiffness = 1e-5
stiffness_damping = 2e-3
mass_damping = 3
)";

std::string piece(const std::string& name, const std::string& place, const std::string& size,
                  const std::string& resolution) {
  return "[[body]]\nname = \"" + name + "\"\nthickness = 1e-3\nposition = " + place +
         "\nshape = { type = \"rectangle\", size = " + size + ", resolution = " + resolution +
         " }\n";
}
std::string seam(const std::string& body, const std::string& edge, const std::string& to,
                 const std::string& to_edge) {
  return "[[seam]]\nbody = \"" + body + "\"\nedge = \"" + edge + "\"\nto = \"" + to +
         "\"\nto_edge = \"" + to_edge + "\"\n";
}

// Two squares of 40 mm, sewn edge to edge, with `n` and `m` vertices along the seam.
std::string two_squares(int n, int m) {
  const auto resolution = [](int k) {
    return "[" + std::to_string(k) + ", " + std::to_string(k) + "]";
  };
  return setting + piece("left", "[-0.02, 0, 0]", "[0.04, 0.04]", resolution(n)) +
         piece("right", "[0.02, 0, 0]", "[0.04, 0.04]", resolution(m)) +
         seam("left", "last_col", "right", "first_col");
}

// Four squares of 20 mm with edges of 1 mm that meet in the origin.
std::string four_squares() {
  std::string text = setting;
  for (const char* row : {"0", "1"}) {
    for (const char* col : {"0", "1"}) {
      const std::string x = *col == '0' ? "-0.01" : "0.01", y = *row == '0' ? "-0.01" : "0.01";
      text += piece(std::string("p") + row + col, "[" + x + ", " + y + ", 0]", "[0.02, 0.02]",
                    "[21, 21]");
    }
  }
  return text + seam("p00", "last_col", "p01", "first_col") +
         seam("p10", "last_col", "p11", "first_col") + seam("p00", "last_row", "p10", "first_row") +
         seam("p01", "last_row", "p11", "first_row");
}

// A strip rolled up until its ends meet, and sewn to a tube, with edges of 1 mm.
std::string tube() {
  return std::string(setting) +
         "[[body]]\nname = \"strip\"\nthickness = 1e-3\nstart = { bend_radius = 0.01 }\n"
         "shape = { type = \"rectangle\", size = [0.06283185307179586, 0.01], resolution = [11, "
         "64] }\n" +
         seam("strip", "last_col", "strip", "first_col") + "closing_time = 0.05\n";
}

Positions still(const Scene& scene) {
  return Positions(scene.initial_position.size(), Vec3::Zero());
}

}  // namespace

// The edges are 5 mm, 2 mm, 1.25 mm and 1 mm long; with 17 and 41 vertices the stitches hang
// between vertices of the other side.
TEST(SeamNeighbours, SewnSheetsDoNotPushThemselves) {
  std::vector<std::string> cases{four_squares(), tube()};
  for (const auto& [n, m] : {std::pair(9, 9), {21, 21}, {33, 33}, {41, 41}, {17, 41}, {41, 34}})
    cases.push_back(two_squares(n, m));
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const auto scene = build_scene(parse_case(cases[i], "test.toml"));
    EXPECT_NO_THROW(check_initial_state(*scene)) << i;
    Statistics statistics;
    Contact contact(*scene, statistics);
    ASSERT_FALSE(contact.evaluate(scene->initial_position, still(*scene), 1)) << i;
    EXPECT_EQ(contact.energy(), 0) << i;
    EXPECT_EQ(contact.pairs_in_reach(), 0U) << i;
  }
}

// In the plane, distances at rest are those between the points of the pieces. Rows of 1 mm are
// narrower than what a neighbourhood may have too much.
TEST(SeamNeighbours, AreThoseOfTheUncutSheet) {
  constexpr double range = 2e-3, radius = std::numbers::pi / 2 * 1e-3 + range, edge = 1e-3;
  const auto scene = build_scene(parse_case(four_squares(), "test.toml"));
  const auto found = neighbours_across_seams(*scene, range);
  int neighbours = 0, others = 0;
  for (int a = 0; a < 4; ++a) {
    for (int b = 0; b < 4; ++b) {
      if (a == b) continue;
      const SceneBody &one = scene->bodies[a], &other = scene->bodies[b];
      const auto& of = found.at({a, b});
      for (int v = 0; v < one.particle_count(); ++v) {
        const Vec3& x = scene->initial_position[one.first_particle + v];
        for (int t = 0; t < static_cast<int>(other.mesh.triangles.size()); ++t) {
          std::array<Vec3, 3> y;
          for (int k = 0; k < 3; ++k)
            y[k] = scene->initial_position[other.first_particle + other.mesh.triangles[t][k]];
          const double distance =
              std::sqrt(bsi::closest_vertex_triangle(x, y[0], y[1], y[2]).squared_distance);
          const bool is_near = std::ranges::binary_search(of[v], t);
          EXPECT_TRUE(is_near || distance > radius) << a << ' ' << b << ' ' << v << ' ' << t;
          EXPECT_FALSE(is_near && distance > radius + 1.01 * edge) << a << ' ' << b << ' ' << v;
          ++(is_near ? neighbours : others);
        }
      }
    }
  }
  EXPECT_GT(neighbours, 1000);
  EXPECT_GT(others, 1000);
}

// Contact leaves alone what is sewn, and no more, where edges are longer than thickness + range.
TEST(SeamNeighbours, AreNoneInCoarseMeshes) {
  const auto scene = build_scene(parse_case(two_squares(9, 9), "test.toml"));
  EXPECT_TRUE(neighbours_across_seams(*scene, 2e-3).empty());
}

// One piece lies folded back onto the other one: beyond the neighbourhoods both layers push by
// their area.
TEST(SeamNeighbours, FoldedPiecesPushByTheirArea) {
  constexpr double gap = 0.8e-3, range = 2e-3, edge = 1e-3;
  const auto scene = build_scene(parse_case(two_squares(41, 41), "test.toml"));
  Statistics statistics;
  Contact contact(*scene, statistics);
  Positions x = scene->initial_position;
  for (Vec3& each : x) {
    if (each.x() > 0) each = Vec3(-each.x(), each.y(), 1e-3 + gap);
  }
  ASSERT_FALSE(contact.evaluate(x, still(*scene), 1));
  Positions force = still(*scene);
  contact.add_forces(force);
  double upper = 0, lower = 0;
  for (std::size_t i = 0; i < x.size(); ++i) (x[i].z() > 0 ? upper : lower) += force[i].z();
  const double push = -materials::barrier(gap, range, scene->source.contact.stiffness).first;
  const double radius = std::numbers::pi / 2 * 1e-3 + range;
  EXPECT_GT(upper, 0.98 * push * 0.04 * (0.04 - radius - edge));
  EXPECT_LT(upper, push * 0.04 * 0.04);
  EXPECT_NEAR(upper, -lower, 1e-9 * upper);
}

// The forces of a sharp fold at the seam are the slopes of the energy, where neighbourhoods end
// too.
TEST(SeamNeighbours, ForcesOfAFoldAreSlopesOfTheEnergy) {
  const auto scene = build_scene(parse_case(two_squares(34, 41), "test.toml"));
  Statistics statistics;
  Contact contact(*scene, statistics);
  Positions x = scene->initial_position, along = x;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double s = x[i].x(), wave = 2e-4 * std::sin(700 * x[i].y() + 900 * s);
    if (s > 0) x[i] = Vec3(-0.9 * s, x[i].y(), 1.1e-3 + 0.3 * s);
    x[i].z() += wave;
    const auto number = static_cast<double>(i);
    along[i] = Vec3(std::sin(11 * number), std::sin(7 * number), std::sin(5 * number));
  }
  const auto energy_at = [&](double by) {
    Positions moved = x;
    for (std::size_t i = 0; i < x.size(); ++i) moved[i] += by * along[i];
    EXPECT_FALSE(contact.evaluate(moved, still(*scene), 1));
    return contact.energy();
  };
  constexpr double step = 1e-8;
  const double slope = (energy_at(step) - energy_at(-step)) / (2 * step);
  ASSERT_GT(energy_at(0), 1e-9);
  Positions force = still(*scene);
  contact.add_forces(force);
  double product = 0;
  for (std::size_t i = 0; i < x.size(); ++i) product += force[i].dot(along[i]);
  EXPECT_NEAR(product, -slope, 1e-5 * std::abs(slope));
}

// A vertex of one piece is drawn through a triangle of the other one, near the seam, from either
// side: no force keeps it from that.
TEST(SeamNeighbours, PathsThroughNeighboursAreRefused) {
  const auto scene = build_scene(parse_case(two_squares(41, 41), "test.toml"));
  const Positions& rest = scene->initial_position;
  for (const bool is_right : {false, true}) {
    Statistics statistics;
    Contact contact(*scene, statistics);
    // The second vertex off the seam, over a triangle as far on the other side of it.
    const int vertex = is_right ? scene->bodies[1].first_particle + 20 * 41 + 2 : 20 * 41 + 38;
    Positions start = rest;
    start[vertex] = Vec3(is_right ? -1.3e-3 : 1.3e-3, rest[vertex].y() + 0.2e-3, 2e-4);
    EXPECT_FALSE(contact.check_path(rest, start));
    EXPECT_FALSE(contact.evaluate(start, still(*scene), 1));
    Positions end = start;
    end[vertex].z() = -2e-4;
    const auto fault = contact.check_path(start, end);
    ASSERT_TRUE(fault) << is_right;
    EXPECT_EQ(fault->kind, ContactFault::Kind::crossing);
    EXPECT_TRUE(contact.check_crossing(PlacedParticles(start), PlacedParticles(end)));
  }
}

// Two sheets that start apart are drawn together until nothing is left between them.
TEST(SeamNeighbours, FineSheetsCloseWithoutAPush) {
  std::string text = setting + piece("left", "[-0.021, 0, 0]", "[0.04, 0.02]", "[17, 33]") +
                     piece("right", "[0.021, 0, 0]", "[0.04, 0.02]", "[17, 33]") +
                     seam("left", "last_col", "right", "first_col") + "closing_time = 0.05\n";
  Simulation simulation = simulation_of(text, {"time.duration=0.2"});
  advance_to(simulation, 0.2);
  const std::vector<Vec3> left = simulation.position("left"), right = simulation.position("right");
  for (int row = 0; row < 17; ++row)
    EXPECT_LT((left[33 * row + 32] - right[33 * row]).norm(), 5e-5) << row;
  Statistics statistics;
  Contact contact(simulation.scene(), statistics);
  Positions all = left;
  all.insert(all.end(), right.begin(), right.end());
  ASSERT_FALSE(contact.evaluate(all, still(simulation.scene()), 1));
  EXPECT_EQ(contact.energy(), 0);
}

}  // namespace weft::sim::seam_neighbours_test
