// Particles that obstacles, pins, wind and varying gravity drive: they pass nothing, and their
// speeds are those of closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/case/case_reader.h"
#include "sim/scene/scene.h"
#include "sim/simulation/simulation.h"

namespace weft::sim::driven_particles_test {
namespace {

Simulation simulate(const std::string& text, const Overrides& overrides = {}) {
  return Simulation(build_scene(parse_case(text, "test.toml", overrides)));
}

void run_until(Simulation& simulation, double time) {
  if (const auto failure = simulation.advance(time - simulation.time()))
    ADD_FAILURE() << failure->text;
}

// A ball at rest on a floor whose top is the plane z = 0.
const std::string ball_on_floor = R"(
[time]
method = "impulses"
duration = 0.3
[[particles]]
name = "ball"
radius = 0.01
restitution = 0
positions = { type = "grid", count = [1, 1, 1], centre = [0.03, 0.02, 0.0101] }
[[obstacle]]
name = "floor"
thickness = 1e-3
position = [0, 0, -0.0005]
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3] }
)";

// The piston comes down in two steps of the default length, and the ball has nowhere to go.
TEST(DrivenParticles, APistonPressesNoBallThroughTheFloor) {
  for (const char* speed : {"3", "6", "30"}) {
    Simulation simulation = simulate(ball_on_floor + R"([[obstacle]]
name = "piston"
thickness = 1e-3
position = [0, 0, 0.1]
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3] }
motion = { velocity = [0, 0, -)" + speed +
                                     "] }\n");
    const auto failure = simulation.advance(0.2);
    ASSERT_TRUE(failure) << speed;
    EXPECT_NE(failure->text.find("there is no room"), std::string::npos) << failure->text;
    EXPECT_NE(failure->text.find("particles \"ball\", number 0"), std::string::npos);
    EXPECT_GE(simulation.position("ball")[0].z(), 0.01) << speed;
    EXPECT_NEAR(simulation.time(), (0.0995 - 0.02) / std::stod(speed), 1e-4) << speed;
  }
}

