// Sliding cloth against closed forms of Coulomb's friction, with a friction for each pair.
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "sim/contact/contact.h"
#include "tests/sim/gap_under.h"
#include "tests/sim/simulated_case.h"

namespace weft::sim::friction_test {
namespace {

constexpr double g = 9.81;
constexpr double thickness = 1e-3;  // m, of everything here

std::string text_of(double number) {
  std::ostringstream text;
  text.precision(17);
  text << number;
  return text.str();
}
std::string text_of(const Vec3& vector) {
  return '[' + text_of(vector.x()) + ", " + text_of(vector.y()) + ", " + text_of(vector.z()) + ']';
}

std::string sheet(const std::string& name, const Vec3& place, const Vec3& velocity,
                  double side = 0.2) {
  return "[[body]]\nname = \"" + name + "\"\nmaterial = \"cloth\"\nposition = " + text_of(place) +
         "\nvelocity = " + text_of(velocity) + "\nshape = { type = \"rectangle\", size = [" +
         text_of(side) + ", " + text_of(side) + "], resolution = [4, 4] }\n";
}
std::string floor_at(const std::string& name, double y, const std::string& material) {
  return "[[obstacle]]\nname = \"" + name + "\"\nmaterial = \"" + material + "\"\nposition = [0, " +
         text_of(y) + ", 0]\nshape = { type = \"plane\", size = [3, 0.8] }\n";
}
std::string pair(const std::string& one, const std::string& other, double friction) {
  return "[[contact.pair]]\nbetween = [\"" + one + "\", \"" + other +
         "\"]\nfriction = " + text_of(friction) + '\n';
}

double mean_x(const SimulatedCase& sim, const std::vector<Vec3>& values, const char* name) {
  for (const SceneBody& body : sim.scene().bodies) {
    if (body.name != name) continue;
    double sum = 0;
    for (int i = 0; i < body.particle_count(); ++i) sum += values[body.first_particle + i].x();
    return sum / body.particle_count();
  }
  ADD_FAILURE() << name;
  return 0;
}

std::vector<Vec3> velocities_at(SimulatedCase& sim, double time) {
  std::vector<Vec3> position, velocity;
  sim.dynamics().expand_all(time, sim.advance_to(time), position, velocity);
  return velocity;
}

// Four sheets of cloth start at `speed` (m/s) along x: "by_default" on the floor "wide", "by_name"
// and "by_material" on floors of ice, and "upper" on a sheet that rests on the floor "wide".
std::string sliding_sheets(double speed) {
  const double weight = 0.2 * g;
  const double height = thickness + gap_under(weight);
  const double below = thickness + gap_under(2 * weight);
  return "[time]\nduration = 1\nposition_tolerance = 1e-6\n"
         "[contact]\nfriction = 0.9\nfriction_speed = 2e-3\n"
         "[material.cloth]\nstiffness_damping = 1e-3\n[material.ice]\n[material.wood]\n" +
         sheet("by_default", {-1, 0.15, height}, {speed, 0, 0}) +
         sheet("by_name", {-1, 1, height}, {speed, 0, 0}) +
         sheet("by_material", {-1, 2, height}, {speed, 0, 0}) +
         sheet("lower", {-1, -0.15, below}, {0, 0, 0}, 0.3) +
         sheet("upper", {-1.05, -0.15, below + height}, {speed, 0, 0}, 0.1) +
         floor_at("wide", 0, "wood") + floor_at("first", 1, "ice") + floor_at("second", 2, "ice") +
         pair("first", "by_name", 0.4) + pair("cloth", "ice", 0.25) + pair("upper", "lower", 0.5);
}

// A sheet that starts at a speed v stops after v^2 / (2 mu g). Below friction_speed = e friction
// falls to zero; from there to the stop it slides by e^2 ln 2 / (mu g).
TEST(Friction, SlidingSheetsStopAfterTheDistanceOfTheirPair) {
  constexpr double speed = 0.6;
  SimulatedCase sim(sliding_sheets(speed));
  const std::vector<Vec3> start = sim.positions_at(0), end = sim.positions_at(0.3);
  const auto distance = [&](const char* name) {
    return mean_x(sim, end, name) - mean_x(sim, start, name);
  };
  const auto expected = [&](double friction) { return speed * speed / (2 * friction * g); };
  EXPECT_NEAR(distance("by_default") / expected(0.9), 1, 0.01);
  EXPECT_NEAR(distance("by_name") / expected(0.4), 1, 0.01);
  EXPECT_NEAR(distance("by_material") / expected(0.25), 1, 0.01);
  EXPECT_NEAR((distance("upper") - distance("lower")) / expected(0.5), 1, 0.01);
}

// contact.friction varies in time; the friction of a pair does not.
// The damping of contact has no part in the limit of friction. Over a whole impact it has hardly an
// impulse either, so the friction's impulse is that of Coulomb's law.
TEST(Friction, OfAnImpactIsInProportionToItsPush) {
  for (const double damping_time : {1e-3, 1e-4}) {
    for (const double speed : {0.05, 0.2, 1.0, 3.0}) {
      SimulatedCase sim(
          "[world]\ngravity = [0, 0, 0]\n[material.cloth]\ndensity = 0.2\n"
          "stiffness_damping = 1e-3\n" +
              sheet("falling", {0, 0, 3.5e-3}, {4, 0, -speed}) +
              "[[obstacle]]\nname = \"floor\"\nshape = { type = \"plane\", size = [4, 4] }\n",
          {"contact.friction=0.3", "contact.damping_time=" + text_of(damping_time),
           "time.position_tolerance=1e-6", "time.velocity_tolerance=1e-4",
           "time.relative_tolerance=1e-4"});
      const std::vector<double> end = sim.advance_to(0.06 + 0.01 / speed);
      Vec3 mean = Vec3::Zero();
      for (const Vec3& velocity : StateView::of(end).velocity) mean += velocity / 16;
      EXPECT_GT(mean.z(), 0);
      EXPECT_NEAR((4 - mean.x()) / (mean.z() + speed), 0.3, 0.03) << damping_time << ' ' << speed;
    }
  }
}

TEST(Friction, OfAPairStaysWhereTheDefaultVaries) {
  constexpr double speed = 0.3, change = 0.02;
  SimulatedCase sim(sliding_sheets(speed), {"contact.friction={ times = [0, " + text_of(change) +
                                            "], values = [0, 0.9], between = \"step\" }"});
  const std::vector<Vec3> start = sim.positions_at(0), end = sim.positions_at(0.15);
  const auto distance = [&](const char* name) {
    return mean_x(sim, end, name) - mean_x(sim, start, name);
  };
  EXPECT_NEAR(distance("by_default") / (speed * change + speed * speed / (2 * 0.9 * g)), 1, 0.01);
  EXPECT_NEAR(distance("by_name") / (speed * speed / (2 * 0.4 * g)), 1, 0.01);
}

// Sheets on two floors of one scene. Gravity is inclined by `angle`, so that the floors are slopes
// down along x.
std::string slopes(double angle, double first, double second) {
  const double height = thickness + gap_under(0.2 * g * std::cos(angle));
  return "[time]\nduration = 1\nposition_tolerance = 1e-6\n"
         "[world]\ngravity = " +
         text_of(Vec3(g * std::sin(angle), 0, -g * std::cos(angle))) +
         "\n[contact]\nfriction_speed = 2e-3\n"
         "[material.cloth]\nstiffness_damping = 1e-3\n[material.floor]\n" +
         sheet("one", {-1, 0, height}, {0, 0, 0}) + sheet("other", {-1, 1, height}, {0, 0, 0}) +
         floor_at("first", 0, "floor") + floor_at("second", 1, "floor") +
         pair("first", "one", first) + pair("second", "other", second);
}

// A sheet slides with the acceleration g (sin a - mu cos a) if mu < tan a.
TEST(Friction, SheetsSlideDownASlopeWithTheAccelerationOfTheirPair) {
  constexpr double angle = 20 * std::numbers::pi / 180;
  for (const auto& [first, second] : {std::pair{0.0, 0.2}, {0.3, 0.98 * std::tan(angle)}}) {
    SimulatedCase sim(slopes(angle, first, second));
    const std::vector<Vec3> early = velocities_at(sim, 0.1), late = velocities_at(sim, 0.3);
    for (const auto& [name, friction] : {std::pair{"one", first}, {"other", second}}) {
      const double exact = g * (std::sin(angle) - friction * std::cos(angle));
      EXPECT_NEAR((mean_x(sim, late, name) - mean_x(sim, early, name)) / 0.2 / exact, 1, 0.01)
          << friction;
    }
  }
}

// A sheet creeps if mu > tan a. Its speed s balances the slope: mu phi(s / e) = tan a with
// phi(r) = 2 r - r^2 and the friction_speed e. Hence s = e (1 - sqrt(1 - tan a / mu)), which is at
// most e tan a / mu, since phi(r) >= r.
TEST(Friction, StickingSheetsCreepWithinTheBoundOfFrictionSpeed) {
  constexpr double angle = 20 * std::numbers::pi / 180, speed = 2e-3;
  const double slope = std::tan(angle);
  for (const auto& [first, second] : {std::pair{1.02 * slope, 0.5}, {1.0, 2.0}}) {
    SimulatedCase sim(slopes(angle, first, second));
    const std::vector<Vec3> early = sim.positions_at(0.5), late = sim.positions_at(1);
    for (const auto& [name, friction] : {std::pair{"one", first}, {"other", second}}) {
      const double creep = (mean_x(sim, late, name) - mean_x(sim, early, name)) / 0.5;
      EXPECT_LE(creep, speed * slope / friction) << friction;
      EXPECT_NEAR(creep / (speed * (1 - std::sqrt(1 - slope / friction))), 1, 1e-3) << friction;
    }
  }
}

// A sheet on a plate that turns: with the same friction the motion is the same, to the last bit,
// whether all pairs have it or one.
TEST(Friction, OfTheOnlyPairActsAsThatOfAllPairs) {
  const std::string text = "[time]\nduration = 1\n[material.cloth]\n" +
                           sheet("sheet", {0.3, 0, 2.5e-3}, {0, 0, 0}) +
                           floor_at("plate", 0, "cloth") +
                           "motion = { angular_velocity_deg = [0, 0, 90], centre = [0, 0, 0] }\n";
  const Overrides preview{"time.method=euler", "time.step=5e-3", "time.newton=1"};
  for (Overrides overrides : {Overrides{}, preview}) {
    SimulatedCase only(text + pair("sheet", "plate", 0.3), overrides), none(text, overrides);
    overrides.emplace_back("contact.friction=0.3");
    SimulatedCase all(text, overrides);
    const std::vector<Vec3> end = all.positions_at(0.1);
    EXPECT_EQ(only.positions_at(0.1), end);
    EXPECT_NE(none.positions_at(0.1), end);
  }
}

// A sheet that is folded over: 4 rows, of which two lie above the other two. The upper part moves
// along the rows, faster than friction_speed.
TEST(Friction, OfABodyWithItselfIsThatOfItsPair) {
  for (const auto& [extra, friction] :
       {std::pair<std::string, double>{"", 0.2},
        {pair("cloth", "cloth", 0.6), 0.6},
        {pair("cloth", "cloth", 0.6) + pair("sheet", "sheet", 0), 0.0}}) {
    const auto scene = build_scene(parse_case(
        "[time]\nduration = 1\n[contact]\nfriction = 0.2\n[material.cloth]\n[[body]]\nname = "
        "\"sheet\"\nshape = { type = \"rectangle\", size = [0.3, 0.3], resolution = [4, 9] }\n" +
            extra,
        "test.toml"));
    Statistics statistics;
    Contact contact(*scene, statistics);
    std::vector<Vec3> x = scene->initial_position, v(x.size(), Vec3::Zero());
    for (std::size_t i = 0; i < x.size(); ++i) {
      const std::size_t row = i / 9;
      if (row < 2) continue;
      x[i] = x[i - 9 * (2 * row - 3)] + Vec3(0.003, 0, 2e-3);
      v[i] = {0.5, 0, 0};
    }
    ASSERT_FALSE(contact.evaluate(x, v, 1));
    std::vector<Vec3> normal(x.size(), Vec3::Zero()), rub = normal;
    contact.add_forces(normal, rub);
    Vec3 push = Vec3::Zero(), drag = Vec3::Zero();
    for (std::size_t i = 18; i < x.size(); ++i) {
      push += normal[i];
      drag += rub[i];
    }
    EXPECT_GT(push.z(), 0);
    EXPECT_NEAR(-drag.x(), friction * push.z(), 1e-9 * push.z()) << extra;
    EXPECT_EQ(statistics.counters.friction_terms > 0, friction > 0) << extra;
  }
}

}  // namespace
}  // namespace weft::sim::friction_test
