// Prescribed motion: no step skips it, surfaces stay apart on the true paths, and pins follow it
// within the tolerance.
#include <gtest/gtest.h>

#include <algorithm>

#include "sim/motion/motion_limits.h"
#include "simulated_case.h"

namespace weft::sim::moving_test {
namespace {

const Overrides cvode = method("cvode"), arkode = method("arkode"), euler = method("euler");

// A damped curtain at rest, through which a ball swings late.
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

// Both edges of a damped sheet rotate once about the line through their middles.
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

// A paddle that rotates twice per second and cuts the plane of a resting free sheet twice per
// rotation.
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
  int crossings = 0;    // in all checked states
  double largest_move = 0, largest_stretch = -1;
};

// Checks `samples` states in each sixtieth of a second from `from` on.
Outcome watch(SimulatedCase& sim, double from, double until, int samples = 20) {
  Outcome outcome;
  std::vector<double> y(sim.dynamics().state_size());
  const double interval = 1.0 / (60 * samples);
  for (long next = 0;;) {
    if (auto failure = sim.integrator().step()) {
      outcome.failure = failure->text;
      return outcome;
    }
    for (;; ++next) {
      const double time = from + static_cast<double>(next) * interval;
      if (time > until) return outcome;
      if (time > sim.integrator().time()) break;
      if (auto failure = sim.integrator().state_at(time, y)) {
        outcome.failure = failure->text;
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

// A sheet between two plates that close until less room is left than their thicknesses need.
constexpr const char* closing_plates = R"(
[time]
duration = 0.2
[material.cloth]
stiffness_damping = 2e-3
mass_damping = 1
[[body]]
name = "sheet"
position = [0, 0, 0.005]
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [5, 5] }
[[obstacle]]
name = "lower_plate"
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [3, 3] }
[[obstacle]]
name = "upper_plate"
position = [0, 0, 0.01]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [3, 3] }
motion = { keyframes = [{ time = 0.05 }, { time = 0.15, translation = [0, 0, -0.009] }] }
)";

// The run ends shortly before no room is left, and says what is pressed together.
TEST(PrescribedMotion, PlatesThatCloseTooFarEndWithAClearReason) {
  for (const Overrides& by : {cvode, arkode, euler, method("euler", {"time.step=0.002"})}) {
    SCOPED_TRACE(by.front() + ' ' + by.back());
    SimulatedCase sim(closing_plates, by);
    std::optional<Failure> failure;
    while (!failure && sim.integrator().time() < 0.2) failure = sim.integrator().step();
    ASSERT_TRUE(failure);
    EXPECT_EQ(failure->kind, Failure::Kind::surfaces) << failure->text;
    EXPECT_NE(failure->text.find("body \"sheet\""), std::string::npos) << failure->text;
    EXPECT_NE(failure->text.find("_plate\""), std::string::npos) << failure->text;
    const std::vector<double> y(sim.integrator().state().begin(), sim.integrator().state().end());
    const std::vector<Vec3> position = sim.positions(sim.integrator().time(), y);
    // The thicknesses of all need 2 mm between the plates.
    EXPECT_GT(position.back().z(), 2e-3);
    EXPECT_LT(position.back().z(), 2.05e-3);
    EXPECT_EQ(crossings(sim.scene(), position), 0);
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
  // In the last run, a nonlinear solver that tries states metres away would meet surfaces that
  // cross.
  for (const Overrides& by :
       {cvode, arkode, euler, method("euler", {"obstacle.ball.position=[0.0209, 0.6, -0.2]"})}) {
    SCOPED_TRACE(by.back());
    SimulatedCase sim(curtain, by);
    const Outcome outcome = watch(sim, 19.9, 20.6);
    EXPECT_EQ(outcome.failure, "");
    EXPECT_EQ(outcome.crossings, 0);
    EXPECT_GT(outcome.largest_move, 0.2);
  }
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

// The corner of a plate descends on a free sheet.
constexpr const char* creeping_plate = R"(
[time]
method = "euler"
duration = 0.12
step = 1e-3
[world]
gravity = [0, 0, 0]
[contact]
range = 4e-3
stiffness = 1e6
friction = 0.3
[material.cloth]
density = 0.2
stiffness_damping = 1e-3
[[body]]
name = "sheet"
thickness = 1e-3
shape = { type = "rectangle", size = [0.45, 0.45], resolution = [9, 9] }
[[obstacle]]
name = "plate"
position = [-0.02, -0.0135, 0.1265]
rotation_deg = [93, 0.4, 0]
shape = { type = "rectangle", size = [0.24, 0.24], resolution = [7, 7] }
motion = { velocity = [0, 0, -0.25] }
)";

TEST(PrescribedMotion, StepsOfOneIterationArePushedAhead) {
  for (const char* newton : {"time.newton=1", "time.newton=2"}) {
    SCOPED_TRACE(newton);
    SimulatedCase sim(creeping_plate, {newton});
    const Outcome outcome = watch(sim, 0, 0.12);
    EXPECT_EQ(outcome.failure, "");
    EXPECT_EQ(outcome.crossings, 0);
    EXPECT_GT(outcome.largest_move, 0.02);
    const IntegratorCounts counts = sim.integrator().counts();
    EXPECT_LE(counts.newton_iterations, 6 * counts.steps);
  }
}

// Times at which steps end.
std::vector<double> step_ends(SimulatedCase& sim, double until) {
  std::vector<double> ends;
  while (sim.integrator().time() < until) {
    const auto failure = sim.integrator().step();
    if (failure) ADD_FAILURE() << failure->text;
    if (failure) break;
    ends.push_back(sim.integrator().time());
  }
  return ends;
}

TEST(PrescribedMotion, StepsOfOneIterationTakeOneUntilSomethingMoves) {
  SimulatedCase sim(creeping_plate, {"time.newton=1", "world.gravity=[0, 0, -9.81]",
                                     "obstacle.plate.motion.start_time=0.1"});
  EXPECT_EQ(step_ends(sim, 0.1).back(), 0.1);
  const IntegratorCounts counts = sim.integrator().counts();
  EXPECT_EQ(counts.newton_iterations, counts.steps);
}

bool contains(const std::vector<double>& times, double time) {
  return std::find(times.begin(), times.end(), time) != times.end();
}

TEST(PrescribedMotion, NoStepPassesAKeyframe) {
  const Overrides fixed = method("euler", {"time.step=0.03"});
  for (const Overrides& by : {cvode, arkode, euler, fixed}) {
    SCOPED_TRACE(by.back());
    SimulatedCase sim(turning_pins, {by.front(), by.back(), "time.duration=0.7",
                                     "body.0.pin.0.motion.keyframes.0.time=0.05",
                                     "body.0.pin.0.motion.keyframes.1.time=0.52"});
    const std::vector<double> ends = step_ends(sim, 0.7);
    EXPECT_TRUE(contains(ends, 0.05));
    EXPECT_TRUE(contains(ends, 0.52));
    if (by != fixed) continue;
    for (int i = 1; i <= 20; ++i) EXPECT_TRUE(contains(ends, i * 0.03)) << i;
  }
}

TEST(PrescribedMotion, NoStepTurnsAPinFarther) {
  SimulatedCase sim(turning_pins, method("euler", {"time.step=0.1"}));
  const std::vector<double> ends = step_ends(sim, 20.5);
  for (std::size_t i = 1; i < ends.size(); ++i) {
    EXPECT_LE(sim.scene().prescribed[0].motion.bounds(ends[i - 1], ends[i], 1).angle,
              MotionLimits::largest_turn);
  }
  // Steps are short only where the motion turns.
  EXPECT_LT(ends.size(), 300U);
}

// An edge that is moved back and forth, with contact.
TEST(PrescribedMotion, NoStepLetsAPinStrayFarther) {
  SimulatedCase sim(turning_pins,
                    method("euler", {"time.step=0.1", "time.duration=0.6", "contact.enabled=true",
                                     "body.0.pin.0.motion.keyframes=[{ time = 0.05 }, { time = "
                                     "0.55, translation = [0, 0, 0.3] }]"}));
  const std::vector<double> ends = step_ends(sim, 0.6);
  const double most = MotionLimits::stray_part * sim.scene().source.contact.range;
  double largest = 0;
  for (std::size_t i = 1; i < ends.size(); ++i) {
    largest =
        std::max(largest, sim.scene().prescribed[0].motion.bounds(ends[i - 1], ends[i], 1).stray);
  }
  EXPECT_LE(largest, most);
  EXPECT_GT(largest, 0.5 * most);
  EXPECT_LT(ends.size(), 100U);
}

// SUNDIALS chooses its steps by itself. After a step that a motion has cut, it does not tell how
// long the next one will be.
TEST(PrescribedMotion, AllStepsAreShortEnough) {
  const Overrides turning = {"contact.enabled=true", "time.duration=0.7",
                             "body.0.pin.0.motion.keyframes.0.time=0.05",
                             "body.0.pin.0.motion.keyframes.1.time=0.52"};
  for (const auto& [text, changes] : {std::pair(paddle, Overrides{}), {turning_pins, turning}}) {
    for (const Overrides& by : {cvode, arkode, euler, method("euler", {"time.step=0.03"})}) {
      Overrides all = changes;
      all.insert(all.end(), by.begin(), by.end());
      SimulatedCase sim(text, all);
      MotionLimits limits(sim.scene(), sim.dynamics());
      int cut = 0;  // steps that could not have been longer
      while (sim.integrator().time() < 0.25) {
        const double start = sim.integrator().time();
        const std::vector<double> y(sim.integrator().state().begin(),
                                    sim.integrator().state().end());
        const auto failure = sim.integrator().step();
        ASSERT_FALSE(failure) << failure->text;
        const double end = sim.integrator().time();
        ASSERT_EQ(limits.latest_end(start, end, y), end) << by.back() << " from " << start;
        if (limits.latest_end(start, start + 2 * (end - start), y) < start + 2 * (end - start))
          ++cut;
      }
      EXPECT_GT(cut, 1) << by.back();
    }
  }
}

TEST(PrescribedMotion, PinsAreFollowedToTheTolerance) {
  const Overrides soon = {"body.0.pin.0.motion.keyframes.0.time=0.01",
                          "body.0.pin.0.motion.keyframes.1.time=0.51", "world.gravity=[0, 0, 0]"};
  Overrides tight = soon;
  tight.insert(tight.end(), {"time.position_tolerance=1e-8", "time.relative_tolerance=1e-7"});
  SimulatedCase reference(turning_pins, tight);
  const std::vector<double> converged = reference.advance_to(0.3);
  for (const Overrides& by : {cvode, arkode, euler}) {
    Overrides all = soon;
    all.insert(all.end(), by.begin(), by.end());
    SimulatedCase sim(turning_pins, all);
    EXPECT_LT(position_difference(sim.advance_to(0.3), converged), 2e-2) << by.front();
  }
}

// The slopes of a step of seconds at rest would make the error of the first moving step seem small.
TEST(PrescribedMotion, EulerForgetsARestBeforeAKeyframe) {
  SimulatedCase sim(turning_pins, method("euler", {"world.gravity=[0, 0, 0]"}));
  const std::vector<double> ends = step_ends(sim, 20.01);
  const auto start = std::find(ends.begin(), ends.end(), 20.0);
  ASSERT_TRUE(start != ends.end() && start != ends.begin());
  EXPECT_GT(*start - *(start - 1), 1);
  EXPECT_LT(*(start + 1) - *start, 5e-3);
}

// The edge of a damped sheet jumps to a velocity along itself at 0.05 s and stops at 0.1 s.
constexpr const char* jumping_pins = R"(
[time]
duration = 0.2
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.cloth]
stiffness_damping = 1e-3
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [9, 9] }
[[body.pin]]
edges = ["first_row"]
motion = { velocity = [0, -0.5, 0], start_time = 0.05, stop_time = 0.1 }
)";