// Two plates close slowly on a ball. Steps that end just before a frame are a ten-thousandth of
// those that follow.
TEST(DrivenParticles, PlatesThatCloseSlowlyThrowNoBallThroughThem) {
  for (const char* frames : {"30", "100", "240"}) {
    Simulation simulation = simulate(std::string(R"(
[time]
method = "impulses"
duration = 1.2
frames_per_second = )") + frames + R"(
[[particles]]
name = "ball"
radius = 0.02
restitution = 0.3
positions = { type = "grid", count = [1, 1, 1] }
[[obstacle]]
name = "lower"
position = [0, 0, -0.05]
shape = { type = "plane", size = [1, 1] }
motion = { keyframes = [{ time = 0 }, { time = 1, translation = [0, 0, 0.03] }] }
[[obstacle]]
name = "upper"
position = [0, 0, 0.05]
shape = { type = "plane", size = [1, 1] }
motion = { keyframes = [{ time = 0 }, { time = 1, translation = [0, 0, -0.03] }] }
)");
    const auto failure = simulation.advance(1.2);
    ASSERT_TRUE(failure) << frames;
    EXPECT_NE(failure->text.find("there is no room"), std::string::npos) << failure->text;
    EXPECT_GT(simulation.time(), 0.8) << frames;
    EXPECT_NEAR(simulation.position("ball")[0].z(), 0, 2e-3) << frames;
  }
}

// A ball falls on sixteen balls of a fortieth of its radius. Pressed aside, none of them may pass
// the floor, which has no thickness.
TEST(DrivenParticles, AHeavyBallPressesNoSmallOnesThroughTheFloor) {
  Simulation simulation = simulate(R"(
[time]
method = "impulses"
duration = 0.3
[[particles]]
name = "small"
radius = 0.005
restitution = 0.3
friction = 0.3
positions = { type = "grid", count = [4, 4, 1], centre = [0.0001, 0.0002, 0.005505] }
[[particles]]
name = "big"
radius = 0.2
restitution = 0.3
friction = 0.3
positions = { type = "grid", count = [1, 1, 1], centre = [0, 0, 0.512] }
[[obstacle]]
name = "floor"
shape = { type = "plane", size = [100, 100] }
)");
  std::vector<Vec3> before = simulation.position("small");
  while (simulation.time() < 0.3) {
    const auto failure = simulation.step();
    ASSERT_FALSE(failure) << failure->text;
    for (int i = 0; i < 16; ++i) {
      const Vec3 now = simulation.position("small")[i];
      ASSERT_GE(now.z(), 0.005) << i << " at " << simulation.time();
      ASSERT_LE((now - before[i]).norm(), 0.75 * 0.005 * (1 + 1e-6)) << i;
      before[i] = now;
    }
  }
}

// A box with a heap moves gently. Its motion has a keyframe a third of a microsecond after a frame,
// between which there is a step.
TEST(DrivenParticles, AVeryShortStepKicksNoHeap) {
  Simulation simulation = simulate(R"(
[time]
method = "impulses"
duration = 1
[[particles]]
name = "balls"
radius = 0.02
restitution = 0.3
friction = 0.4
positions = { type = "grid", count = [4, 4, 9], centre = [0, 0, 0.02], jitter = 0.0015 }
[[obstacle]]
name = "box"
position = [0, 0, 0.05]
shape = { type = "box", size = [0.22, 0.22, 0.5], resolution = [5, 5, 9] }
motion = { keyframes = [{ time = 0 }, { time = 0.666667, translation = [0.02, 0, 0] }, { time = 2 }] }
)");
  run_until(simulation, 0.6);
  const double mass = 4.0 / 3 * std::numbers::pi * std::pow(0.02, 3) * 1000;
  double shortest = 1;
  while (simulation.time() < 0.75) {
    const double before = simulation.time();
    const auto failure = simulation.step();
    ASSERT_FALSE(failure) << failure->text;
    shortest = std::min(shortest, simulation.time() - before);
    double energy = 0;
    for (const Vec3& v : simulation.velocity("balls")) energy += 0.5 * mass * v.squaredNorm();
    ASSERT_LT(energy, 0.01) << simulation.time();
  }
  EXPECT_LT(shortest, 1e-6);
}

TEST(DrivenParticles, APloughPushesBallsAside) {
  Simulation simulation = simulate(R"(
[time]
method = "impulses"
duration = 1
[[particles]]
name = "balls"
radius = 0.01
restitution = 0.3
friction = 0.4
positions = { type = "grid", count = [5, 5, 4], centre = [0, 0, 0.06], jitter = 5e-4 }
[[obstacle]]
name = "floor"
thickness = 1e-3
position = [0, 0, -0.0005]
shape = { type = "rectangle", size = [20, 20], resolution = [3, 3] }
[[obstacle]]
name = "plough"
thickness = 1e-3
position = [-0.4, 0, 1.501]
rotation_deg = [0, 90, 0]
shape = { type = "rectangle", size = [3, 8], resolution = [3, 3] }
motion = { velocity = [5, 0, 0] }
)");
  while (simulation.time() < 0.3) {
    const auto failure = simulation.step();
    ASSERT_FALSE(failure) << failure->text;
    const double plough = -0.4 + 5 * simulation.time();
    for (const Vec3& place : simulation.position("balls")) {
      ASSERT_GE(place.x(), plough + 0.0105) << simulation.time();
      ASSERT_GE(place.z(), 0.01) << simulation.time();
    }
  }
}

// The corner of a plate that turns in its plane strikes a ball. There is room beside it.
TEST(DrivenParticles, APlateTurnsIntoABall) {
  for (const char* step : {"1e-2", "1e-3"}) {
    Simulation simulation = simulate(
        R"(
[time]
method = "impulses"
duration = 1
[world]
gravity = [0, 0, 0]
[[particles]]
name = "ball"
radius = 0.01
positions = { type = "grid", count = [1, 1, 1], centre = [0.215, 0.05, 0] }
[[obstacle]]
name = "plate"
shape = { type = "rectangle", size = [0.4, 0.4], resolution = [3, 3] }
motion = { angular_velocity_deg = [0, 0, 360] }
)",
        {std::string("time.step=") + step});
    run_until(simulation, 0.5);
    const Vec3 velocity = simulation.velocity("ball")[0];
    EXPECT_GT(velocity.norm(), 0.5) << step;
    EXPECT_LT(velocity.norm(), 5) << step;
  }
}

