// Simulated shapes and motions against closed forms and tables.
#include <cmath>
#include <numbers>

#include "../reference_value.h"
#include "simulated_case.h"

namespace weft::sim::physics_test {
namespace {

constexpr double g = 9.81;

// A catenary of length L between supports at the same height, L / span = 1.25. Its sag / span
// follows from y = a (cosh(x/a) - 1), L = 2 a sinh(span / 2a).
TEST(Physics, StripBetweenTwoSupportsHangsInACatenary) {
  const std::string text = R"(
[time]
duration = 20
position_tolerance = 1e-5
[contact]
enabled = false
[material.chain]
density = 0.2
membrane_stiffness = 5000
poisson_ratio = 0.0
mass_damping = 4.0
[[body]]
name = "strip"
shape = { type = "rectangle", size = [1.25, 0.05], resolution = [2, 51] }
[[body.pin]]
edges = ["first_col"]
[[body.pin]]
edges = ["last_col"]
[body.pin.motion]
keyframes = [{ time = 0.0 }, { time = 1.0, translation = [-0.25, 0, 0] }]
)";
  SimulatedCase sim(text);
  const std::vector<Vec3> x = sim.positions_at(8.0);
  double mean_top = 0, lowest = 0;
  for (int row = 0; row < 2; ++row) {
    mean_top += 0.5 * x[row * 51].z();
    double low = x[row * 51].z();
    for (int col = 0; col < 51; ++col) low = std::min(low, x[row * 51 + col].z());
    lowest += 0.5 * low;
  }
  EXPECT_NEAR((mean_top - lowest) / reference_value("catenary_sag_over_span"), 1, 0.01);
}

// Large swings of a point mass on a rod: T / T0 = 1.18034 from horizontal (complete elliptic
// integral K(sin 45 deg)).
TEST(Physics, SpringPendulumFromHorizontalHasThePeriodOfTheEllipticIntegral) {
  const std::string text = R"(
[time]
duration = 3
position_tolerance = 1e-7
[contact]
enabled = false
[material.rod]
density = 1.0
membrane = "springs"
structural_stiffness = 2e4
[[body]]
name = "pendulum"
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [2, 2] }
[[body.pin]]
edges = ["first_row"]
)";
  SimulatedCase sim(text);
  // A quarter of the period ends where the free row passes below the pinned one.
  double before = 0, quarter = 0;
  while (quarter == 0 && sim.integrator().time() < 1.0) {
    before = sim.integrator().time();
    ASSERT_FALSE(sim.integrator().step());
    const StateView state = StateView::of(sim.integrator().state());
    if (state.position[2].y() > -0.5) continue;
    double low = before, high = sim.integrator().time();
    std::vector<double> y(sim.dynamics().state_size());
    for (int i = 0; i < 50; ++i) {
      quarter = 0.5 * (low + high);
      ASSERT_EQ(sim.integrator().state_at(quarter, y), std::nullopt);
      (StateView::of(y).position[2].y() > -0.5 ? low : high) = quarter;
    }
  }
  const double small_swing_period = 2 * std::numbers::pi * std::sqrt(1.0 / g);
  EXPECT_NEAR(4 * quarter / small_swing_period, reference_value("pendulum_period_ratio_90_degrees"),
              1e-3);
}

// The first mode of a chain hung by one end has omega = (j_01 / 2) sqrt(g / L) and the shape
// J0(j_01 sqrt(s / L)), with s from the free end (D. Bernoulli 1733).
TEST(Physics, HangingStripSwingsAtTheFrequencyOfAHangingChain) {
  const std::string text = R"(
[time]
duration = 2
position_tolerance = 1e-7
[contact]
enabled = false
[material.chain]
density = 0.2
membrane_stiffness = 2e4
poisson_ratio = 0.0
stiffness_damping = 1e-4
[[body]]
name = "strip"
shape = { type = "rectangle", size = [0.05, 1.0], resolution = [41, 2] }
rotation_deg = [89.5, 0, 0]
[[body.pin]]
edges = ["last_row"]
)";
  SimulatedCase sim(text);
  const double first_zero = reference_value("bessel_J0_first_zero");
  const auto amplitude = [&](const std::vector<double>& y) {
    const StateView state = StateView::of(y);
    double sum = 0;
    for (int row = 0; row < 41; ++row) {
      const double s = row / 40.0;
      sum += std::cyl_bessel_j(0, first_zero * std::sqrt(s)) *
             (state.position[2 * row].y() - state.position[80].y()) * (row == 0 ? 0.5 : 1.0);
    }
    return sum;
  };
  // From rest, the first zero is a quarter of the period away.
  std::vector<double> y = sim.advance_to(0.0);
  const double start = amplitude(y);
  double low = 0, high = 0;
  for (double t = 0.01; t < 1.0 && high == 0; t += 0.01) {
    if (amplitude(sim.advance_to(t)) * start <= 0) high = t;
    if (high == 0) low = t;
  }
  ASSERT_GT(high, 0);
  SimulatedCase again(text);
  const double at_low = amplitude(again.advance_to(low)),
               at_high = amplitude(again.advance_to(high));
  const double quarter = low + (high - low) * at_low / (at_low - at_high);
  const double omega = std::numbers::pi / 2 / quarter;
  EXPECT_NEAR(omega / std::sqrt(g) / reference_value("hanging_chain_first_frequency"), 1, 0.01);
}

