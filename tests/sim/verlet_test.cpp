// Explicit steps: their energy, and the stability limit that they follow.
#include <cmath>
#include <limits>

#include "sim/integrator/verlet_steps.h"
#include "sim/motion/spectral_estimate.h"
#include "simulated_case.h"
#include "tests/dense_algebra.h"

namespace weft::sim::verlet_test {
namespace {

// The energy of verlet oscillates by an amount that grows with the square of the step, and steps
// grow with the root of the tolerance.
TEST(Verlet, KeepsTheEnergyOfAnUndampedSheet) {
  const auto drift = [&](const std::string& tolerance) {
    SimulatedCase sim(hanging_sheet, method("verlet", {"time.duration=10",
                                                       "time.relative_tolerance=" + tolerance}));
    double largest = 0, kinetic = 0;
    for (double t = 0; t <= 10; t += 0.25) {
      const Energies energies = sim.dynamics().energies(t, sim.advance_to(t));
      largest = std::max(largest, std::abs(energies.total()));  // it begins at 0
      kinetic = std::max(kinetic, energies.kinetic);
    }
    return largest / kinetic;
  };
  const double at_default = drift("1e-4");
  EXPECT_LT(at_default, 0.01);
  EXPECT_LT(drift("2.5e-5"), at_default / 2);
}

TEST(Verlet, SpectralEstimateIsThatOfTheOscillator) {
  SimulatedCase sim(oscillator, {"material.spring.mass_damping=7"});
  const SpectralEstimate estimate = estimate_spectrum(sim.dynamics(), 0, sim.integrator().state());
  // Along y the free corners (1/3 and 1/6 kg) share a spring: k (1/m1 + 1/m2).
  EXPECT_NEAR(estimate.frequency, std::sqrt(100 * (3.0 + 6.0)), 0.01);
  EXPECT_NEAR(estimate.decay, 7, 1e-6);
}

// Returns the highest frequency, rad/s, from all eigenvalues of M^-1/2 K M^-1/2 on the free
// particles.
double highest_frequency(SimulatedCase& sim) {
  Dynamics& dynamics = sim.dynamics();
  dynamics.assemble(0, sim.integrator().state());
  const int count = dynamics.particle_count();
  Eigen::MatrixXd scaled = Eigen::MatrixXd::Zero(3 * count, 3 * count);
  std::vector<Vec3> unit(count, Vec3::Zero()), product(count);
  for (int column = 0; column < 3 * count; ++column) {
    unit[column / 3][column % 3] = 1;
    dynamics.stiffness().multiply(unit, product, 1);
    unit[column / 3].setZero();
    const auto& mass = sim.scene().mass;
    for (int row = 0; row < count; ++row) {
      if (sim.scene().is_free(row) && sim.scene().is_free(column / 3))
        scaled.col(column).segment<3>(3 * row) =
            product[row] / std::sqrt(mass[row] * mass[column / 3]);
    }
  }
  return std::sqrt(eigenvalues(scaled).maxCoeff());
}

// A tracker that started from random vectors alone would fail this test.
TEST(Verlet, SpectralEstimatesAreAFewPercentBelowTheHighestFrequency) {
  for (const Overrides& more : {Overrides{"body.sheet.shape.resolution=[17, 17]"},
                                Overrides{"body.sheet.shape.resolution=[12, 18]"},
                                Overrides{"material.cloth.bending_stiffness=1"},
                                Overrides{"material.cloth.membrane=\"springs\"",
                                          "material.cloth.structural_stiffness=100"}}) {
    SimulatedCase sim(hanging_sheet, method("verlet", more));
    SCOPED_TRACE(more.empty() ? "" : more[0]);
    const double exact = highest_frequency(sim);
    const auto start = sim.integrator().state();
    const double estimate = estimate_spectrum(sim.dynamics(), 0, start).frequency;
    EXPECT_GT(estimate, 0.985 * exact);
    EXPECT_LT(estimate, (1 + 1e-9) * exact);
    const double tracked = FrequencyTracker(sim.dynamics(), 0, start).frequency();
    EXPECT_GT(tracked, 0.97 * exact);
    EXPECT_LT(tracked, (1 + 1e-4) * exact);
  }
}

// A strip that its own weight stretches by half and more. The St. Venant-Kirchhoff membrane then
// vibrates much faster than at the start.
const std::string stretching_strip = R"(
[time]
duration = 1
[world]
gravity = [0, 9.81, 0]
[contact]
enabled = false
[material.rubber]
density = 1
membrane_stiffness = 20
[[body]]
name = "strip"
shape = { type = "rectangle", size = [0.3, 1.0], resolution = [17, 5] }
[[body.pin]]
edges = ["first_row"]
)";

TEST(Verlet, TrackedFrequencyIsThatOfTheMatrix) {
  SimulatedCase sim(stretching_strip, method("cvode"));
  const double start = estimate_spectrum(sim.dynamics(), 0, sim.integrator().state()).frequency;
  FrequencyTracker tracker(sim.dynamics(), 0, sim.integrator().state());
  EXPECT_NEAR(tracker.frequency(), start, 0.02 * start);
  const std::vector<double> y = sim.advance_to(0.4);
  const double frequency = estimate_spectrum(sim.dynamics(), 0.4, y).frequency;
  EXPECT_GT(frequency, 1.3 * start);
  std::vector<Vec3> acceleration(sim.dynamics().particle_count());
  ASSERT_FALSE(sim.dynamics().acceleration(0.4, y, acceleration));
  for (int k = 0; k < 60; ++k) tracker.follow(0.4, y, acceleration);
  EXPECT_NEAR(tracker.frequency(), frequency, 0.1 * frequency);
  // A vector with parts of all vibrations converges sooner.
  tracker.track_direction_of(acceleration);
  for (int k = 0; k < 20; ++k) tracker.follow(0.4, y, acceleration);
  EXPECT_NEAR(tracker.frequency(), frequency, 0.05 * frequency);
}

// Returns the largest change of its energy within a second, J. Its weight would do 1.5 J over its
// own length.
double energy_strayed(const Overrides& options) {
  SimulatedCase sim(stretching_strip, method("verlet", options));
  const auto energy = [&] {
    return sim.energy(0, {sim.integrator().state().begin(), sim.integrator().state().end()});
  };
  const double start = energy();
  double strayed = 0;
  while (sim.integrator().time() < 1) {
    if (sim.integrator().step()) return std::numeric_limits<double>::infinity();
    strayed = std::max(strayed, std::abs(energy() - start));
    // An unstable motion needs ever shorter steps.
    if (strayed > 1e3) break;
  }
  return strayed;
}

TEST(Verlet, ShortensItsLongestStepsWhereTheMotionStiffens) {
  SimulatedCase sim(stretching_strip, method("cvode"));
  const double limit = 2 / estimate_spectrum(sim.dynamics(), 0, sim.integrator().state()).frequency;
  EXPECT_GT(energy_strayed({key("step", longest_verlet_share * limit)}), 15);
  EXPECT_LT(energy_strayed({"time.relative_tolerance=1e-2"}), 0.05);
  EXPECT_LT(energy_strayed({"time.relative_tolerance=1e-4"}), 0.005);
}

TEST(Verlet, RefusesAStepBeyondItsStability) {
  SimulatedCase sim(stretching_strip, method("verlet", {"time.step=0.1"}));
  const auto reason = sim.integrator().step();
  ASSERT_TRUE(reason);
  EXPECT_NE(reason->text.find("limit of stability"), std::string::npos) << reason->text;
  EXPECT_NE(reason->text.find("body \"strip\", row"), std::string::npos) << reason->text;
  EXPECT_EQ(sim.integrator().time(), 0);
}

// Returns true if the steps h (s) of one coordinate, with x'' = -omega^2 x - d x', grow.
bool steps_grow(double h, double omega, double d) {
  double x = 0, v = 1, a = 0;
  for (int k = 0; k < 20'000 && std::abs(v) < 1e3; ++k) {
    x += h * (v + h / 2 * a);
    const double end = -omega * omega * x - d * (v + h * a);
    v += h / 2 * (a + end);
    a = end;
  }
  return std::abs(v) >= 1e3;
}

// Damping shortens the longest stable step. The fastest vibration of the rod of springs is that
// along y, of frequency omega and decay rate d.
TEST(Verlet, StepsOfDampedMotionAreStableUpToTheLimitAndRefusedBeyondIt) {
  const double omega = 30;
  for (const double ratio : {0.0, 0.1, 0.5, 1.0, 3.0}) {
    SCOPED_TRACE(ratio);
    const double d = ratio * omega, limit = 2 / (d + std::hypot(d, omega));
    EXPECT_FALSE(steps_grow(0.99 * limit, omega, d));
    EXPECT_TRUE(steps_grow(1.01 * limit, omega, d));
    const Overrides damped{"material.spring.mass_damping=" + std::to_string(d)};
    Overrides shorter = damped, longer = damped;
    shorter.push_back(key("step", 0.98 * limit));
    longer.push_back(key("step", 1.02 * limit));
    SimulatedCase sim(oscillator, method("verlet", shorter));
    const auto speed = [&] {
      const auto state = sim.integrator().state();
      double largest = 0;
      for (std::size_t i = state.size() / 2; i < state.size(); ++i)
        largest = std::max(largest, std::abs(state[i]));
      return largest;
    };
    while (sim.integrator().time() < 10) {
      const auto reason = sim.integrator().step();
      ASSERT_FALSE(reason) << reason->text;
    }
    EXPECT_LT(speed(), 1);
    SimulatedCase refused(oscillator, method("verlet", longer));
    const auto reason = refused.integrator().step();
    ASSERT_TRUE(reason);
    EXPECT_NE(reason->text.find("limit of stability"), std::string::npos) << reason->text;
  }
}

// Unstable motion needs ever shorter steps, which must end.
TEST(Verlet, EndsWhereItsStepsWouldBeTooShort) {
  SimulatedCase sim(stretching_strip,
                    method("verlet", {"time.minimum_step=0.1", "time.frames_per_second=5"}));
  const auto reason = sim.integrator().step();
  ASSERT_TRUE(reason);
  EXPECT_NE(reason->text.find("0.1 s (time.minimum_step) is stable at t = 0 s"), std::string::npos)
      << reason->text;
  EXPECT_NE(reason->text.find("fastest at body \"strip\", row"), std::string::npos) << reason->text;
  EXPECT_EQ(sim.integrator().time(), 0);
}

// Damping makes the steps too short here. That a floor is near has no part in it.
TEST(Verlet, DoesNotBlameContactWhereItsStepsAreUnstable) {
  SimulatedCase sim(
      stretching_strip +
          "[[obstacle]]\nname = \"floor\"\nposition = [0, 0, -1.5e-3]\n"
          "shape = { type = \"plane\", size = [3, 3] }\n",
      method("verlet", {"contact.enabled=true", "material.rubber.stiffness_damping=1e4"}));
  const auto reason = sim.integrator().step();
  ASSERT_TRUE(reason);
  EXPECT_NE(reason->text.find("is stable at t = 0 s"), std::string::npos) << reason->text;
  EXPECT_EQ(reason->text.find("floor"), std::string::npos) << reason->text;
}

}  // namespace
}  // namespace weft::sim::verlet_test
