// Pins that take hold or let go during a run, by every method that follows motion in time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>

#include "sim/accuracy/error_monitor.h"
#include "sim/case/case_checks.h"
#include "sim/run/make_simulation.h"
#include "tests/sim/joint_cases.h"
#include "tests/sim/simulated_case.h"

namespace weft::sim::timed_pins_test {
namespace {

constexpr double gravity = 9.81;   // m/s^2
constexpr double release = 0.037;  // s, no multiple of any step here

// A flat sheet, all of whose vertices a pin carries upwards until it lets go.
constexpr const char* carried_sheet = R"(
[time]
duration = 0.2
frames_per_second = 50
position_tolerance = 1e-7
[contact]
enabled = false
[material.cloth]
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [5, 5] }
[[body.pin]]
rows = [0, -1]
release_time = 0.037
motion = { velocity = [0, 0, 0.5] }
)";

// Returns the overrides and those that give the pin of the sheet further keys.
Overrides with_pin(Overrides all, const Overrides& keys) {
  for (const std::string& each : keys) all.push_back("body.sheet.pin.0." + each);
  return all;
}

double distance_between(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.size()));
}

struct Method {
  const char* name;
  Overrides overrides;
  double error;  // m
};

std::ostream& operator<<(std::ostream& stream, const Method& method) {
  return stream << method.name;
}

std::vector<Method> all_methods() {
  return {{"cvode", method("cvode"), 2e-5},
          {"arkode", method("arkode"), 1e-6},
          {"euler", method("euler"), 1e-3},
          {"euler_step", method("euler", {"time.step=1e-3"}), 1e-3},
          {"implicit_midpoint", method("implicit_midpoint", {"time.step=1e-3"}), 1e-9},
          {"verlet", method("verlet"), 1e-9},
          {"verlet_step", method("verlet", {"time.step=1e-3"}), 1e-9}};
}

class TimedPins : public testing::TestWithParam<Method> {};

// Returns the exact height after the release: x = v t_r + v s - g s^2 / 2 with s = t - t_r.
double thrown_height(double time) {
  const double since = std::max(0.0, time - release);
  return 0.5 * time - 0.5 * gravity * since * since;
}

}  // namespace

TEST_P(TimedPins, AReleasedSheetFliesOnAsThrown) {
  Simulation simulation = simulation_of(carried_sheet, GetParam().overrides);
  for (const double time : {0.02, release, 0.04, 0.1, 0.2}) {
    advance_to(simulation, time);
    const double error = time > release ? GetParam().error : 1e-14;
    for (const Vec3& place : simulation.position("sheet"))
      ASSERT_NEAR(place[2], thrown_height(time), error) << "t = " << time;
  }
  const Vec3 velocity = mean_of(simulation.velocity("sheet"));
  EXPECT_NEAR(velocity[2], 0.5 - gravity * (0.2 - release), 30 * GetParam().error + 1e-9);
}

TEST_P(TimedPins, AStepEndsAtTheRelease) {
  Simulation simulation = simulation_of(carried_sheet, GetParam().overrides);
  std::vector<double> times;
  while (simulation.time() < 0.1) {
    if (const auto failure = simulation.step()) FAIL() << failure->text;
    times.push_back(simulation.time());
  }
  EXPECT_EQ(std::ranges::count(times, release), 1);
}

// The centre of a sheet falls with g once its pins let go, however it is strained.
TEST_P(TimedPins, TheCentreOfAHangingSheetFalls) {
  Overrides overrides = with_pin(GetParam().overrides, {"release_time=0.037"});
  overrides.emplace_back("time.position_tolerance=1e-7");
  Simulation simulation = simulation_of(hanging_sheet, overrides);
  advance_to(simulation, release);
  // The centre is that of mass: a corner has a sixth or a third of the mass of an inner vertex, a
  // vertex on an edge has half.
  const auto centre = [&](const std::vector<Vec3>& all) {
    const std::vector<double>& mass = simulation.scene().mass;
    Vec3 sum = Vec3::Zero();
    double total = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      sum += mass[i] * all[i];
      total += mass[i];
    }
    return Vec3(sum / total);
  };
  const Vec3 start = centre(simulation.position("sheet"));
  const Vec3 velocity = centre(simulation.velocity("sheet"));
  advance_to(simulation, 0.1);
  const double since = 0.1 - release;
  const Vec3 expected = start + since * velocity - Vec3(0, 0, 0.5 * gravity * since * since);
  EXPECT_LT((centre(simulation.position("sheet")) - expected).norm(), GetParam().error + 1e-6);
}

