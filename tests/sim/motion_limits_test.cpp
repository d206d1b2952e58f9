// Step lengths near moving obstacles: limits against closed forms.
#include "sim/motion/motion_limits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "simulated_case.h"

namespace weft::sim::motion_limits_test {
namespace {

// A plate rises from below towards a sheet that falls at `falling` (m/s) from `height`.
std::string plate_below(double height, double falling, double rising) {
  return R"(
[time]
duration = 10
[world]
gravity = [0, 0, 0]
[contact]
range = 2e-3
[material.cloth]
[[body]]
name = "sheet"
thickness = 1e-3
position = [0, 0, )" +
         std::to_string(height) + "]\nvelocity = [0, 0, " + std::to_string(-falling) + R"(]
shape = { type = "rectangle", size = [1, 1], resolution = [5, 5] }
[[obstacle]]
name = "plate"
thickness = 1e-3
shape = { type = "rectangle", size = [2, 2], resolution = [5, 5] }
motion = { velocity = [0, 0, )" +
         std::to_string(rising) + "] }\n";
}

double longest_step(const std::string& text) {
  SimulatedCase sim(text);
  MotionLimits limits(sim.scene(), sim.dynamics());
  const auto end = limits.latest_end(0, 5, sim.dynamics().initial_state());
  EXPECT_TRUE(end);
  return end.value_or(0);
}

// Steps are shortened by fifths, so a step may be that much shorter than the limit.
void expect_limit(double length, double limit) {
  EXPECT_LE(length, limit * (1 + 1e-9));
  EXPECT_GT(length, 0.79 * limit);
}

TEST(MotionLimits, UseUpMostOfTheDistanceToWhatIsFar) {
  constexpr double clearance = 0.5 - 3e-3;
  for (const auto& [falling, rising] :
       {std::pair(0.0, 2.0), std::pair(8.0, 0.01), std::pair(3.0, 3.0)}) {
    expect_limit(longest_step(plate_below(0.5, falling, rising)),
                 MotionLimits::approach_part * clearance / (falling + rising));
  }
}

TEST(MotionLimits, UseUpMostOfTheDistanceToSpheres) {
  constexpr double radius = 0.02, half_thickness = 5e-4, range = 2e-3, falling = 1, rising = 3;
  const std::string text = R"(
[world]
gravity = [0, 0, 0]
[contact]
range = 2e-3
[[particles]]
name = "ball"
radius = 0.02
friction = 0.3
velocity = [0, 0, -1]
positions = { type = "grid", count = [1, 1, 1], centre = [0, 0, 0.5] }
[[obstacle]]
name = "plate"
thickness = 1e-3
shape = { type = "rectangle", size = [2, 2], resolution = [5, 5] }
motion = { velocity = [0, 0, 3] }
)";
  const double clearance = 0.5 - radius - half_thickness - range;
  expect_limit(longest_step(text), MotionLimits::approach_part * clearance / (falling + rising));
}

TEST(MotionLimits, GoAPartOfTheRangeWhereSurfacesAreNear) {
  for (const auto& [falling, rising] : {std::pair(0.0, 2.0), std::pair(-1.0, 3.0)}) {
    expect_limit(longest_step(plate_below(2.5e-3, falling, rising)),
                 MotionLimits::near_part * 2e-3 / (falling + rising));
  }
}

TEST(MotionLimits, LeaveStepsAloneThatCannotReach) {
  EXPECT_EQ(longest_step(plate_below(0.5, 0, 0.05)), 5);
  EXPECT_EQ(longest_step(plate_below(20, 1, 2)), 5);
}

// A sheet rotates with the plate below it, so at first they do not move against each other. The
// angle limits the step of a small sheet. That of a larger one is limited by how its corners would
// leave the plate on straight paths.
TEST(MotionLimits, TurnByASmallAngleWhereSurfacesAreNear) {
  const auto angle = [](const std::string& size) {
    return 2 * std::numbers::pi *
           longest_step(R"(
[time]
duration = 10
[world]
gravity = [0, 0, 0]
[contact]
range = 2e-3
[material.cloth]
[[body]]
name = "sheet"
thickness = 1e-4
position = [0, 0, 1e-3]
angular_velocity_deg = [0, 0, 360]
shape = { type = "rectangle", resolution = [2, 2], size = )" +
                        size + R"( }
[[obstacle]]
name = "plate"
thickness = 1e-4
shape = { type = "rectangle", resolution = [2, 2], size = )" +
                        size + R"( }
motion = { angular_velocity_deg = [0, 0, 360] }
)");
  };
  expect_limit(angle("[0.004, 0.004]"), MotionLimits::largest_turn);
  const double radius = 0.08 * std::numbers::sqrt2 / 2, way = MotionLimits::near_part * 2e-3;
  expect_limit(angle("[0.08, 0.08]"), std::sqrt(2 * way / radius));
}

}  // namespace
}  // namespace weft::sim::motion_limits_test
