// Features that a scene does not need cost nothing, as the counters show.
#include "simulated_case.h"

namespace weft::sim::economy_test {
namespace {

std::string drape(const std::string& more = "") {
  return R"(
[time]
duration = 1
[material.cloth]
density = 0.2
membrane_stiffness = 500
bending_stiffness = 1e-4
stiffness_damping = 1e-3
[[body]]
name = "sheet"
position = [0, 0, 0.26]
shape = { type = "rectangle", size = [1.6, 1.6], resolution = [17, 17] }
[[obstacle]]
name = "torus"
shape = { type = "torus", major_radius = 0.6, minor_radius = 0.25, resolution = [24, 12] }
)" + more;
}

Counters counters_of(SimulatedCase& sim, double time) {
  sim.advance_to(time);
  return sim.statistics().counters;
}

TEST(Economy, NoSelfTraversalWithoutSelfContact) {
  SimulatedCase off(drape(), {"body.sheet.self_contact=false"}), on(drape());
  EXPECT_EQ(counters_of(off, 0.15).self_traversals, 0);
  EXPECT_GT(counters_of(on, 0.15).self_traversals, 0);
}

TEST(Economy, StaticBodiesAreBuiltOnce) {
  SimulatedCase sim(drape(), {"body.sheet.self_contact=false"});
  const Counters counters = counters_of(sim, 0.15);
  // Each traversal of the pair rebuilds the sheet; the torus adds one.
  EXPECT_GT(counters.pair_traversals, 3);
  EXPECT_EQ(counters.rebuilds, counters.pair_traversals + 1);
}

TEST(Economy, NoFrictionTermsAtZeroFriction) {
  SimulatedCase without(drape()), with(drape(), {"contact.friction=0.3"});
  EXPECT_EQ(counters_of(without, 0.15).friction_terms, 0);
  EXPECT_GT(counters_of(with, 0.15).friction_terms, 0);
}

TEST(Economy, NoSearchAtAllWithoutContact) {
  SimulatedCase sim(drape(), {"contact.enabled=false"});
  const Counters counters = counters_of(sim, 0.15);
  EXPECT_EQ(counters.rebuilds + counters.bound_tests + counters.candidate_pairs +
                counters.narrow_phase_calls + counters.ccd_calls,
            0);
}

// Static spheres in a row 100 m away.
std::string far_obstacles(int count) {
  std::string text;
  for (int i = 0; i < count; ++i) {
    text += "[[obstacle]]\nname = \"far" + std::to_string(i) + "\"\nposition = [100, " +
            std::to_string(2 * i - count) +
            ", 0]\nshape = { type = \"sphere\", radius = 0.5, resolution = [5] }\n";
  }
  return text;
}

TEST(Economy, FarObstaclesChangeNeitherTheTrajectoryNorTheWork) {
  SimulatedCase alone(drape()), crowded(drape(far_obstacles(1000)));
  EXPECT_EQ(alone.advance_to(0.2), crowded.advance_to(0.2));  // the same bits
  const Counters& a = alone.statistics().counters;
  const Counters& b = crowded.statistics().counters;
  EXPECT_EQ(b.body_pairs, a.body_pairs);  // none of them is ever walked
  EXPECT_EQ(b.rebuilds, a.rebuilds);
  EXPECT_EQ(b.candidate_pairs, a.candidate_pairs);
  EXPECT_EQ(b.narrow_phase_calls, a.narrow_phase_calls);
  EXPECT_EQ(b.ccd_calls, a.ccd_calls);
}

TEST(Economy, LookingForNeighboursGrowsWithTheLogarithmOfTheObstacles) {
  SimulatedCase few(drape(far_obstacles(10))), many(drape(far_obstacles(1000)));
  few.advance_to(0.2);
  many.advance_to(0.2);
  const std::int64_t more =
      many.statistics().counters.bound_tests - few.statistics().counters.bound_tests;
  EXPECT_LT(more, 1000 * 2 * 12);  // the obstacles themselves are placed once
}

// Sheets of nine vertices in a square grid, 1 m apart, that fall and turn.
std::string falling_sheets(int side) {
  std::string text = "[material.cloth]\ndensity = 0.2\nmembrane_stiffness = 500\n";
  for (int i = 0; i < side * side; ++i) {
    text += "[[body]]\nname = \"sheet" + std::to_string(i) + "\"\nposition = [" +
            std::to_string(i % side) + ", " + std::to_string(i / side) +
            ", 0]\nangular_velocity_deg = [0, 90, 0]\n"
            "shape = { type = \"rectangle\", size = [0.4, 0.4], resolution = [3, 3] }\n";
  }
  return text;
}

TEST(Economy, BodiesApartAreNotWalkedPairByPair) {
  SimulatedCase few(falling_sheets(10)), many(falling_sheets(20));
  const Counters a = counters_of(few, 0.5), b = counters_of(many, 0.5);
  ASSERT_EQ(a.force_evaluations, b.force_evaluations);
  EXPECT_EQ(a.pair_traversals + b.pair_traversals, 0);
  // With four times the bodies there are sixteen times the pairs of bodies.
  EXPECT_LT(b.body_pairs, 5 * a.body_pairs);
  EXPECT_LT(b.bound_tests, 6 * a.bound_tests);
}

TEST(Economy, BodiesApartMoveAsTheyDoWithoutContact) {
  SimulatedCase with(falling_sheets(4)), without(falling_sheets(4), {"contact.enabled=false"});
  EXPECT_EQ(with.advance_to(0.3), without.advance_to(0.3));
}

TEST(Economy, BodiesHeldAsAWholeHaveNoForcesNoMatrixAndNoState) {
  const std::string held = R"(
[[body]]
name = "held"
position = [4, 0, 0]
shape = { type = "rectangle", size = [1, 1], resolution = [33, 33] }
[[body.pin]]
rows = [0, 32]
)";
  SimulatedCase alone(drape()), beside(drape(held));
  EXPECT_EQ(beside.dynamics().state_size(), alone.dynamics().state_size());
  EXPECT_EQ(beside.dynamics().stiffness().pattern().rows(),
            alone.dynamics().stiffness().pattern().rows());
  EXPECT_EQ(alone.advance_to(0.2), beside.advance_to(0.2));
  const Counters& a = alone.statistics().counters;
  const Counters& b = beside.statistics().counters;
  EXPECT_EQ(b.body_pairs, a.body_pairs);
  EXPECT_EQ(b.rebuilds, a.rebuilds);
}

