// Meshes finer than the thickness: neighbours at rest are not in contact, and still never pass
// through each other.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "materials/contact.h"
#include "sim/case/case_error.h"
#include "sim/contact/contact.h"
#include "sim/run/initial_state.h"
#include "tests/sim/simulated_case.h"

namespace weft::sim::contact_neighbours_test {
namespace {

using Positions = std::vector<Vec3>;

constexpr double thickness = 5e-3, range = 5e-3;  // m

// A sheet of 1 m x 0.25 m with the edges of a sheet of 1 m of n x n vertices.
std::unique_ptr<const Scene> sheet_of(int n) {
  return build_scene(parse_case(
      R"(
[time]
duration = 1
[contact]
range = 5e-3
[[body]]
name = "sheet"
thickness = 5e-3
shape = { type = "rectangle", size = [1, 0.25], resolution = [)" +
          std::to_string((n - 1) / 4 + 1) + ", " + std::to_string(n) + "] }\n",
      "test.toml"));
}

// Bends the sheet by half a turn into two layers `apart` (m), joined by half a circle. The middle
// of the fold lies at x = `middle`.
Positions folded(const Scene& scene, double apart, double middle) {
  Positions positions = scene.initial_position;
  const double radius = 0.5 * apart, arc = std::numbers::pi * radius;
  for (Vec3& x : positions) {
    const double s = x.x() - middle + 0.5 * arc;  // along the sheet, from the start of the arc
    if (s <= 0) {
      x = Vec3(s, x.y(), -radius);
    } else if (s < arc) {
      const double angle = s / radius;
      x = Vec3(radius * std::sin(angle), x.y(), -radius * std::cos(angle));
    } else {
      x = Vec3(arc - s, x.y(), radius);
    }
  }
  return positions;
}

TEST(ContactNeighbours, AFlatSheetDoesNotPushItself) {
  for (const int n : {33, 65, 129, 257}) {
    const auto scene = sheet_of(n);
    EXPECT_NO_THROW(check_initial_state(*scene)) << n;
    Statistics statistics;
    Contact contact(*scene, statistics);
    const Positions rest(scene->initial_position.size(), Vec3::Zero());
    ASSERT_FALSE(contact.evaluate(scene->initial_position, rest, 1)) << n;
    EXPECT_EQ(contact.pairs_in_reach(), 0U) << n;
    double gap = 0;
    EXPECT_FALSE(contact.check_state(scene->initial_position, &gap)) << n;
    EXPECT_TRUE(std::isinf(gap)) << n;
  }
}

// The push of two layers on each other is that of their area, although the sheets of 129 x 129 and
// more are finer than thickness + range.
TEST(ContactNeighbours, AFoldedSheetPushesByItsAreaAtAnyResolution) {
  constexpr double gap = 0.4 * range;
  for (const int n : {33, 65, 129, 257}) {
    const auto scene = sheet_of(n);
    Statistics statistics;
    Contact contact(*scene, statistics);
    // Half an edge beside a column, so that the areas of the samples add up to that of the layer.
    const double middle = 0.5 / (n - 1);
    const Positions x = folded(*scene, thickness + gap, middle);
    const Positions rest(x.size(), Vec3::Zero());
    ASSERT_FALSE(contact.evaluate(x, rest, 1)) << n;
    Positions force(x.size(), Vec3::Zero());
    contact.add_forces(force);
    double upper = 0, lower = 0;
    for (std::size_t i = 0; i < x.size(); ++i) (x[i].z() > 0 ? upper : lower) += force[i].z();
    const double area = 0.25 * (0.5 - middle);
    const double push = -materials::barrier(gap, range, scene->source.contact.stiffness).first;
    EXPECT_NEAR(upper / (push * area), 1, 0.05) << n;
    EXPECT_NEAR(lower / (push * area), -1, 0.05) << n;
  }
}

// A fold as sharp as the thickness allows costs hardly any energy beside that of its layers: what
// lies beyond the neighbourhoods keeps its distance.
TEST(ContactNeighbours, AFoldItselfIsNotStiffened) {
  const auto scene = sheet_of(257);
  Statistics statistics;
  Contact contact(*scene, statistics);
  const Positions x = folded(*scene, thickness + 0.9 * range, 0.0123);
  const Positions rest(x.size(), Vec3::Zero());
  ASSERT_FALSE(contact.evaluate(x, rest, 1));
  // The layers are at 0.9 of the range from each other, where their energy is nearly 0.
  const double layers =
      materials::barrier(0.9 * range, range, scene->source.contact.stiffness).value;
  EXPECT_LT(contact.energy(), 1.05 * layers * 0.25 * 0.5);
}

// Neighbours are features of one body. Those of an obstacle that have the numbers of neighbours are
// in contact like all others.
TEST(ContactNeighbours, AFineSheetLiesOnAnObstacleWithItsWholeArea) {
  constexpr double gap = 0.4 * range;
  const auto scene = build_scene(parse_case(R"(
[time]
duration = 1
[contact]
range = 5e-3
[[body]]
name = "sheet"
thickness = 5e-3
position = [0, 0, 7e-3]
shape = { type = "rectangle", size = [0.25, 0.25], resolution = [65, 65] }
[[obstacle]]
name = "floor"
thickness = 5e-3
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3] }
)",
                                            "test.toml"));
  Statistics statistics;
  Contact contact(*scene, statistics);
  const Positions& x = scene->initial_position;
  ASSERT_FALSE(contact.evaluate(x, Positions(x.size(), Vec3::Zero()), 1));
  Positions force(x.size(), Vec3::Zero());
  contact.add_forces(force);
  double push = 0;
  for (int i = 0; i < scene->dynamic_particles; ++i) push += force[i].z();
  const double pressure = -materials::barrier(gap, range, scene->source.contact.stiffness).first;
  EXPECT_NEAR(push / (pressure * 0.25 * 0.25), 1, 1e-9);
  EXPECT_FALSE(contact.check_path(x, x));
}