// Gravity that begins between two steps acts from then on, and steps end there.
TEST(DrivenParticles, GravityBeginsAtItsTime) {
  Simulation simulation = simulate(R"(
[time]
method = "impulses"
duration = 1
[world]
gravity = { times = [0, 0.1003], values = [[0, 0, 0], [0, 0, -9.81]], between = "step" }
[[particles]]
name = "ball"
radius = 0.02
positions = { type = "grid", count = [1, 1, 1], centre = [0, 0, 5] }
)");
  run_until(simulation, 0.5);
  const double fall = 0.5 - 0.1003;
  EXPECT_NEAR(simulation.velocity("ball")[0].z(), -9.81 * fall, 1e-5);
  EXPECT_NEAR(simulation.position("ball")[0].z(), 5 - 0.5 * 9.81 * fall * fall, 1e-4);
}

// A wind w that begins at t_0 accelerates a ball at rest to w - w / (1 + k w (t - t_0)), where k is
// half of the density of air times the drag per mass.
TEST(DrivenParticles, WindBeginsAtItsTime) {
  const double radius = 0.02, wind = 10, drag = 0.47, air = 10, density = 1000;
  const double k = 0.5 * air * drag * 0.75 / (radius * density);
  const double expected = wind - wind / (1 + k * wind * (0.5 - 0.1003));
  for (const std::string method : {"cvode", "arkode", "impulses"}) {
    Simulation simulation = simulate(R"(
[time]
duration = 1
[world]
gravity = [0, 0, 0]
air_density = 10
wind = { times = [0, 0.1003], values = [[0, 0, 0], [10, 0, 0]], between = "step" }
[[particles]]
name = "ball"
radius = 0.02
drag_coefficient = 0.47
positions = { type = "grid", count = [1, 1, 1] }
)",
                                     {"time.method=\"" + method + "\""});
    run_until(simulation, 0.5);
    EXPECT_NEAR(simulation.velocity("ball")[0].x() / expected, 1, 2e-3) << method;
  }
}

// Friction that grows evenly from 0 to 0.4 in a second takes g * 0.2 t^2 of a sliding ball's speed.
// A step has the friction of its middle.
TEST(DrivenParticles, SlideWithFrictionThatGrows) {
  Simulation simulation = simulate(R"(
[time]
method = "impulses"
duration = 1
step = 0.01
[contact]
friction = { times = [0, 1], values = [0, 0.4] }
[[particles]]
name = "ball"
radius = 0.02
spin = false
velocity = [2, 0, 0]
positions = { type = "grid", count = [1, 1, 1], centre = [-1, 0.01, 0.02052] }
[[obstacle]]
name = "floor"
shape = { type = "plane", size = [4, 4] }
)");
  run_until(simulation, 0.5);
  EXPECT_NEAR(2 - simulation.velocity("ball")[0].x(), 9.81 * 0.05, 1e-3 * 9.81 * 0.05);
}

// A storm takes a flake with it that drag stops within a tenth of a step. The flake is never faster
// than the wind, and moves by w t - ln(1 + k w t) / k, with k as above.
TEST(DrivenParticles, StormTakesLightSpheresWithIt) {
  const double radius = 0.02, wind = 50, drag = 0.47, air = 1.2, density = 0.2;
  const double k = 0.5 * air * drag * 0.75 / (radius * density);
  Simulation simulation = simulate(R"(
[time]
method = "impulses"
duration = 1
[world]
gravity = [0, 0, 0]
air_density = 1.2
wind = [50, 0, 0]
[[particles]]
name = "flake"
radius = 0.02
density = 0.2
drag_coefficient = 0.47
positions = { type = "grid", count = [1, 1, 1] }
)");
  while (simulation.time() < 0.5) {
    const auto failure = simulation.step();
    ASSERT_FALSE(failure) << failure->text;
    const double t = simulation.time();
    ASSERT_NEAR(simulation.velocity("flake")[0].x(), wind - wind / (1 + k * wind * t), 1e-9 * wind);
    ASSERT_NEAR(simulation.position("flake")[0].x(), wind * t - std::log(1 + k * wind * t) / k,
                0.05 * radius);
  }
}

// A floor that starts and stops at once carries a ball, which no frame shows inside it.
TEST(DrivenParticles, FramesBesideAFloorThatStopsHaveNoOverlap) {
  Simulation simulation = simulate(R"(
[time]
method = "impulses"
duration = 0.5
[output]
frame_times = [0.1, 0.1005, 0.101, 0.1503, 0.1995, 0.1999, 0.2, 0.2001, 0.2005, 0.25]
[[particles]]
name = "ball"
radius = 0.02
positions = { type = "grid", count = [1, 1, 1], centre = [0, 0, 0.0206] }
[[obstacle]]
name = "floor"
shape = { type = "plane", size = [2, 2] }
motion = { velocity = [0, 0, 2], start_time = 0.1005, stop_time = 0.2 }
)");
  const double half_thickness = simulation.scene().bodies.back().thickness / 2;
  for (const double time :
       {0.1, 0.1005, 0.101, 0.1503, 0.1995, 0.1999, 0.2, 0.2001, 0.2005, 0.25}) {
    run_until(simulation, time);
    const double floor = 2 * (std::clamp(time, 0.1005, 0.2) - 0.1005);
    const double gap = simulation.position("ball")[0].z() - floor - half_thickness - 0.02;
    EXPECT_GE(gap, 0) << time;
    if (time <= 0.1005) {
      EXPECT_LT(gap, 1e-4) << time;
    }
  }
}

