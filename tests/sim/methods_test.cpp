// The time integration methods against converged references, closed forms and each other.
#include <cmath>

#include "simulated_case.h"

namespace weft::sim::methods_test {
namespace {

// A stretched, damped sheet that swings under gravity; its motion is smooth, so that orders show.
const std::string stretched_sheet = R"(
[time]
duration = 1
position_tolerance = 1e-9
relative_tolerance = 1e-8
[contact]
enabled = false
[material.cloth]
density = 0.2
membrane_stiffness = 5
stiffness_damping = 2e-2
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [5, 5] }
[[body.pin]]
edges = ["first_row", "last_row"]
)";

std::vector<double> reference() {
  SimulatedCase sim(stretched_sheet,
                    {"time.position_tolerance=1e-10", "time.relative_tolerance=1e-9"});
  return sim.advance_to(0.25);
}

// Returns the ratio of the errors with a step and with half of it.
double ratio_of_errors(const std::string& name, double step, const Overrides& more = {}) {
  const std::vector<double> exact = reference();
  std::vector<double> error;
  for (double h : {step, step / 2}) {
    Overrides options = method(name, more);
    options.push_back(key("step", h));
    SimulatedCase sim(stretched_sheet, options);
    error.push_back(position_difference(sim.advance_to(0.25), exact));
  }
  EXPECT_LT(error[1], 5e-3);
  return error[0] / error[1];
}

TEST(Methods, FixedStepsConvergeWithTheirOrder) {
  EXPECT_NEAR(ratio_of_errors("euler", 1.0 / 512), 2, 0.2);
  EXPECT_NEAR(ratio_of_errors("euler", 1.0 / 512, {"time.newton=1"}), 2, 0.2);
  EXPECT_NEAR(ratio_of_errors("implicit_midpoint", 1.0 / 128), 4, 0.4);
  EXPECT_NEAR(ratio_of_errors("verlet", 1.0 / 128), 4, 0.4);
}

// Returns the errors of a method after a quarter of a second, for each step.
std::vector<double> errors_of_steps(const std::string& name, const Overrides& more,
                                    std::initializer_list<double> steps) {
  const auto state = [](Overrides options) {
    for (const char* each : {"time.duration=0.25", "body.sheet.shape.resolution=[17, 17]",
                             "material.cloth.membrane_stiffness=1000"})
      options.emplace_back(each);
    return SimulatedCase(hanging_sheet, options).advance_to(0.25);
  };
  const std::vector<double> exact = state(method("verlet", {"time.relative_tolerance=1e-5"}));
  std::vector<double> errors;
  for (double h : steps) {
    Overrides options = method(name, more);
    options.push_back(key("step", h));
    errors.push_back(position_difference(state(options), exact));
  }
  return errors;
}

// The residual of a linear solve must shrink with the step. Otherwise many short steps accumulate
// it, and halving the step makes the error larger.
TEST(Methods, LinearStepsKeepTheirOrderHoweverShort) {
  const std::vector<double> errors =
      errors_of_steps("euler", {"time.newton=1"}, {1.0 / 480, 1.0 / 960, 1.0 / 1920, 1.0 / 3840});
  for (std::size_t i = 1; i < errors.size(); ++i) EXPECT_GT(errors[i - 1] / errors[i], 1.7) << i;
}

// One iteration from the start of a short step may be accepted; its error must not be of first
// order.
TEST(Methods, ConvergedStepsKeepTheirOrderHoweverShort) {
  const std::vector<double> errors =
      errors_of_steps("implicit_midpoint", {}, {1.0 / 960, 1.0 / 1920, 1.0 / 3840});
  for (std::size_t i = 1; i < errors.size(); ++i) EXPECT_GT(errors[i - 1] / errors[i], 2.5) << i;
}

// The frame is between two steps, where the interpolated state must have the order of the method.
TEST(Methods, FramesBetweenStepsAreAsGood) {
  SimulatedCase exact(stretched_sheet,
                      {"time.position_tolerance=1e-10", "time.relative_tolerance=1e-9"});
  SimulatedCase sim(stretched_sheet, method("implicit_midpoint", {"time.step=0.01"}));
  const double at_step = position_difference(sim.advance_to(0.25), exact.advance_to(0.25));
  const double between = position_difference(sim.advance_to(0.255), exact.advance_to(0.255));
  EXPECT_LT(between, 1.5 * at_step);
}

