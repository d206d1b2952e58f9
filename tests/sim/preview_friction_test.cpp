// Single corrections take the friction of the end of their step, by Coulomb's law.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "materials/contact.h"
#include "sim/contact/contact_pair.h"
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

// The friction that the linear system assumed at the end of a step, with a slope along and across
// the sliding velocity.
Sliding assumed(double sign) {
  Sliding sliding;
  sliding.velocity = Vec3(0.3, 0.1, 0);
  sliding.slope = sign * Vec3(2, 3, 0).asDiagonal();
  sliding.hold_rate = 7;
  return sliding;
}

// The linear system then sees a force that is Coulomb's at the velocity `u` that it has led to.
Vec3 force_at(const Sliding& sliding, const Vec3& u) {
  return sliding.force - sliding.slope * (u - sliding.velocity);
}

// Features slide on where the assumed friction exceeds the limit, or where the limit would not end
// the sliding, and are slowed down in proportion elsewhere. Terms that are subtracted have negative
// limits, and no slope that could make the matrix indefinite.
TEST(PreviewFriction, ObeysCoulombsLawAtTheEndOfAStep) {
  const double friction_speed = 0.1, limit = 0.4;
  const Vec3 normal(0, 0, 1);
  struct Case {
    Vec3 velocity;
    double assumed, slowing;  // the assumed friction as a part of the limit, and m/s
    bool slides_on;
  };
  for (const auto& [u, part, slowing, slides_on] :
       {Case{Vec3(0.2, -0.1, 0), 2, 9, true}, Case{Vec3(0.2, -0.1, 0), 0.5, 0.2, true},
        Case{Vec3(0.2, -0.1, 0), 0.5, 0.3, false}, Case{Vec3(0.03, 0.01, 0), 2, 9, true},
        Case{Vec3(0.03, 0.01, 0), 0.5, 0.02, false}}) {
    for (const double sign : {1.0, -1.0}) {
      Sliding sliding = assumed(sign);
      const Vec3 before = -sign * part * limit * u.normalized();
      sliding.force = before + sliding.slope * (u - sliding.velocity);
      const double change =
          follow_step({u, sign * limit, slowing}, normal, sign < 0, friction_speed, sliding);
      const double over_speed = materials::friction_factor(u.norm(), friction_speed).over_speed;
      const Vec3 law = -sign * limit * (slides_on ? 1 / u.norm() : over_speed) * u;
      EXPECT_LT((force_at(sliding, u) - law).norm(), 1e-14) << u << slowing;
      EXPECT_NEAR(change, (law - before).norm(), 1e-14) << u << slowing;
      EXPECT_EQ(sliding.limit.now, sign * limit);
      EXPECT_EQ(sliding.stiffness, 7 * sliding.slope);
      EXPECT_LT((sliding.slope * normal).norm(), 1e-14) << u << slowing;
      const Vec3 across(-u.y(), u.x(), 0);
      const double secant = sign > 0 ? law.norm() / u.norm() : 0;
      EXPECT_LT((sliding.slope * across - secant * across).norm(), 1e-14) << u << slowing;
      EXPECT_LT((sliding.slope * u - (slides_on ? 0 : secant) * u).norm(), 1e-14) << u << slowing;
    }
  }
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

// A ball that bounces on a floor.
SimulatedCase bouncing_ball(double speed, double step) {
  return SimulatedCase(R"(
[time]
duration = 0.2
[world]
gravity = [0, 0, 0]
[contact]
friction = 0.2
range = 0.01
[[particles]]
name = "ball"
radius = 0.05
density = 100
restitution = 0.5
positions = { type = "grid", count = [1, 1, 1], spacing = 1, centre = [0, 0, 0.17] }
velocity = [)" + std::to_string(speed) +
                           R"(, 0, -2]
[[obstacle]]
name = "floor"
shape = { type = "rectangle", size = [9, 9], resolution = [3, 3] }
)",
                       method("euler", {key("step", step), "time.newton=1"}));
}

// On its way down, the push grows by more than friction would take at the start of the step.
TEST(PreviewFriction, BouncingBallsLoseSpeedInProportionToTheirPush) {
  for (const double step : {0.005, 0.001}) {
    SimulatedCase run = bouncing_ball(3, step);
    int pushed = 0;
    for (Vec3 last(3, 0, -2); run.integrator().time() < 0.2;) {
      ASSERT_FALSE(run.integrator().step());
      const Vec3 now = StateView::of(run.integrator().state()).velocity[0];
      const double lift = now.z() - last.z();
      if (lift > 1e-6) {
        EXPECT_NEAR(last.x() - now.x(), 0.2 * lift, 1e-3 * lift) << run.integrator().time();
        ++pushed;
      }
      last = now;
    }
    EXPECT_GE(pushed, 2) << step;
  }
}

// Friction ends the sliding of a ball where it rolls, and never reverses it.
TEST(PreviewFriction, BouncingBallsRollAtLast) {
  for (const double step : {1.0 / 60, 0.005, 0.001}) {
    SimulatedCase run = bouncing_ball(0.3, step);
    while (run.integrator().time() < 0.2) {
      ASSERT_FALSE(run.integrator().step());
      const double speed = StateView::of(run.integrator().state()).velocity[0].x();
      EXPECT_GT(speed, 5.0 / 7 * 0.3 - 1e-4) << step;
    }
    const double speed = StateView::of(run.integrator().state()).velocity[0].x();
    EXPECT_LT(speed, 5.0 / 7 * 0.3 + 2e-3) << step;
  }
}

// Many samples of a shell act on the same control points, so that each of them alone would end the
// sliding much later than all of them do. Friction of the last steps is proportional to the speed.
TEST(PreviewFriction, SlidingShellsStop) {
  const double step = 1.0 / 60, coefficient = 0.5;
  for (const double speed : {0.22, 0.26, 0.3}) {
    SimulatedCase sim("[contact]\nfriction = " + std::to_string(coefficient) + R"(
[material.plate]
model = "shell"
volume_density = 1000
shell_thickness = 2e-3
youngs_modulus = 1e6
poisson_ratio = 0.3
[[body]]
name = "plate"
material = "plate"
position = [0, 0, 3.392e-3]
velocity = [)" + std::to_string(speed) +
                          R"(, 0, 0]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [9, 9] }
[[obstacle]]
name = "floor"
shape = { type = "plane", size = [6, 6] }
)",
                      by_step(step));
    for (int i = 1; i <= 8; ++i) {
      const double loss = step * coefficient * g, expected = speed - i * loss;
      const double now = mean_velocity(sim, i * step).x();
      EXPECT_GT(now, std::max(expected, 0.0) - 1e-4) << speed << ' ' << i;
      EXPECT_LT(now, expected > loss ? expected + 0.01 * speed : loss) << speed << ' ' << i;
    }
    EXPECT_NEAR(mean_velocity(sim, 10 * step).x(), 0, 1e-3) << speed;
  }
}

}  // namespace
}  // namespace weft::sim::preview_friction_test
