// Prescribed motion: no step passes over it, surfaces stay apart on the true paths, and pins are
// followed to the tolerance.
#include <gtest/gtest.h>

#include "simulated_case.h"

namespace weft::sim {
namespace {

const Overrides cvode = method("cvode"), arkode = method("arkode"), euler = method("euler");

// A ball passes through where a sheet rests between two pinned edges, and back, within 0.2 s.
constexpr const char* there_and_back = R"(
[time]
duration = 0.65
[world]
gravity = [0, 0, 0]
[material.cloth]
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [9, 9] }
[[body.pin]]
edges = ["first_row", "last_row"]
[[obstacle]]
name = "ball"
position = [0.03, 0.02, 0.15]
shape = { type = "sphere", radius = 0.1, resolution = [5] }
[obstacle.motion]
keyframes = [{ time = 0.4 }, { time = 0.5, translation = [0, 0, -0.3] }, { time = 0.6 }]
)";

// A curtain at rest, damped, that a ball swings through late.
constexpr const char* curtain = R"(
[time]
duration = 20.6
[material.cloth]
mass_damping = 1
stiffness_damping = 1e-3
[[body]]
name = "curtain"
rotation_deg = [90, 0, 0]
shape = { type = "rectangle", size = [1, 1], resolution = [9, 9] }
[[body.pin]]
edges = ["last_row"]
[[obstacle]]
name = "ball"
position = [0.02, 0.6, -0.2]
shape = { type = "sphere", radius = 0.1, resolution = [5] }
[obstacle.motion]
keyframes = [{ time = 20 }, { time = 20.5, translation = [0, -1.2, 0] }]
)";

// Both edges of a damped sheet turn once about the line through their middles.
constexpr const char* turning_pins = R"(
[time]
duration = 20.5
[contact]
enabled = false
[material.cloth]
mass_damping = 1
stiffness_damping = 1e-3
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [9, 9] }
[[body.pin]]
edges = ["last_row", "first_row"]
motion = { centre = [0, 0, 0], keyframes = [{ time = 20 }, { time = 20.5, rotation_deg = [0, 0, 360] }] }
)";

// A paddle that turns at two rounds a second cuts the plane of a resting free sheet twice a round.
constexpr const char* paddle = R"(
[time]
duration = 0.3
[world]
gravity = [0, 0, 0]
[material.cloth]
[[body]]
name = "sheet"
position = [0.35, 0, 0.0]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [9, 9] }
[[obstacle]]
name = "paddle"
position = [0, 0, 0.35]
rotation_deg = [0, 90, 0]
shape = { type = "rectangle", size = [0.8, 0.2], resolution = [9, 3] }
[obstacle.motion]
centre = [0, 0, 0]
angular_velocity_deg = [0, 720, 0]
)";

struct Outcome {
  std::string failure;  // of a step or a frame
  int crossings = 0;    // in all states looked at
  double largest_move = 0, largest_stretch = -1;
};

// Looks at `samples` states in each sixtieth of a second from `from` on.
Outcome watch(SimulatedCase& sim, double from, double until, int samples = 20) {
  Outcome outcome;
  std::vector<double> y(sim.dynamics().state_size());
  const double interval = 1.0 / (60 * samples);
  for (long next = 0;;) {
    if (auto failure = sim.integrator().step()) {
      outcome.failure = *failure;
      return outcome;
    }
    for (;; ++next) {
      const double time = from + static_cast<double>(next) * interval;
      if (time > until) return outcome;
      if (time > sim.integrator().time()) break;
      if (auto failure = sim.integrator().state_at(time, y)) {
        outcome.failure = *failure;
        return outcome;
      }
      const std::vector<Vec3> position = sim.positions(time, y);
      outcome.crossings += crossings(sim.scene(), position);
      outcome.largest_stretch =
          std::max(outcome.largest_stretch, sim.dynamics().largest_stretch(position));
      for (int i = 0; i < sim.scene().dynamic_particles; ++i) {
        outcome.largest_move =
            std::max(outcome.largest_move, (position[i] - sim.scene().initial_position[i]).norm());
      }
    }
  }
}

TEST(PrescribedMotion, ABallThatComesAndGoesWithinAStepIsFelt) {
  for (const Overrides& by : {cvode, arkode, euler}) {
    SCOPED_TRACE(by.front());
    SimulatedCase sim(there_and_back, by);
    const Outcome outcome = watch(sim, 0.4, 0.65);
    EXPECT_EQ(outcome.failure, "");
    EXPECT_EQ(outcome.crossings, 0);
    EXPECT_GT(outcome.largest_move, 0.2);
  }
}

TEST(PrescribedMotion, ABallSwingsIntoACurtainThatHasLongBeenAtRest) {
  SimulatedCase sim(curtain);
  const Outcome outcome = watch(sim, 19.9, 20.6);
  EXPECT_EQ(outcome.failure, "");
  EXPECT_EQ(outcome.crossings, 0);
  EXPECT_GT(outcome.largest_move, 0.2);
}

TEST(PrescribedMotion, PinsThatTurnOnceAreFollowed) {
  for (const Overrides& by : {cvode, arkode, euler}) {
    SCOPED_TRACE(by.front());
    SimulatedCase sim(turning_pins, by);
    const Outcome outcome = watch(sim, 20, 20.5);
    EXPECT_EQ(outcome.failure, "");
    EXPECT_LT(outcome.largest_stretch, 0.5);
  }
}

TEST(PrescribedMotion, APaddleSweepsASheetAway) {
  for (const Overrides& by : {cvode, arkode, euler}) {
    SCOPED_TRACE(by.front());
    SimulatedCase sim(paddle, by);
    const Outcome outcome = watch(sim, 0, 0.3);
    EXPECT_EQ(outcome.failure, "");
    EXPECT_EQ(outcome.crossings, 0);
    EXPECT_GT(outcome.largest_move, 0.1);
  }
}

}  // namespace
}  // namespace weft::sim