TEST(Methods, AdaptiveStepsConvergeWithTheTolerance) {
  const std::vector<double> exact = reference();
  for (const char* name : {"arkode", "euler"}) {
    std::vector<double> error;
    for (const char* tolerance : {"1e-4", "1e-5", "1e-6"}) {
      SimulatedCase sim(stretched_sheet,
                        method(name, {std::string("time.position_tolerance=") + tolerance}));
      error.push_back(position_difference(sim.advance_to(0.25), exact));
    }
    // The error of a method of order 1 grows with the root of the tolerance. The test requires two
    // thirds of that exponent.
    EXPECT_LT(error[2], error[0] / 4.6) << name << ' ' << error[0] << ' ' << error[2];
    EXPECT_LT(error[2], 2e-3) << name;
  }
}

// Nothing holds the sheet.
TEST(Methods, FreeFallIsExactToTheOrder) {
  const std::string text = R"(
[time]
duration = 1
[contact]
enabled = false
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [3, 3] }
)";
  constexpr double h = 0.01, g = 9.81, t = 0.5;
  for (const char* name : {"implicit_midpoint", "verlet"}) {
    SimulatedCase sim(text,
                      method(name, {key("step", h), "material.default.membrane_stiffness=1"}));
    EXPECT_NEAR(sim.positions_at(t)[0].z(), -0.5 * g * t * t, 1e-10) << name;
  }
  // Backward Euler: the sum of v_k h with v_k = -g k h.
  SimulatedCase euler(text, method("euler", {key("step", h), "time.newton=1"}));
  EXPECT_NEAR(euler.positions_at(t)[0].z(), -0.5 * g * t * (t + h), 1e-9);
  SimulatedCase arkode(text, method("arkode"));
  EXPECT_NEAR(arkode.positions_at(t)[0].z(), -0.5 * g * t * t, 1e-4);
}

// A step that changes less than its tolerance must still take effect, since many such steps add up.
TEST(Methods, TheShortestStepsAreTaken) {
  constexpr double h = 1e-7, t = 2e-5, g = 9.81;
  for (const char* name : {"euler", "implicit_midpoint"}) {
    SimulatedCase sim(hanging_sheet, method(name, {key("step", h), "time.minimum_step=1e-9"}));
    const std::vector<double> y = sim.advance_to(t);
    EXPECT_NEAR(y[y.size() / 2 + 2], -g * t, 0.02 * g * t) << name;  // the free corner
    EXPECT_NEAR(y[2], -0.5 * g * t * t, 0.02 * g * t * t) << name;
  }
}

// A spring between a pinned and a free row, moved along itself: x'' = -omega^2 x. Backward Euler
// shrinks the amplitude by (1 + h^2 omega^2)^(-1/2) per step; midpoint and Verlet keep it.
TEST(Methods, EnergyOfAnOscillatorIsLostByEulerAloneAndAsMuchAsItsFormulaSays) {
  constexpr double h = 0.004, time = 2;
  const auto energy_left = [&](const Overrides& options) {
    SimulatedCase sim(oscillator, options);
    const double start = sim.energy(0, sim.advance_to(0));
    return sim.energy(time, sim.advance_to(time)) / start;
  };
  // Mass of a corner of two triangles: 1/3 kg, of one: 1/6 kg.
  double expected = 0;
  for (double mass : {1.0 / 3, 1.0 / 6}) {
    const double omega_squared = 100 / mass;
    expected += mass * std::pow(1 + h * h * omega_squared, -time / h);
  }
  expected /= 0.5;
  EXPECT_NEAR(energy_left(method("euler", {key("step", h)})) / expected, 1, 1e-3);
  EXPECT_NEAR(energy_left(method("implicit_midpoint", {key("step", h)})), 1, 1e-6);
  EXPECT_NEAR(energy_left(method("verlet", {key("step", h)})), 1, 0.01);
}