// The step that ends at a jump uses the velocity before it.
TEST(PrescribedMotion, NothingMovesBeforeItsStart) {
  for (const Overrides& by : {cvode, arkode, euler, method("euler", {"time.step=0.01"}),
                              method("implicit_midpoint", {"time.step=0.01"})}) {
    SCOPED_TRACE(by.front());
    SimulatedCase sim(jumping_pins, by);
    EXPECT_EQ(position_difference(sim.advance_to(0.05), sim.dynamics().initial_state()), 0);
    EXPECT_GT(position_difference(sim.advance_to(0.06), sim.dynamics().initial_state()), 1e-4);
  }
}

// Slopes from before a jump are a bad start for Newton's iteration: three or four steps would fail
// with them.
TEST(PrescribedMotion, MethodsBeginAnewAfterAJump) {
  for (const Overrides& by : {cvode, arkode}) {
    SCOPED_TRACE(by.front());
    SimulatedCase sim(jumping_pins, by);
    sim.advance_to(0.12);
    EXPECT_LE(sim.integrator().counts().convergence_failures, 1);
  }
}

// Steps after a jump that are shorter than minimum_step end near it again.
TEST(PrescribedMotion, CvodeBeginsAnewOnceAtAJump) {
  SimulatedCase sim(jumping_pins, {"time.minimum_step=4e-3"});
  int short_steps = 0;
  while (sim.integrator().time() < 0.0535) {
    if (const auto failure = sim.integrator().step()) FAIL() << failure->text;
    if (sim.integrator().time() > 0.05) ++short_steps;
  }
  EXPECT_GT(short_steps, 5);
  EXPECT_EQ(sim.integrator().last_order(), 2);
}