// The head of a case: one second and a material. Bodies are appended.
const std::string second_of_cloth = R"(
[time]
duration = 1
[material.cloth]
density = 0.2
membrane_stiffness = 500
stiffness_damping = 1e-3
)";

// A sheet falls on another whose vertices are all pinned, at rest or rising: contact includes it.
TEST(Economy, BodiesHeldAsAWholeAreFelt) {
  const std::string held = second_of_cloth + R"([[body]]
name = "held"
shape = { type = "rectangle", size = [1, 1], resolution = [9, 9] }
[[body.pin]]
rows = [0, 8]
)";
  const std::string falling = R"(
[[body]]
name = "free"
position = [0, 0, 0.05]
shape = { type = "rectangle", size = [0.6, 0.6], resolution = [9, 9] }
)";
  for (const char* motion : {"", "motion = { velocity = [0, 0, 0.5] }\n"}) {
    SimulatedCase sim(held + motion + falling);
    ASSERT_EQ(sim.scene().dynamic_bodies, 1);
    const auto position = sim.positions_at(0.3);  // 0.44 m of free fall
    const double floor = *motion == '\0' ? 0 : 0.15;
    double lowest = 10;
    for (int i = 0; i < 81; ++i) lowest = std::min(lowest, position[i].z());
    EXPECT_GT(lowest, floor);
    EXPECT_LT(lowest, floor + 0.1);
    EXPECT_NEAR(position[81].z(), floor, 1e-9);
    EXPECT_EQ(crossings(sim.scene(), position), 0);
  }
}

// A sheet falls past others and meets one: bodies get new neighbours on the way.
TEST(Economy, BodiesThatComeNearAreFound) {
  const std::string text = second_of_cloth + R"([[body]]
name = "sheet"
position = [0, 0, 2]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [5, 5] }
[[obstacle]]
name = "beside"
position = [0.6, 0, 1]
shape = { type = "sphere", radius = 0.3, resolution = [9] }
[[obstacle]]
name = "below"
shape = { type = "sphere", radius = 0.3, resolution = [17] }
)";
  SimulatedCase sim(text);
  sim.advance_to(0.5);
  EXPECT_EQ(sim.dynamics().contact()->pairs_in_reach(), 0U);
  const auto position = sim.positions_at(0.65);  // 2.07 m of free fall; 1.7 m is the way
  EXPECT_GT(sim.statistics().counters.narrow_phase_calls, 0);
  double highest = -10;
  for (int i = 0; i < 25; ++i) highest = std::max(highest, position[i].z());
  EXPECT_GT(highest, 0.2);
  EXPECT_EQ(crossings(sim.scene(), position), 0);
}

}  // namespace
}  // namespace weft::sim::economy_test
