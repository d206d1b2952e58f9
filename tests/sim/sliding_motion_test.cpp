// Pins that hold some directions and move are motions like those of other pins: for sleep, for the
// strength of barriers, for Newton's iteration, for the lengths of steps and at the start.
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "sim/motion/motion_limits.h"
#include "sim/run/make_simulation.h"
#include "sim/scene/impact_speed.h"
#include "tests/sim/simulated_case.h"

namespace weft::sim::sliding_motion_test {
namespace {

// A sheet with a pin at its first edge. `pin` has the other keys of the pin.
std::string pinned_sheet(const std::string& pin) {
  return R"(
[world]
gravity = [0, 0, 0]
[contact]
range = 0.004
[material.cloth]
bending_stiffness = 1e-5
stiffness_damping = 1e-3
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [9, 9] }
[[body.pin]]
edges = ["first_row"]
)" + pin;
}

const std::string turning = "motion = { angular_velocity_deg = [0, 0, 720] }\n";
const std::string sliding = "axes = [\"x\", \"y\"]\n";

// A sheet lies still on two rails, and another one falls. The rails rise when the first one could
// have slept for long.
TEST(SlidingMotion, KeepsItsBodyAwake) {
  const std::string sheets = R"(
[[body]]
name = "falling"
position = [1, 0, 0]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [5, 5] }
[[body]]
name = "railed"
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [5, 5] }
[[body.pin]]
rows = [0, -1]
axes = ["z"]
)";
  // Returns the height of the rails at 1.5 s, and the number of bodies that sleep.
  const auto run = [&](const std::string& motion) {
    auto simulation =
        make_simulation(parse_case(sheets + motion, "test.toml", {"time.duration=1.6"}));
    EXPECT_FALSE(simulation.advance(1.5));
    const StateSummary end = simulation.summary_of(simulation.time(), simulation.state());
    return std::pair(simulation.position("railed").front().z(), end.sleeping_bodies);
  };
  const auto [height, sleeping] = run("motion = { velocity = [0, 0, 0.1], start_time = 1.0 }\n");
  EXPECT_NEAR(height, 0.05, 1e-3);
  EXPECT_EQ(sleeping, 0);
  EXPECT_EQ(run("").second, 1);  // rails that stay let it sleep
}

TEST(SlidingMotion, CountsForTheSpeedOfImpacts) {
  const std::string pin = "motion = { velocity = [0, 0, 20] }\n";
  const auto speed = [](const std::string& text) {
    return expected_impact_speed(*build_scene(parse_case(text, "test.toml")));
  };
  EXPECT_GT(speed(pinned_sheet(pin)), 19.9);
  EXPECT_EQ(speed(pinned_sheet("axes = [\"z\"]\n" + pin)), speed(pinned_sheet(pin)));
}

TEST(SlidingMotion, TakesFurtherIterations) {
  const Overrides preview =
      method("euler", {"time.step=0.005", "time.newton=1", "time.duration=0.2"});
  for (const std::string& axes : {std::string(), sliding}) {
    SimulatedCase sheet(pinned_sheet(axes + turning), preview);
    sheet.advance_to(0.2);
    const IntegratorCounts counts = sheet.integrator().counts();
    EXPECT_GE(counts.newton_iterations, 2 * counts.steps) << axes;
  }
}

TEST(SlidingMotion, LimitsTheTurnOfAStep) {
  SimulatedCase sheet(pinned_sheet(sliding + "motion = { angular_velocity_deg = [0, 0, 3600] }\n"),
                      method("euler", {"time.step=0.01", "time.duration=0.05"}));
  double last = 0;
  while (sheet.integrator().time() < 0.05) {
    if (const auto failure = sheet.integrator().step()) FAIL() << failure->text;
    const double time = sheet.integrator().time();
    EXPECT_LE((time - last) * 62.84, MotionLimits::largest_turn * 1.001);  // 3600 degrees are 62.83
    last = time;
  }
}

// Other pins start where their motion is at t = 0. So do these, in the directions that they hold.
TEST(SlidingMotion, BeginsAtItsPlace) {
  const std::string pin =
      "axes = [\"z\"]\nmotion = { keyframes = [{ time = 0, translation = [0.01, 0, 0.05] }, "
      "{ time = 0.1, translation = [0.01, 0, 0.05] }] }\n";
  SimulatedCase sheet(pinned_sheet(pin));
  const std::vector<Vec3> start = sheet.positions_at(0);
  for (int col = 0; col < 9; ++col) {
    EXPECT_NEAR(start[col].z(), 0.05, 1e-15);
    EXPECT_NEAR(start[col].x(), -0.1 + 0.025 * col, 1e-15);
  }
  for (int i = 9; i < 81; ++i) EXPECT_EQ(start[i].z(), 0);
}

// A brake holds two sheets up for a second and lets go of them. Both fall, though they could sleep
// before.
TEST(SlidingMotion, DampingThatVariesKeepsBodiesAwake) {
  const std::string text = R"(
[time]
duration = 1.5
[contact]
enabled = false
[material.cloth]
stiffness_damping = 1e-3
mass_damping = { times = [1.0, 1.1], values = [1e8, 0.0] }
[[body]]
name = "one"
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [5, 5] }
[[body]]
name = "two"
position = [1, 0, 0]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [5, 5] }
)";
  auto simulation = make_simulation(parse_case(text, "test.toml"));
  ASSERT_FALSE(simulation.advance(1.5));
  for (const char* name : {"one", "two"})
    EXPECT_NEAR(simulation.position(name).front().z(), -0.5 * 9.81 * 0.16, 0.01) << name;
}

}  // namespace
}  // namespace weft::sim::sliding_motion_test