// Pins in the state may err within the tolerance while they move; where they stop, the errors are
// removed.
TEST(PrescribedMotion, PinsStopExactlyWhereTheyShould) {
  for (const Overrides& by : {cvode, arkode, euler}) {
    SCOPED_TRACE(by.front());
    SimulatedCase sim(jumping_pins, {by.front(), "body.0.pin.0.motion.velocity=[0, 0, 0]",
                                     "body.0.pin.0.motion.centre=[0, 0, 0]",
                                     "body.0.pin.0.motion.angular_velocity_deg=[300, 0, 0]"});
    const std::vector<double> y = sim.advance_to(0.12);
    const std::vector<Vec3> position = sim.positions(0.12, y);
    for (const int pin : sim.scene().prescribed[0].particles) {
      EXPECT_GT((position[pin] - sim.scene().initial_position[pin]).norm(), 0.1);
      EXPECT_LT((StateView::of(y).position[pin] - position[pin]).norm(), 1e-12);
    }
  }
}

// Distance from a run with a hundredth of the tolerances. A struck sheet is chaotic. Distances grow
// tenfold from 0.55 to 0.65 s for the ball, fiftyfold from 0.2 to 0.3 s for the paddle, and a
// hundredfold from 20.27 to 20.37 s for the curtain, struck at 20.23 s. Up to then they are
// compared with the tolerance of a step. Errors of backward Euler, of first order, add up over more
// than a thousand steps.
TEST(PrescribedMotion, WhatIsStruckIsFollowedToTheToleranceWhileItCanBe) {
  struct Scene {
    const char* text;
    double time;         // s
    double first_order;  // distance by Euler, in tolerances of a step
  };
  constexpr double tolerance = 1e-5, other_methods = 100;
  for (const Scene& scene :
       {Scene{there_and_back, 0.55, 2000}, Scene{curtain, 20.27, 500}, Scene{paddle, 0.2, 500}}) {
    SimulatedCase reference(
        scene.text, {key("position_tolerance", tolerance / 100), "time.relative_tolerance=1e-6"});
    const std::vector<double> converged = reference.advance_to(scene.time);
    EXPECT_GT(position_difference(reference.dynamics().initial_state(), converged), 0.02);
    for (const Overrides& by : {cvode, arkode, euler}) {
      SCOPED_TRACE(by.front());
      SimulatedCase sim(scene.text, by);
      ASSERT_EQ(sim.scene().source.time.position_tolerance, tolerance);
      EXPECT_LT(position_difference(sim.advance_to(scene.time), converged),
                tolerance * (by == euler ? scene.first_order : other_methods));
    }
  }
}