TEST(Methods, ArkodeTakesExplicitStepsWhereNothingIsStiffAndImplicitOnesElsewhere) {
  SimulatedCase soft(hanging_sheet, method("arkode", {"material.cloth.membrane_stiffness=100"}));
  soft.advance_to(0.3);
  EXPECT_EQ(soft.integrator().decision().find("explicit"), 0U) << soft.integrator().decision();
  SimulatedCase stiff(hanging_sheet, method("arkode", {"material.cloth.membrane_stiffness=1e8",
                                                       "material.cloth.stiffness_damping=1e-3"}));
  stiff.advance_to(0.3);
  EXPECT_EQ(stiff.integrator().decision().find("implicit"), 0U) << stiff.integrator().decision();
}

// Cloth that hits a ball at 20 m/s, with steps in which it would fly right through.
const std::string fast_impact = R"(
[time]
duration = 0.04
[contact]
stiffness = 2e7  # takes up 0.2 kg/m^2 at 20 m/s
[material.cloth]
density = 0.2
membrane_stiffness = 500
bending_stiffness = 1e-4
stiffness_damping = 1e-3
[[body]]
name = "sheet"
position = [0, 0, 0.6]
velocity = [0, 0, -20]
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [11, 11] }
[[obstacle]]
name = "ball"
shape = { type = "sphere", radius = 0.3, resolution = [7] }
)";

TEST(Methods, NothingPassesThroughHoweverLongTheStep) {
  for (const Overrides& options :
       {method("euler", {"time.step=0.0166667"}), method("euler", {"time.step=0.002"}),
        method("implicit_midpoint", {"time.step=0.002"}), method("arkode")}) {
    SimulatedCase sim(fast_impact, options);
    std::optional<double> smallest_gap;
    for (double time = 0.002; time <= 0.04; time += 0.002) {
      ASSERT_EQ(crossings(sim.scene(), sim.positions_at(time)), 0) << options[0] << " at " << time;
      const auto gap = sim.dynamics().contact()->smallest_gap();
      if (gap)
        smallest_gap = std::min(gap, smallest_gap.value_or(*gap) < *gap ? smallest_gap : gap);
    }
    ASSERT_TRUE(smallest_gap) << options[0];  // they have met
    // The ball holds the middle up: the sheet has not flown through at full speed.
    EXPECT_GT(sim.positions_at(0.04)[60].z(), 0.28) << options[0];
  }
}

// A single Newton iteration does not always find forces that stop the sheet. The run then ends with
// a reason, in about every fifth of such impacts, but the surfaces stay apart.
TEST(Methods, NothingPassesThroughWithASingleNewtonIteration) {
  int finished = 0;
  for (const char* height : {"0.6", "0.601", "0.602", "0.6065"}) {
    SimulatedCase sim(fast_impact,
                      method("euler", {"time.step=0.0166667", "time.newton=1",
                                       "body.sheet.position=[0, 0, " + std::string(height) + "]"}));
    std::optional<Failure> reason;
    while (!reason && sim.integrator().time() < 0.04) {
      reason = sim.integrator().step();
      const std::vector<double> state(sim.integrator().state().begin(),
                                      sim.integrator().state().end());
      ASSERT_EQ(crossings(sim.scene(), sim.positions(sim.integrator().time(), state)), 0)
          << height << " at " << sim.integrator().time();
    }
    if (reason) {
      EXPECT_NE(reason->text.find("surfaces apart"), std::string::npos) << reason->text;
      continue;
    }
    ++finished;
    EXPECT_GT(sim.positions_at(0.04)[60].z(), 0.28) << height;
  }
  EXPECT_GE(finished, 1);
}

// The failure names the obstacle and the place, and the last good state is kept.
TEST(Methods, AFailureNamesTheCauseAndKeepsTheState) {
  SimulatedCase sim(fast_impact, method("euler", {"time.step=0.01", "time.minimum_step=0.005"}));
  std::optional<Failure> reason;
  while (!(reason = sim.integrator().step()) && sim.integrator().time() < 0.04) continue;
  ASSERT_TRUE(reason);
  EXPECT_NE(reason->text.find("\"sheet\""), std::string::npos) << reason->text;
  EXPECT_NE(reason->text.find("time.minimum_step"), std::string::npos) << reason->text;
  const std::vector<double> kept(sim.integrator().state().begin(), sim.integrator().state().end());
  EXPECT_EQ(crossings(sim.scene(), sim.positions(sim.integrator().time(), kept)), 0);
}

