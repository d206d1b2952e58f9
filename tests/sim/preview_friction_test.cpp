// Single corrections take the friction of the end of their step, by Coulomb's law.
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tests/sim/gap_under.h"
#include "tests/sim/simulated_case.h"

namespace weft::sim::preview_friction_test {
namespace {

constexpr double g = 9.81, friction = 0.3;

// A sheet on a floor of a slope, given by the direction of gravity. A `gap` of 0: that of rest.
std::string sheet_on_slope(double degrees, double gap, double speed, const std::string& contact) {
  const double angle = degrees * std::numbers::pi / 180;
  if (gap == 0) gap = gap_under(0.2 * g * std::cos(angle));
  return "[world]\ngravity = [" + std::to_string(g * std::sin(angle)) + ", 0, " +
         std::to_string(-g * std::cos(angle)) +
         "]\n[contact]\nfriction = " + std::to_string(friction) + "\n" + contact +
         "[material.cloth]\ndensity = 0.2\nstiffness_damping = 1e-3\n[[body]]\nname = \"sheet\"\n"
         "position = [0, 0, " +
         std::to_string(1e-3 + gap) + "]\nvelocity = [" + std::to_string(speed) +
         ", 0, 0]\n"
         "shape = { type = \"rectangle\", size = [0.2, 0.2], resolution = [5, 5] }\n"
         "[[obstacle]]\nname = \"floor\"\nshape = { type = \"plane\", size = [6, 6] }\n";
}

Overrides by_step(double step) { return method("euler", {"time.newton=1", key("step", step)}); }

Vec3 mean_velocity(SimulatedCase& sim, double time) {
  std::vector<Vec3> position, velocity;
  sim.dynamics().expand_all(time, sim.advance_to(time), position, velocity);
  Vec3 sum = Vec3::Zero();
  const int count = sim.scene().dynamic_particles;
  for (int i = 0; i < count; ++i) sum += velocity[i];
  return sum / count;
}

// Sliding grows in each step. With the friction of the sliding velocity at the start of a step,
// divided by its speed there, the sheet would accelerate by a tenth too little at first.
TEST(PreviewFriction, SheetsSlideDownASlope) {
  const double angle = 30 * std::numbers::pi / 180;
  const double expected = g * (std::sin(angle) - friction * std::cos(angle));
  for (const std::string contact : {"", "sticking_distance = 1e-4\n"}) {
    for (const double step : {1.0 / 60, 0.005}) {
      SimulatedCase sim(sheet_on_slope(30, 0, 0, contact), by_step(step));
      const double early = mean_velocity(sim, 12 * step).x(),
                   late = mean_velocity(sim, 24 * step).x();
      EXPECT_NEAR((late - early) / (12 * step), expected, 0.005 * expected) << contact << step;
      EXPECT_NEAR(early / (12 * step), expected, 0.1 * expected) << contact << step;
    }
  }
}

// A sheet that slides on a level floor loses the same speed in each step, but for the last ones.
TEST(PreviewFriction, SlidingSheetsStop) {
  const double step = 1.0 / 60, speed = 1;
  SimulatedCase sim(sheet_on_slope(0, 0, speed, ""), by_step(step));
  for (int i = 1; i < 16; ++i) {
    const double expected = speed - i * step * friction * g;
    EXPECT_NEAR(mean_velocity(sim, i * step).x(), expected, 0.01 * speed) << i;
  }
  EXPECT_LT(mean_velocity(sim, 23 * step).x(), 1e-3 * speed);
}

// A floor pushes off a sheet that starts in its barrier. The push at the start of the step is many
// times the one at its end, which the sheet's rise shows.
TEST(PreviewFriction, IsInProportionToThePushOfTheStep) {
  for (const double step : {1.0 / 60, 0.005}) {
    const double speed = 20;
    SimulatedCase sim(sheet_on_slope(0, 1.7e-3, speed, "damping_time = 0\n"), by_step(step));
    const Vec3 after = mean_velocity(sim, step);
    const double push = after.z() + g * step;  // by mass, times the step
    const double at_start =
        -materials::barrier(1.7e-3, 2e-3, 1e6).first / 0.2 * step;  // as long as the step
    EXPECT_GT(at_start, 4 * push);
    EXPECT_NEAR((speed - after.x()) / (friction * push), 1, 0.1) << step;
  }
}

// On a floor that rises with the sheet, the push of a step is no larger than at rest.
TEST(PreviewFriction, SheetsSlideInALift) {
  const double step = 0.005, speed = 1, lift = 0.5;
  std::string scene = sheet_on_slope(0, 0, speed, "");
  const std::string level = "velocity = [" + std::to_string(speed) + ", 0, 0]\n";
  scene.replace(scene.find(level), level.size(),
                "velocity = [" + std::to_string(speed) + ", 0, " + std::to_string(lift) + "]\n");
  scene += "motion = { velocity = [0, 0, " + std::to_string(lift) + "] }\n";
  SimulatedCase sim(scene, by_step(step));
  for (int i = 1; i <= 20; ++i) {
    const Vec3 now = mean_velocity(sim, i * step);
    EXPECT_NEAR(now.z(), lift, 1e-2) << i;
    EXPECT_NEAR(now.x(), speed - i * step * friction * g, 0.01 * speed) << i;
  }
}

// Anchors hold a sheet at rest, by what friction would let creep.
TEST(PreviewFriction, AnchoredSheetsRest) {
  for (const double step : {1.0 / 60, 0.005}) {
    SimulatedCase sim(sheet_on_slope(15, 0, 0, "sticking_distance = 1e-4\n"), by_step(step));
    EXPECT_LT(std::abs(mean_velocity(sim, 24 * step).x()), 1e-4) << step;
  }
}

// A sheet that friction can hold creeps as theory.md says, by any step.
TEST(PreviewFriction, HoldsSheetsOnAGentleSlope) {
  const double friction_speed = 0.01, slope = std::tan(15 * std::numbers::pi / 180);
  const double creep = friction_speed * (1 - std::sqrt(1 - slope / friction));
  for (const double step : {1.0 / 60, 0.005}) {
    SimulatedCase sim(sheet_on_slope(15, 0, 0, "friction_speed = 0.01\n"), by_step(step));
    EXPECT_NEAR(mean_velocity(sim, 24 * step).x(), creep, 0.01 * creep) << step;
  }
}

// Friction at the foot of a ball that rolls down a slope takes two sevenths of its acceleration.
TEST(PreviewFriction, BallsRollDownASlope) {
  const double angle = 20 * std::numbers::pi / 180, step = 0.005;
  SimulatedCase sim("[world]\ngravity = [" + std::to_string(g * std::sin(angle)) + ", 0, " +
                        std::to_string(-g * std::cos(angle)) +
                        "]\n[[particles]]\nname = \"ball\"\nradius = 0.02\nfriction = 0.5\n"
                        "restitution = 0\n"
                        "positions = { type = \"grid\", count = [1, 1, 1], centre = [0, 0, "
                        "0.0225] }\n[[obstacle]]\nname = \"floor\"\nshape = { type = \"plane\", "
                        "size = [6, 6] }\n",
                    by_step(step));
  const auto speed_at = [&](double time) {
    std::vector<Vec3> position, velocity;
    sim.dynamics().expand_all(time, sim.advance_to(time), position, velocity);
    return velocity[0].x();
  };
  const double early = speed_at(0.1), late = speed_at(0.4);
  EXPECT_NEAR((late - early) / 0.3, 5.0 / 7 * g * std::sin(angle), 0.02 * g);
}

}  // namespace
}  // namespace weft::sim::preview_friction_test