// Error control sees the pins in the state: they end in their places although nothing sets them
// there.
TEST(PrescribedMotion, TheStateCarriesPins) {
  SimulatedCase sim(turning_pins, {"body.0.pin.0.motion.keyframes.0.time=0.01",
                                   "body.0.pin.0.motion.keyframes.1.time=0.51"});
  const std::vector<double> y = sim.advance_to(0.3);
  const std::vector<Vec3> position = sim.positions(0.3, y);
  for (const int pin : sim.scene().prescribed[0].particles)
    EXPECT_LT((StateView::of(y).position[pin] - position[pin]).norm(), 5e-3);
}

TEST(PrescribedMotion, OneThatBeginsLaterChangesNoBit) {
  constexpr const char* text = R"(
[time]
duration = 0.3
[material.cloth]
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [9, 9] }
[[body.pin]]
corners = ["last_first", "last_last"]
[[obstacle]]
name = "ball"
position = [0, 0, -0.2]
shape = { type = "sphere", radius = 0.1, resolution = [5] }
)";
  for (const Overrides& by :
       {cvode, arkode, euler, method("euler", {"time.step=2e-3", "time.newton=1"})}) {
    SimulatedCase still(text, by);
    SimulatedCase later(std::string(text) + "motion = { velocity = [1, 0, 0], start_time = 100 }\n",
                        by);
    EXPECT_EQ(still.advance_to(0.3), later.advance_to(0.3)) << by.front();
  }
}