// One vertex is drawn through a triangle two cells away, which no force keeps it from.
TEST(ContactNeighbours, PathsThroughNeighboursAreRefused) {
  const auto scene = sheet_of(129);
  Statistics statistics;
  Contact contact(*scene, statistics);
  const Positions& rest = scene->initial_position;
  const int cols = 129, vertex = 16 * cols + 64;
  Positions start = rest;
  const double edge = 1.0 / 128;
  // Over the middle of a triangle of the second ring, 1 mm above it, and then as far below it.
  const Vec3 above = rest[vertex] + Vec3(1.3 * edge, 0.3 * edge, 1e-3);
  start[vertex] = above;
  Positions end = start;
  EXPECT_FALSE(contact.check_path(rest, start));
  EXPECT_FALSE(contact.check_path(start, end));
  end[vertex].z() = 1e-4;
  EXPECT_FALSE(contact.check_path(start, end));
  // The distance is less than the thickness, which would be a fault of pairs in contact.
  const Positions unmoving(rest.size(), Vec3::Zero());
  EXPECT_FALSE(contact.evaluate(end, unmoving, 1));
  end[vertex].z() = -1e-3;
  const auto fault = contact.check_path(start, end);
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->kind, ContactFault::Kind::crossing);
  EXPECT_TRUE(contact.check_crossing(PlacedParticles(start), PlacedParticles(end)));
}

// A strip whose edges of 7.8 mm are shorter than thickness + range is folded over, and its upper
// half falls on the lower one.
TEST(ContactNeighbours, AFineStripFoldsOnItselfWithoutCrossing) {
  SimulatedCase sim(R"(
[time]
duration = 0.4
[contact]
range = 5e-3
[material.cloth]
density = 0.2
membrane_stiffness = 500
bending_stiffness = 1e-5
stiffness_damping = 1e-3
[[body]]
name = "strip"
thickness = 5e-3
position = [0, 0, 0.008]
shape = { type = "rectangle", size = [0.25, 0.03125], resolution = [5, 33] }
[[body.pin]]
edges = ["first_col"]
[body.pin.motion]
centre = [0, 0, 0.0145]
keyframes = [ { time = 0 }, { time = 0.25, rotation_deg = [0, 180, 0] } ]
[[obstacle]]
name = "floor"
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3] }
)");
  std::size_t most_in_contact = 0;
  for (int frame = 1; frame <= 40; ++frame) {
    const std::vector<double> y = sim.advance_to(0.01 * frame);
    ASSERT_FALSE(testing::Test::HasFailure()) << frame;
    const Positions x = sim.positions(0.01 * frame, y);
    const SceneBody& strip = sim.scene().bodies[0];
    const CrossingSurface surface{std::span(x).first(strip.particle_count()), strip.mesh.triangles};
    EXPECT_TRUE(find_crossings({&surface, 1}).empty()) << frame;
    std::size_t in_contact = 0;
    Statistics statistics;
    Contact contact(sim.scene(), statistics);
    const Positions still(x.size(), Vec3::Zero());
    ASSERT_FALSE(contact.evaluate(x, still, 1));
    for (const ContactPair& pair : contact.pairs())
      in_contact += sim.scene().body_index_of_point(pair.nodes[3]) == 0 ? 1 : 0;
    most_in_contact = std::max(most_in_contact, in_contact);
  }
  EXPECT_GT(most_in_contact, 5U);  // the strip has lain on itself; the number varies with rounding
}

}  // namespace
}  // namespace weft::sim::contact_neighbours_test
