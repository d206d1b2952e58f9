// Nothing that a scene does not need is paid for: shown by the counters.
#include "simulated_case.h"

namespace weft::sim {
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

TEST(Economy, FarObstaclesChangeNeitherTheTrajectoryNorTheWork) {
  std::string far;
  for (int i = 0; i < 100; ++i) {
    far += "[[obstacle]]\nname = \"far" + std::to_string(i) + "\"\nposition = [100, " +
           std::to_string(2 * i - 100) +
           ", 0]\nshape = { type = \"sphere\", radius = 0.5, resolution = [9] }\n";
  }
  SimulatedCase alone(drape()), crowded(drape(far));
  EXPECT_EQ(alone.advance_to(0.2), crowded.advance_to(0.2));  // the same bits
  const Counters& a = alone.statistics().counters;
  const Counters& b = crowded.statistics().counters;
  EXPECT_EQ(b.bound_tests, a.bound_tests + 100);  // one look at each
  EXPECT_EQ(b.rebuilds, a.rebuilds);
  EXPECT_EQ(b.candidate_pairs, a.candidate_pairs);
  EXPECT_EQ(b.narrow_phase_calls, a.narrow_phase_calls);
  EXPECT_EQ(b.ccd_calls, a.ccd_calls);
}

}  // namespace
}  // namespace weft::sim