TEST_P(TimedPins, APinTakesHoldOfVerticesWhereTheyAre) {
  Simulation simulation = simulation_of(
      carried_sheet, with_pin(GetParam().overrides,
                              {"motion.velocity=[0, 0, 0]", "release_time=1", "hold_time=0.037"}));
  advance_to(simulation, 0.2);
  for (const Vec3& place : simulation.position("sheet"))
    EXPECT_NEAR(place[2], -0.5 * gravity * release * release, GetParam().error);
  for (const Vec3& velocity : simulation.velocity("sheet")) EXPECT_EQ(velocity, Vec3(0, 0, 0));
}

// A pin whose motion has begun before it takes hold carries the vertices on from where they are.
TEST_P(TimedPins, APinCarriesVerticesFromWhereTheyAre) {
  Simulation simulation = simulation_of(
      carried_sheet, with_pin(GetParam().overrides, {"motion.angular_velocity_deg=[0, 0, 360]",
                                                     "release_time=1", "hold_time=0.037"}));
  const Vec3 corner = simulation.position("sheet")[0];
  advance_to(simulation, 0.2);
  const double since = 0.2 - release;
  const Vec3 turned = rotation_from_degrees({0, 0, 360 * since}) * corner +
                      Vec3(0, 0, 0.5 * since - 0.5 * gravity * release * release);
  EXPECT_LT((simulation.position("sheet")[0] - turned).norm(), GetParam().error + 1e-14);
}

TEST_P(TimedPins, BeforeItsTimeAPinIsLikeOneThatAlwaysHolds) {
  Simulation always = simulation_of(hanging_sheet, GetParam().overrides);
  Simulation timed =
      simulation_of(hanging_sheet, with_pin(GetParam().overrides, {"release_time=5"}));
  for (Simulation* each : {&always, &timed}) advance_to(*each, 0.08);
  EXPECT_EQ(timed.position("sheet"), always.position("sheet"));
  EXPECT_EQ(timed.counts().steps, always.counts().steps);
}

INSTANTIATE_TEST_SUITE_P(Methods, TimedPins, testing::ValuesIn(all_methods()),
                         [](const auto& each) { return std::string(each.param.name); });

TEST(TimedPins, KeepTheOrderOfFixedSteps) {
  const auto end_of = [](const std::string& name, double step) {
    Simulation simulation = simulation_of(
        hanging_sheet, method(name, {key("step", step), key("position_tolerance", 1e-9),
                                     "body.sheet.pin.0.release_time=0.0373"}));
    advance_to(simulation, 0.08);
    return simulation.position("sheet");
  };
  for (const auto& [name, order] : {std::pair("euler", 1), std::pair("implicit_midpoint", 2)}) {
    const std::vector<Vec3> exact = end_of("implicit_midpoint", 1.25e-5);
    const double coarse = distance_between(end_of(name, 4e-4), exact);
    const double fine = distance_between(end_of(name, 1e-4), exact);
    EXPECT_NEAR(std::log2(coarse / fine) / 2, order, 0.3) << name << ' ' << coarse << ' ' << fine;
  }
}

TEST(TimedPins, ContinueFromSavedStates) {
  for (const char* name : {"euler", "verlet"}) {
    const auto make = [&] {
      return simulation_of(hanging_sheet,
                           method(name, {"body.sheet.pin.0.release_time=0.05",
                                         "body.sheet.pin.0.motion.velocity=[0, 0.2, 0]"}));
    };
    for (const double saved_at : {0.02, 0.05, 0.07}) {
      Simulation straight = make(), begun = make(), continued = make();
      for (Simulation* each : {&straight, &begun}) advance_to(*each, saved_at);
      continued.restore(begun.save());
      for (Simulation* each : {&straight, &continued}) advance_to(*each, 0.1);
      EXPECT_EQ(continued.position("sheet"), straight.position("sheet")) << name << saved_at;
      EXPECT_EQ(continued.velocity("sheet"), straight.velocity("sheet")) << name << saved_at;
    }
  }
}

// The first pin that holds at a time has a vertex. Once it lets go, the next one takes the vertex
// over where it is.
TEST(TimedPins, HandVerticesOver) {
  const std::string text = std::string(carried_sheet) + "[[body.pin]]\nrows = [0, 0]\n";
  Simulation simulation = simulation_of(text);
  advance_to(simulation, 0.1);
  const std::vector<Vec3> position = simulation.position("sheet");
  for (int col = 0; col < 5; ++col) EXPECT_NEAR(position[col][2], 0.5 * release, 1e-14);
  EXPECT_GT(position[24][2], position[0][2] + 0.005);
}