// The spin of spheres that nothing touches is part of the energy of every state.
TEST(DrivenParticles, SpinsHaveTheirEnergyFromTheStart) {
  Simulation simulation = simulate(R"(
[time]
method = "impulses"
duration = 1
[world]
gravity = [0, 0, 0]
[[particles]]
name = "ball"
radius = 0.02
angular_velocity_deg = [0, 0, 3600]
positions = { type = "grid", count = [1, 1, 1] }
)");
  const double omega = 20 * std::acos(-1.0);
  const double expected = 0.2 * simulation.scene().mass[0] * 4e-4 * omega * omega;
  EXPECT_NEAR(simulation.energies().kinetic / expected, 1, 1e-12);
  run_until(simulation, 0.1);
  EXPECT_NEAR(simulation.energies().kinetic / expected, 1, 1e-12);
}

const std::string bouncing_ball = R"(
[[particles]]
name = "ball"
radius = 0.02
restitution = 1
spin = false
)";

std::string plate(const std::string& more) {
  return "[[obstacle]]\nname = \"plate\"\nthickness = 1e-3\n" + more +
         "shape = { type = \"rectangle\", size = [1, 1], resolution = [3, 3] }\n";
}

// A ball that sticks to a turntable goes round with it: two turns.
TEST(DrivenParticles, StickToATurntable) {
  Simulation simulation = simulate(R"(
[time]
method = "impulses"
duration = 4
[[particles]]
name = "ball"
radius = 0.05
friction = 3
spin = false
velocity = [0, 1.5707963267948966, 0]
positions = { type = "grid", count = [1, 1, 1], centre = [0.5, 0, 0.0505] }
[[obstacle]]
name = "table"
shape = { type = "rectangle", size = [3, 3], resolution = [5, 5] }
motion = { centre = [0, 0, 0], angular_velocity_deg = [0, 0, 180] }
)");
  for (const double time : {0.5, 1.0, 2.5, 4.0}) {
    run_until(simulation, time);
    const Vec3 place = simulation.position("ball")[0], velocity = simulation.velocity("ball")[0];
    const double angle = std::numbers::pi * time;
    EXPECT_LT((place - Vec3(0.5 * std::cos(angle), 0.5 * std::sin(angle), place.z())).norm(), 2e-3)
        << time;
    EXPECT_NEAR(velocity.norm() / (0.5 * std::numbers::pi), 1, 1e-3) << time;
  }
}

// A plate of 5 m/s meets a ball at rest, which flies off at 10 m/s.
TEST(DrivenParticles, ABatStrikesABall) {
  const std::string text =
      "[time]\nduration = 1\n[world]\ngravity = [0, 0, 0]\n" + bouncing_ball +
      "positions = { type = \"grid\", count = [1, 1, 1], centre = [0.03, 0.02, 0] }\n" +
      plate("position = [0, 0, -1]\nmotion = { velocity = [0, 0, 5] }\n");
  for (const std::string method : {"cvode", "arkode"}) {
    Simulation simulation = simulate(text, {"time.method=\"" + method + "\""});
    run_until(simulation, 0.3);
    EXPECT_NEAR(simulation.velocity("ball")[0].z(), 10, 0.1) << method;
  }
}