// A disc of 0.1 m rotates 20 times per second, out of reach.
TEST(PrescribedMotion, WhatIsFarShortensNothing) {
  constexpr const char* text = R"(
[time]
duration = 0.3
[material.cloth]
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [9, 9] }
[[body.pin]]
corners = ["last_first", "last_last"]
[[obstacle]]
name = "disc"
position = [0, 0, 3]
shape = { type = "sphere", radius = 0.1, resolution = [5] }
)";
  SimulatedCase still(text);
  SimulatedCase turning(std::string(text) + "motion = { angular_velocity_deg = [0, 7200, 0] }\n");
  EXPECT_EQ(still.advance_to(0.3), turning.advance_to(0.3));
}

TEST(PrescribedMotion, PathsKeepApartByWhatTheyMayStray) {
  constexpr const char* text = R"(
[contact]
search_slack = 1e-3
[material.cloth]
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3] }
[[obstacle]]
name = "plate"
position = [0, 0, 0.02]
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3] }
motion = { velocity = [0, 0, 1] }
)";
  SimulatedCase sim(text);
  Contact& contact = *sim.dynamics().contact();
  const std::vector<Vec3>& start = sim.scene().initial_position;
  std::vector<Vec3> end = start;
  for (Vec3& x : end) x.x() += 0.01;
  for (const auto& [stray, is_free] : {std::pair(0.015, true), std::pair(0.025, false),
                                       std::pair(0.015, true), std::pair(0.0, true)}) {
    const std::vector<double> body{0, stray};
    std::vector<double> particle(start.size(), 0.0);
    std::fill(particle.begin() + 9, particle.end(), stray);
    EXPECT_EQ(!contact.check_path(start, end, {body, particle}), is_free) << stray;
  }
}

}  // namespace
}  // namespace weft::sim::moving_test