// Strain that pins have held becomes motion, which the energy watch must allow.
TEST(TimedPins, ReleaseStrainEnergy) {
  for (const char* name : {"cvode", "arkode", "euler"}) {
    Simulation simulation = simulation_of(
        carried_sheet,
        method(name, {"body.sheet.stretch=[1.3, 1.3, 1]", "time.relative_tolerance=1e-3",
                      "body.sheet.pin.0.motion.velocity=[0, 0, 0]"}));
    advance_to(simulation, 0.2);
    EXPECT_GT(simulation.energies().kinetic, 1);
  }
}

TEST(TimedPins, DropASheetOnABall) {
  const std::string text = R"(
[time]
duration = 0.2
[material.cloth]
bending_stiffness = 1e-5
stiffness_damping = 1e-3
[[body]]
name = "sheet"
position = [0, 0, 0.11]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [13, 13] }
[[body.pin]]
rows = [0, -1]
release_time = 0.05
[[obstacle]]
name = "ball"
shape = { type = "sphere", radius = 0.1, resolution = [9] }
)";
  for (const char* name : {"cvode", "euler"}) {
    Simulation simulation = simulation_of(text, method(name));
    advance_to(simulation, 0.2);
    EXPECT_GT(simulation.contact_pairs(), 0U);
    std::vector<Vec3> all = simulation.position("sheet");
    EXPECT_LT(all[0][2], 0.06);
    const std::vector<Vec3> ball = simulation.position("ball");
    all.insert(all.end(), ball.begin(), ball.end());
    EXPECT_EQ(crossings(simulation.scene(), all), 0);
  }
}

// Both sheets rest from the start. One falls asleep, the other waits for its pin. Steps are short
// enough for bodies to fall asleep between them.
TEST(TimedPins, KeepABodyAwake) {
  const std::string other = R"([[body]]
name = "other"
position = [5, 0, 0]
shape = { type = "rectangle", size = [1, 1], resolution = [5, 5] }
[[body.pin]]
rows = [1, -1]
)";
  Simulation simulation = simulation_of(
      carried_sheet + other,
      {"time.duration=3", "body.sheet.pin.0.release_time=2.5", "world.gravity=[0, -1, 0]",
       "material.cloth.mass_damping=20", "time.position_tolerance=1e-5", "time.maximum_step=0.2",
       "body.sheet.pin.0.motion.velocity=[0, 0, 0]"});
  advance_to(simulation, 2.4);
  EXPECT_EQ(simulation.summary_of(simulation.time(), simulation.state()).sleeping_bodies, 1);
  const std::vector<Vec3> start = simulation.position("sheet");
  advance_to(simulation, 3);
  for (std::size_t i = 0; i < start.size(); ++i)
    EXPECT_LT(simulation.position("sheet")[i][1], start[i][1] - 0.01);
}

TEST(TimedPins, LetErrorsBeEstimated) {
  const Overrides pin = with_pin({}, {"release_time=0.037"});
  for (const char* name : {"cvode", "euler"}) {
    Simulation run = simulation_of(hanging_sheet, method(name, pin));
    Simulation exact = simulation_of(
        hanging_sheet,
        with_pin(method("cvode", {"time.position_tolerance=1e-9"}), {"release_time=0.037"}));
    ErrorMonitor monitor(run.scene(), nullptr);
    for (const double time : {0.02, 0.06, 0.1}) {
      for (Simulation* each : {&run, &exact}) advance_to(*each, time);
      monitor.compare(time, run.state());
    }
    EXPECT_EQ(monitor.estimate().failure, "");
    const double truth = distance_between(run.position("sheet"), exact.position("sheet"));
    EXPECT_NEAR(std::log2(monitor.estimate().bodies.at(0).last / truth), 0, 1) << name;
  }
}

TEST(TimedPins, AreNoticedAfterTheEnd) {
  const auto notice_of = [](const Overrides& keys) {
    return late_pins_notice(parse_case(hanging_sheet, "test.toml", with_pin({}, keys)));
  };
  EXPECT_EQ(notice_of({"release_time=0.09"}), "");
  EXPECT_EQ(notice_of({"release_time=0.2"}),
            "release_time, 0.2 s, of a pin of body \"sheet\" is not within the run of 0.1 s: the "
            "pin never lets go");
  EXPECT_EQ(notice_of({"hold_time=0.2"}),
            "hold_time, 0.2 s, of a pin of body \"sheet\" is not within the run of 0.1 s: the "
            "pin never holds");
}

}  // namespace weft::sim::timed_pins_test