// Gravity that is zero at the start, wind, a keyframed plate and cloth drive what meets at last.
TEST(DrivenParticles, BarriersStopWhatIsDriven) {
  const std::string falling =
      "[time]\nduration = 1.2\n[world]\ngravity = { times = [0, 0.01], "
      "values = [[0, 0, 0], [0, 0, -9.81]] }\n" +
      bouncing_ball +
      "positions = { type = \"grid\", count = [1, 1, 1], "
      "centre = [0.03, 0.02, 5] }\n" +
      plate("");
  Simulation fall = simulate(falling);
  run_until(fall, 1.2);
  EXPECT_GT(fall.velocity("ball")[0].z(), 5);

  const std::string blown =
      "[time]\nduration = 1\n[world]\ngravity = [0, 0, 0]\nwind = [0, 0, 20]\n" + bouncing_ball +
      "density = 20\ndrag_coefficient = 0.47\n"
      "positions = { type = \"grid\", count = [1, 1, 1], "
      "centre = [0.03, 0.02, -2] }\n" +
      plate("");
  Simulation wind = simulate(blown);
  run_until(wind, 1);
  EXPECT_LT(wind.position("ball")[0].z(), -0.02);

  Simulation cloth =
      simulate("[time]\nduration = 0.02\n[world]\ngravity = [0, 0, 0]\n" + bouncing_ball + R"(
positions = { type = "grid", count = [1, 1, 1], centre = [0.003, 0.002, 0] }
[material.silk]
density = 0.1
[[body]]
name = "cloth"
position = [0, 0, -0.1]
velocity = [0, 0, 20]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [11, 11] }
)");
  run_until(cloth, 0.01);
  EXPECT_GT(cloth.velocity("ball")[0].z(), 0.1);
}

// The strength of barriers does not depend on where bodies are when a pin lets go.
// The strength of the barriers follows from all motions of the case, whether the run lasts until
// they begin or not. Otherwise a run that goes on (--extend) would find another strength, and balls
// at rest would be thrown up.
TEST(DrivenParticles, BarriersDoNotDependOnTheDuration) {
  const auto speed = [](const std::string& duration) {
    return build_scene(parse_case("[time]\nduration = " + duration + R"(
[[particles]]
name = "ball"
radius = 0.02
positions = { type = "grid", count = [1, 1, 1], centre = [0, 0, 0.03] }
[[obstacle]]
name = "far"
position = [5, 0, 0]
shape = { type = "plane", size = [1, 1] }
motion = { velocity = [0, 0, 20], start_time = 0.9, stop_time = 1 }
[[obstacle]]
name = "turning"
position = [-5, 0, 0]
shape = { type = "plane", size = [1, 1] }
motion = { keyframes = [{ time = 2 }, { time = 3, rotation_deg = [0, 0, 90] }] }
)",
                                  "test.toml"))
        ->impact_speed;
  };
  EXPECT_GT(speed("0.8"), 20);
  EXPECT_EQ(speed("0.8"), speed("4"));
}

TEST(DrivenParticles, APinThatLetsGoLeavesABounceAlone) {
  for (const char* release : {"1.2330", "1.2340", "1.2350"}) {
    Simulation simulation = simulate("[time]\nduration = 2\n" + bouncing_ball + R"(
positions = { type = "grid", count = [1, 1, 1], centre = [0.03, 0.02, 0.3205] }
[material.silk]
density = 0.1
[[body]]
name = "falling"
position = [4, 0, 0.3]
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [3, 3] }
[[body]]
name = "held"
position = [2, 0, 0.3]
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [3, 3] }
pin = [{ corners = ["first_first", "last_first", "first_last", "last_last"], release_time = )" +
                                     std::string(release) + " }]\n" + plate(""));
    double highest = 0;
    while (simulation.time() < 1.55) {
      const auto failure = simulation.step();
      ASSERT_FALSE(failure) << failure->text;
      if (simulation.time() > 1.24) highest = std::max(highest, simulation.position("ball")[0].z());
    }
    EXPECT_NEAR(highest, 0.3205, 0.02) << release;
  }
}

// A fall of 10 m onto a range of 2 mm is not too abrupt for the shortest step.
TEST(DrivenParticles, ADeepFallReboundsAsTheRestitutionSays) {
  for (const double e : {0.0, 0.7}) {
    Simulation simulation = simulate(
        "[time]\nduration = 3\n" + bouncing_ball +
            "positions = { type = \"grid\", count = [1, 1, 1], centre = [0.03, 0.02, 10] }\n" +
            plate(""),
        {"particles.0.restitution=" + std::to_string(e)});
    run_until(simulation, std::sqrt(2 * (10 - 0.02) / 9.81) + 0.02);
    const double up = simulation.velocity("ball")[0].z() + 9.81 * 0.02;
    EXPECT_NEAR(up, e * std::sqrt(2 * 9.81 * (10 - 0.02)), 0.3) << e;
  }
}

}  // namespace
}  // namespace weft::sim::driven_particles_test
