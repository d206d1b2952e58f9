// States between the ends of a step. They lie on the interpolating polynomial or, where that may
// cross, on the straight line that has been checked. Prescribed points are where the time puts
// them.
#include <gtest/gtest.h>

#include "sim/integrator/settled_frame.h"
#include "simulated_case.h"

namespace weft::sim::frames_test {
namespace {

// A body thrown at a plate that stops it at once; a polynomial through the velocities of both ends
// overshoots.
constexpr const char* sudden_stop = R"(
[time]
duration = 1
[world]
gravity = [0, 0, 0]
[material.cloth]
stiffness_damping = 1e-3
[[body]]
name = "sheet"
position = [0.02, 0.01, 0.01]
velocity = [0, 0, -8]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [5, 5] }
[[obstacle]]
name = "plate"
shape = { type = "rectangle", size = [1, 1], resolution = [4, 4] }
)";

using State = std::vector<double>;

State between(const State& from, const State& to, double part) {
  State y(from.size());
  for (std::size_t i = 0; i < y.size(); ++i) y[i] = (1 - part) * from[i] + part * to[i];
  return y;
}

// Returns the velocities in the place of positions.
State velocities(const State& y) {
  State moved(y.begin() + static_cast<std::ptrdiff_t>(y.size() / 2), y.end());
  moved.resize(y.size());
  return moved;
}

TEST(Frames, LieOnTheCheckedLineWhereThePolynomialMayCross) {
  SimulatedCase sim(sudden_stop, method("euler", {"time.step=0.0166667"}));
  int on_line = 0, on_polynomial = 0;
  State from = sim.dynamics().initial_state(), y(from.size());
  for (double start = 0; start < 0.05;) {
    ASSERT_EQ(sim.integrator().step(), std::nullopt);
    const double end = sim.integrator().time();
    const State to(sim.integrator().state().begin(), sim.integrator().state().end());
    // A polynomial through a free flight is a line, too.
    const bool is_free_flight = position_difference(velocities(from), velocities(to)) < 0.1;
    for (int k = 1; k < 20; ++k) {
      const double time = start + (end - start) * k / 20;
      ASSERT_EQ(sim.integrator().state_at(time, y), std::nullopt);
      ASSERT_EQ(crossings(sim.scene(), sim.positions(time, y)), 0) << time;
      const bool is_line = y == between(from, to, (time - start) / (end - start));
      if (!is_free_flight) ++(is_line ? on_line : on_polynomial);
    }
    from = to;
    start = end;
  }
  EXPECT_GT(on_line, 0);
  EXPECT_GT(on_polynomial, 0);
}

// Under error control almost no polynomial crosses; all are checked.
TEST(Frames, AreCheckedByEveryMethod) {
  for (const Overrides& by : {method("cvode"), method("arkode"), method("euler")}) {
    SCOPED_TRACE(by.front());
    SimulatedCase sim(sudden_stop, by);
    while (sim.integrator().time() < 0.002) ASSERT_EQ(sim.integrator().step(), std::nullopt);
    State y(sim.dynamics().state_size());
    const auto looks = [&] { return sim.statistics().counters.body_pairs; };
    const auto before = looks();
    const double time = sim.integrator().time() - 0.5 * sim.integrator().last_step();
    ASSERT_EQ(sim.integrator().state_at(time, y), std::nullopt);
    EXPECT_GT(looks(), before);
  }
}

// A sheet rises from 0.5 to 1.5 m within a second. A plate rises from 0 to 1 m within a quarter of
// a second and then waits. At 0.3 s the plate is above the sheet, although their chords keep apart.
// At 0.9 s the sheet is above again.
constexpr const char* plate_ahead = R"(
[time]
duration = 1
[world]
gravity = [0, 0, 0]
[material.cloth]
[[body]]
name = "sheet"
position = [0, 0, 0.5]
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3] }
[[obstacle]]
name = "plate"
shape = { type = "rectangle", size = [2, 2], resolution = [3, 3] }
motion = { velocity = [0, 0, 4], stop_time = 0.25 }
)";

State raised(State y, double height) {
  for (std::size_t i = 0; i < 9; ++i) y[3 * i + 2] += height;
  return y;
}

TEST(Frames, ArePassedWithPrescribedPointsWhereTheyAre) {
  SimulatedCase sim(plate_ahead);
  const State start = sim.dynamics().initial_state(), end = raised(start, 1);
  const std::vector<Vec3> start_positions = sim.positions(0, start);
  const auto settle = [&](double time, State& y) {
    std::vector<Vec3> position, velocity;
    return settle_frame(sim.dynamics(), time, time, {start, end, start_positions}, y, position,
                        velocity);
  };
  State below = raised(start, 0.4), above = raised(start, 0.8), free = above;
  const auto refusal = settle(0.3, below);
  ASSERT_TRUE(refusal);
  EXPECT_TRUE(refusal->text.starts_with("no frame at t = 0.3 s keeps the surfaces apart"))
      << refusal->text;
  below = raised(start, 0.4);
  EXPECT_EQ(settle(0.9, below), std::nullopt);
  EXPECT_EQ(below, between(start, end, 0.9));
  EXPECT_EQ(settle(0.9, above), std::nullopt);
  EXPECT_EQ(above, free);
}

// A step whose chords keep apart is refused if the true paths do not.
TEST(Frames, PathsOfStepsAreThoseOfPrescribedPoints) {
  SimulatedCase sim(plate_ahead);
  const State start = sim.dynamics().initial_state(), end = raised(start, 1);
  const std::vector<Vec3> from = sim.positions(0, start), to = sim.positions(1, end);
  EXPECT_FALSE(sim.dynamics().contact()->check_path(from, to));
  EXPECT_TRUE(sim.dynamics().check_path(0, from, 1, to));
  EXPECT_FALSE(sim.dynamics().check_path(0.3, to, 1, to));
}

}  // namespace
}  // namespace weft::sim::frames_test