// A contact far too soft for its impact: every step would pass through, however short.
TEST(Methods, ARunThatCreepsOnEndsWithAReason) {
  for (const std::string newton : {"0", "1"}) {
    SimulatedCase sim(fast_impact,
                      method("euler", {"time.step=0.0166667", "time.newton=" + newton,
                                       "contact.stiffness=1e-4", "time.minimum_step=1e-15"}));
    std::optional<Failure> reason;
    while (!(reason = sim.integrator().step()) && sim.integrator().time() < 0.04) continue;
    ASSERT_TRUE(reason);
    const bool is_clear = reason->text.find("steps had to be cut") != std::string::npos ||
                          reason->text.find("are pressed together") != std::string::npos;
    EXPECT_TRUE(is_clear) << reason->text;
    EXPECT_NE(reason->text.find("\"ball\""), std::string::npos) << reason->text;
    EXPECT_LT(sim.integrator().counts().steps, 2000);
  }
}

// A sheet that starts deep in a barrier is thrown off too fast for the shortest step.
TEST(Methods, SameBitsForAnyNumberOfThreads) {
  const std::string text = R"(
[time]
duration = 1
[contact]
enabled = false
[material.cloth]
density = 0.2
membrane_stiffness = 50
bending_stiffness = 1e-5
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [53, 53] }
[[body.pin]]
corners = ["first_first", "first_last"]
)";
  for (const Overrides& options : {method("euler", {"time.step=0.01"}), method("arkode")}) {
    Overrides threaded = options;
    threaded.push_back("compute.threads=2");
    SimulatedCase one(text, options), two(text, threaded);
    EXPECT_EQ(one.advance_to(0.01), two.advance_to(0.01)) << options[0];
  }
}

// A Newton correction moves vertices along straight lines, which stretches triangles that rotate:
// the residual grows until the next correction.
TEST(Methods, EulerConvergesHoweverStiff) {
  for (const char* stiffness : {"1e3", "1e6", "1e9"}) {
    Overrides options = method("euler");
    options.insert(options.end(), {"time.step=1e-3",
                                   std::string("material.cloth.membrane_stiffness=") + stiffness});
    SimulatedCase sim(hanging_sheet, options);
    sim.advance_to(0.05);
    const IntegratorCounts counts = sim.integrator().counts();
    EXPECT_EQ(counts.steps, 50) << stiffness;
    EXPECT_EQ(counts.convergence_failures, 0) << stiffness;
    EXPECT_LE(counts.newton_iterations, 8 * counts.steps) << stiffness;
  }
}

// With narrow and stiff triangles, conjugate gradients take hundreds of iterations for each
// correction.
TEST(Methods, WhatWearsConjugateGradientsOutIsFactorised) {
  const auto run = [](const char* preconditioner) {
    SimulatedCase sim(hanging_sheet,
                      method("euler", {"time.step=1e-3", "material.cloth.membrane_stiffness=1e6",
                                       "body.sheet.shape.size=[1, 0.01]",
                                       std::string("time.preconditioner=") + preconditioner}));
    std::vector<double> y = sim.advance_to(0.02);
    return std::pair(std::move(y), sim.integrator().counts().linear_iterations);
  };
  const auto [factorised, solves] = run("automatic");
  const auto [iterated, iterations] = run("block_jacobi");
  EXPECT_LT(10 * solves, iterations);
  EXPECT_LT(position_difference(factorised, iterated), 1e-4);
}

// Triangles whose edges differ by a factor of 10^8.
TEST(Methods, ArkodeSaysWhereItFails) {
  const std::string needles = R"(
[time]
duration = 0.1
[contact]
enabled = false
[material.cloth]
bending_stiffness = 1e-5
[[body]]
name = "ring"
shape = { type = "torus", major_radius = 0.3, minor_radius = 0.299999997, resolution = [12, 16] }
[[body.pin]]
region_min = [0.3, -1, -1]
region_max = [1, 1, 1]
)";
  SimulatedCase sim(needles, method("arkode", {"time.minimum_step=5e-3"}));
  std::optional<Failure> reason;
  for (int i = 0; i < 200 && !reason; ++i) reason = sim.integrator().step();
  ASSERT_TRUE(reason);
  EXPECT_NE(reason->text.find("body \"ring\", row"), std::string::npos) << reason->text;
}

}  // namespace
}  // namespace weft::sim::methods_test