// A square membrane with held edges, stretched by lambda both ways, is released under a gravity g.
// Small deflections w obey rho w'' = S laplace(w) - rho g in the coordinates of the rest shape,
// with the second Piola-Kirchhoff tension of Saint Venant-Kirchhoff, S = E h / (1 - nu) (lambda^2 -
// 1) / 2. The modes sin(m pi x / L) sin(n pi y / L) of the fixed square have omega^2 = S / rho (pi
// / L)^2 (m^2 + n^2) (Rayleigh, The Theory of Sound, section 195). Each answers the load with w_mn
// = -16 g / (pi^2 m n omega^2) (1 - cos omega t) for odd m and n.
TEST(Physics, StretchedMembraneVibratesAtItsClosedFormFrequencies) {
  constexpr int side = 33;
  SimulatedCase sim(R"(
[time]
duration = 0.12
position_tolerance = 1e-8
relative_tolerance = 1e-6
[contact]
enabled = false
[material.skin]
density = 0.2
membrane_stiffness = 1000
poisson_ratio = 0.3
[[body]]
name = "drum"
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [33, 33] }
stretch = [1.05, 1.05, 1.0]
[[body.pin]]
edges = ["first_row", "last_row", "first_col", "last_col"]
)");
  const double pi = std::numbers::pi;
  const double tension = 1000 / (1 - 0.3) * (1.05 * 1.05 - 1) / 2;
  const auto amplitude = [&](const std::vector<double>& y, int m, int n) {
    const StateView state = StateView::of(y);
    double sum = 0;
    for (int row = 0; row < side; ++row) {
      for (int column = 0; column < side; ++column) {
        sum += state.position[side * row + column].z() * std::sin(m * pi * row / (side - 1)) *
               std::sin(n * pi * column / (side - 1));
      }
    }
    return 4 * sum / ((side - 1) * (side - 1));
  };
  const auto expected = [&](double t, int m, int n) {
    const double omega = pi * std::sqrt(tension / 0.2 * (m * m + n * n));
    return -16 * g / (pi * pi * m * n * omega * omega) * (1 - std::cos(omega * t));
  };
  for (double t = 0.01; t < 0.115; t += 0.01) {
    const std::vector<double> y = sim.advance_to(t);
    for (const auto& [m, n] : {std::pair{1, 1}, {1, 3}, {3, 1}}) {
      const double half_period = std::sqrt(0.2 / (tension * (m * m + n * n)));
      // The mesh slows waves by a share that grows as the square of their number.
      const double share = 0.005 * (m * m + n * n);
      EXPECT_NEAR(amplitude(y, m, n), expected(t, m, n), share * -expected(half_period, m, n))
          << m << n << " at " << t;
    }
  }
}

// A strip clamped horizontally that sags under its weight, Gamma = sigma g L^3 / D = 10: drop
// 0.7001997155 L and reach 0.6563537612 L (planar elastica by shooting, 1e-12).
TEST(Physics, ClampedStripSagsLikeTheHeavyElastica) {
  // The angle at the second held column bends half of the held cell, so the clamp acts in that
  // cell's middle: L = 40.5 cells = 0.2 m. nu = 0: cylindrical bending.
  constexpr double cell = 0.2 / 40.5;
  const std::string text = R"(
[time]
duration = 10
[contact]
enabled = false
[material.sheet]
density = 0.2
membrane_stiffness = 2000
poisson_ratio = 0.0
bending_stiffness = 1.5696e-3
mass_damping = 6.0
bending_damping = 2e-3
[[body]]
name = "strip"
shape = { type = "rectangle", size = [0.20246913580246914, 0.04], resolution = [9, 42] }
[[body.pin]]
cols = [0, 1]
)";
  SimulatedCase sim(text);
  const std::vector<Vec3> x = sim.positions_at(4.0);
  double drop = 0, reach = 0;
  for (int row = 0; row < 9; ++row) {
    drop += (x[row * 42 + 1].z() - x[row * 42 + 41].z()) / 9;
    reach += (x[row * 42 + 41].x() - x[row * 42 + 1].x() + 0.5 * cell) / 9;
  }
  EXPECT_NEAR(drop / 0.2, reference_value("heavy_elastica_drop_over_length"), 0.005);
  EXPECT_NEAR(reach / 0.2, reference_value("heavy_elastica_reach_over_length"), 0.005);
}

// A hung strip of weight w and stiffness E A per length stretches by the StVK relation T = E A (l^3
// - l) / 2: tip extension / L = 0.0238607 at w L / E A = 0.05.
TEST(Physics, HungStripStretchesByTheStVenantKirchhoffLaw) {
  const std::string text = R"(
[time]
duration = 10
[contact]
enabled = false
[material.soft]
density = 1.0
membrane_stiffness = 196.2
poisson_ratio = 0.0
mass_damping = 8.0
[[body]]
name = "strip"
shape = { type = "rectangle", size = [0.1, 1.0], resolution = [41, 3] }
rotation_deg = [90, 0, 0]
[[body.pin]]
edges = ["last_row"]
)";
  SimulatedCase sim(text);
  const std::vector<Vec3> x = sim.positions_at(3.0);
  EXPECT_NEAR(x[121].z() - x[1].z() - 1.0, reference_value("hung_strip_extension_over_length"),
              2e-4);
}

}  // namespace
}  // namespace weft::sim::physics_test
