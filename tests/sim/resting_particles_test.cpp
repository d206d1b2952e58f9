// Rigid particles by impulses that come to rest, and what strikes those that rest.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "sim/simulation/simulation.h"
#include "tests/sim/ball_on_floor.h"
#include "tests/sim/simulated_case.h"

namespace weft::sim::resting_particles_test {
namespace {

constexpr double gravity = 9.81;
// Height (m) of a ball's centre on the floor: the radius, half the floor's thickness, the rest gap.
constexpr double rest_height = 0.02 + 0.5e-3 + 0.02e-3;

Simulation simulate(const std::string& text, const Overrides& overrides) {
  return Simulation(build_scene(parse_case(text, "test.toml", overrides)));
}

std::string place_above_rest(double height) {
  return "particles.ball.positions.centre=[0.003, 0.001, " + std::to_string(rest_height + height) +
         "]";
}

// Balls fall onto a floor within a rim, by default in a column of six.
const std::string falling_balls = R"(
[time]
method = "impulses"
duration = 20
[[particles]]
name = "ball"
radius = 0.02
friction = 0.4
positions = { type = "grid", count = [1, 1, 6], centre = [0, 0, 0.3] }
[[obstacle]]
name = "floor"
shape = { type = "disc", radius = 0.3, resolution = [5] }
[[obstacle]]
name = "rim"
position = [0, 0, 0.4]
shape = { type = "cylinder", radius = 0.12, length = 0.8, resolution = [3, 64] }
)";

// Returns the root mean square (m/s) of the vertical speeds of all balls during half a second from
// `time`. Balls that have rolled off others may roll on.
double mean_speed_from(double time, const Overrides& overrides) {
  Simulation simulation = simulate(falling_balls, overrides);
  if (const auto failure = simulation.advance(time)) ADD_FAILURE() << failure->text;
  double sum = 0;
  int count = 0;
  while (simulation.time() < time + 0.5) {
    if (const auto failure = simulation.step()) {
      ADD_FAILURE() << failure->text;
      break;
    }
    for (const Vec3& velocity : simulation.velocity("ball")) {
      sum += velocity.z() * velocity.z();
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

// Balls of this size that fall for half a step of the default length are as fast as 0.022 m/s. Two
// balls with 0.95 bounce for ten seconds.
TEST(RestingParticles, RestInColumns) {
  for (const char* restitution : {"0.5", "0.8", "0.9", "0.95"}) {
    for (const char* number : {"2", "6"}) {
      const double speed = mean_speed_from(
          12, {std::string("particles.ball.restitution=") + restitution,
               std::string("particles.ball.positions.count=[1, 1, ") + number + "]"});
      EXPECT_LT(speed, 3e-3) << "restitution " << restitution << ", " << number << " balls";
    }
  }
}

// With 0.98, one heap in eight still moves after four seconds, and none after six.
TEST(RestingParticles, RestInHeaps) {
  for (const auto& [restitution, time] : {std::pair("0.5", 4), {"0.9", 6}, {"0.98", 10}}) {
    const double speed = mean_speed_from(
        time, {std::string("particles.ball.restitution=") + restitution,
               "particles.ball.positions.count=[4, 4, 6]", "particles.ball.positions.jitter=0.0015",
               "particles.ball.positions.centre=[0, 0, 0.35]"});
    EXPECT_LT(speed, 6e-3) << "restitution " << restitution;
  }
}

// Returns the height (m) of a ball's first bounce above `lowest`, or 0 if it makes none in a
// second.
double first_bounce(Simulation& simulation, const std::string& name, double lowest) {
  double last_speed = -1;
  while (simulation.time() < 1) {
    if (const auto failure = simulation.step()) {
      ADD_FAILURE() << failure->text;
      break;
    }
    const double speed = simulation.velocity(name)[0].z();
    // The apex lies between two steps: height + v^2 / 2 g is constant in free flight.
    if (last_speed > 0 && speed <= 0)
      return simulation.position(name)[0].z() - lowest + speed * speed / (2 * gravity);
    last_speed = speed;
  }
  return 0;
}

// The lower ball takes what strikes it to the floor, as if it were a part of it.
TEST(RestingParticles, ABallBouncesOnOneThatRests) {
  const double lowest = rest_height + 2 * 0.02 + 0.02e-3;
  for (const double fall : {0.03, 0.3}) {
    const std::string upper = R"(
[[particles]]
name = "upper"
radius = 0.02
friction = 0
restitution = 0.5
positions = { type = "grid", count = [1, 1, 1], centre = [0.003, 0.001, )" +
                              std::to_string(lowest + fall) + "] }\n";
    for (const std::string& text : {ball_on_floor + upper, upper + ball_on_floor}) {
      for (const char* step : {"1e-3", "2.3e-3", "4e-3"}) {
        Simulation simulation =
            simulate(text, {std::string("time.step=") + step, place_above_rest(0)});
        EXPECT_NEAR(first_bounce(simulation, "upper", lowest) / (0.25 * fall), 1, 0.03)
            << "fall " << fall << ", step " << step;
      }
    }
  }
}

// A ball that does not return by its weight bounces at any speed, on the floor too.
TEST(RestingParticles, SlowBallsThatRestBounceSideways) {
  const std::string wall = R"(
[[obstacle]]
name = "wall"
position = [0.1, 0, 0]
rotation_deg = [0, 90, 0]
shape = { type = "rectangle", size = [2, 2], resolution = [3, 3] }
)";
  Simulation simulation = simulate(ball_on_floor + wall, {place_above_rest(0), "time.step=4e-3",
                                                          "particles.ball.velocity=[0.06, 0, 0]",
                                                          "particles.ball.restitution=0.9"});
  const auto failure = simulation.advance(2);
  ASSERT_FALSE(failure) << failure->text;
  EXPECT_NEAR(simulation.velocity("ball")[0].x(), -0.9 * 0.06, 1e-4);
}

// Two balls on a floor, the left one of which is faster, with gravity along and into the floor.
struct Followers {
  double gravity_along, speed, excess, other_radius;
};

// Returns the speed at which the balls part, divided by `excess`, the speed at which they met.
double parting_share(const Followers& of) {
  const std::string other = R"(
[[particles]]
name = "other"
radius = )" + std::to_string(of.other_radius) +
                            R"(
restitution = 0.9
friction = 0
velocity = [)" + std::to_string(of.speed) +
                            R"(, 0, 0]
positions = { type = "grid", count = [1, 1, 1], centre = [-0.95, 0.001, )" +
                            std::to_string(of.other_radius * 1.001 + 0.5e-3) + "] }\n";
  const double along = of.gravity_along;
  Simulation simulation =
      simulate(ball_on_floor + other,
               {"time.step=4e-3",
                "particles.ball.positions.centre=[-1, 0.001, " + std::to_string(rest_height) + "]",
                "particles.ball.velocity=[" + std::to_string(of.speed + of.excess) + ", 0, 0]",
                "particles.ball.restitution=0.9",
                "world.gravity=[" + std::to_string(along) + ", 0, " +
                    std::to_string(-std::sqrt(gravity * gravity - along * along)) + "]"});
  double share = 0;
  while (simulation.time() < 1 && share <= 0) {
    if (const auto failure = simulation.step()) {
      ADD_FAILURE() << failure->text;
      break;
    }
    share = (simulation.velocity("other")[0].x() - simulation.velocity("ball")[0].x()) / of.excess;
  }
  return share;
}

// No weight brings them together again, so that they part however slow they are.
TEST(RestingParticles, BallsThatRollDownASlopePartFromEachOther) {
  EXPECT_NEAR(parting_share({0, 0, 0.05, 0.02}), 0.9, 0.01);
  EXPECT_NEAR(parting_share({0.5 * gravity, 0.1, 0.05, 0.02}), 0.9, 0.01);
}

// Their normal is inclined: the smaller one is pressed to the floor, the larger one is not lifted.
TEST(RestingParticles, BallsOfOtherSizesPartFromEachOther) {
  EXPECT_NEAR(parting_share({0, 0, 0.05, 0.01}), 0.9, 0.1);
  EXPECT_NEAR(parting_share({0, 0, 0.1, 0.005}), 0.9, 0.1);
}

// A ball that is caught bears its weight from the impact on, and does not hop.
TEST(RestingParticles, ABallWithoutRestitutionStaysWhereItFalls) {
  for (const double fall : {1e-3, 2e-3, 5e-3, 0.02}) {
    Simulation simulation = simulate(
        ball_on_floor, {"time.step=4e-3", "particles.ball.restitution=0", place_above_rest(fall)});
    double highest = 0;
    while (simulation.time() < 0.3) {
      const auto failure = simulation.step();
      ASSERT_FALSE(failure) << failure->text;
      if (simulation.time() > std::sqrt(2 * fall / gravity) + 4e-3)
        highest = std::max(highest, simulation.position("ball")[0].z() - rest_height);
    }
    EXPECT_LT(highest, 5e-6) << "fall " << fall;
  }
}

TEST(RestingParticles, ABallThatRisesIsNotStoppedByWhatItLeaves) {
  const double start = 0.03, step = 4e-3;
  Simulation simulation = simulate(ball_on_floor, {"time.step=4e-3", place_above_rest(2e-6),
                                                   "particles.ball.velocity=[0, 0, 0.03]"});
  const auto failure = simulation.step();
  ASSERT_FALSE(failure) << failure->text;
  EXPECT_NEAR(simulation.velocity("ball")[0].z(), start - gravity * step, 1e-9);
}

// A ball of 5 cm in an obstacle of 0.5 m, whose inside is round.
std::string ball_within(const std::string& obstacle, const std::string& keys) {
  return "[time]\nmethod = \"impulses\"\nduration = 100\nframes_per_second = "
         "20\n[[particles]]\nname = "
         "\"ball\"\nradius = 0.05\n" +
         keys + "[[obstacle]]\nname = \"round\"\n" + obstacle;
}

const std::string bowl = "shape = { type = \"sphere\", radius = 0.5, resolution = [100] }\n";
const std::string gutter =
    "rotation_deg = [90, 0, 0]\n"
    "shape = { type = \"cylinder\", radius = 0.5, length = 1, resolution = [3, 720] }\n";

// The surface rises before the ball in each step, which must not be lifted for nothing. The facets
// take a few percent of the energy in ten swings.
TEST(RestingParticles, SwingsInABowlDoNotGrow) {
  for (const std::string& obstacle : {bowl, gutter}) {
    for (const char* friction : {"0", "0.5"}) {
      Simulation simulation = simulate(
          ball_within(obstacle,
                      "restitution = 0\npositions = { type = \"grid\", count = [1, 1, 1], centre = "
                      "[0.05, 0, -0.4465] }\n"),
          {std::string("particles.ball.friction=") + friction});
      const auto energy = [&] {
        const double height = simulation.position("ball")[0].z() + 0.45;
        return simulation.energies().kinetic + simulation.scene().mass[0] * gravity * height;
      };
      // The ball lies on the surface from the first steps on.
      auto failure = simulation.advance(0.1);
      ASSERT_FALSE(failure) << failure->text;
      const double first = energy();
      failure = simulation.advance(15);
      ASSERT_FALSE(failure) << failure->text;
      EXPECT_LT(energy(), 1.01 * first) << obstacle << "friction " << friction;
      EXPECT_GT(energy(), 0.9 * first) << obstacle << "friction " << friction;
    }
  }
}

// A ball that meets a facet steeply bounces, wherever the bends are.
TEST(RestingParticles, ABallThatMeetsAFacetSteeplyBounces) {
  for (const double place : {0.08, 0.1, 0.12, 0.14}) {
    Simulation simulation = simulate(
        ball_within(
            "thickness = 0\nrotation_deg = [90, 0, 0]\nshape = { type = \"cylinder\", "
            "radius = 0.5, length = 0.4, resolution = [3, 128] }\n",
            "friction = 0\nspin = false\nrestitution = 0.5\nvelocity = [0, 0, -1]\npositions "
            "= { type = \"grid\", count = [1, 1, 1], centre = [0, 0, 0] }\n"),
        {"world.gravity=[0, 0, 0]",
         "particles.ball.positions.centre=[" + std::to_string(place) + ", 0, 0]"});
    const auto failure = simulation.advance(0.6);
    ASSERT_FALSE(failure) << failure->text;
    // Facets differ from the round wall by up to 1.4 degrees.
    const double across = place / 0.45, left = simulation.velocity("ball")[0].squaredNorm();
    EXPECT_NEAR(left, across * across + 0.25 * (1 - across * across), 0.75 * 2 * across * 0.026)
        << place;
  }
}

// Lifts by bends late in a step are not paid for, and falls from bends early in a step are lost:
// coarse facets must not let swings grow.
TEST(RestingParticles, SwingsOnCoarseFacetsDoNotGrow) {
  for (const char* drum : {"32", "40", "48"}) {
    for (const char* restitution : {"0", "0.8"}) {
      Simulation simulation = simulate(
          ball_within("thickness = 0\nrotation_deg = [90, 0, 0]\nshape = { type = \"cylinder\", "
                      "radius = 0.5, length = 1, resolution = [3, " +
                          std::string(drum) + "] }\n",
                      "friction = 0\nspin = false\npositions = { type = \"grid\", count = [1, 1, "
                      "1], centre = [0.1157, 0, -0.4319] }\n"),
          {std::string("particles.ball.restitution=") + restitution});
      const auto energy = [&] {
        const double height = simulation.position("ball")[0].z() + 0.45;
        return simulation.energies().kinetic + simulation.scene().mass[0] * gravity * height;
      };
      const double first = energy();
      for (const double time : {10.0, 20.0, 30.0}) {
        const auto failure = simulation.advance(time);
        ASSERT_FALSE(failure) << failure->text;
        EXPECT_LT(energy(), 1.05 * first) << drum << " facets, e = " << restitution;
      }
    }
  }
}

// The velocity turns with the wall, and keeps its size.
TEST(RestingParticles, ABallGoesRoundInADrumAsFastAsBefore) {
  Simulation simulation = simulate(
      ball_within(
          "shape = { type = \"cylinder\", radius = 0.5, length = 1, resolution = [3, 2880] }\n",
          "restitution = 0\nfriction = 0\nvelocity = [0, 1, 0]\npositions = { type = "
          "\"grid\", count = [1, 1, 1], centre = [0.4485, 0, 0] }\n"),
      {"world.gravity=[0, 0, 0]"});
  // The ball meets the wall after 0.03 s.
  auto failure = simulation.advance(0.2);
  ASSERT_FALSE(failure) << failure->text;
  const double first = simulation.velocity("ball")[0].norm();
  failure = simulation.advance(5);
  ASSERT_FALSE(failure) << failure->text;
  EXPECT_NEAR(simulation.velocity("ball")[0].norm() / first, 1, 0.01);
}

}  // namespace
}  // namespace weft::sim::resting_particles_test
