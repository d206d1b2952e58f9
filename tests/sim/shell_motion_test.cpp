// Shells in motion, whose mass is consistent with their splines: against closed forms, dense
// matrices and laws of motion, by every method.
#include <cmath>
#include <numbers>

#include "../reference_value.h"
#include "sim/motion/external_work.h"
#include "sim/simulation/simulation.h"
#include "sim/solver/direct_solver.h"
#include "sim/solver/tangent_factors.h"
#include "sim/solver/velocity_system.h"
#include "simulated_case.h"
#include "tests/dense_algebra.h"

namespace weft::sim::shell_motion_test {
namespace {

// A shell of a width of 1/5 and a thickness of 1/50 along x from 0 to 1, which bends as a beam
// does: with Poisson's ratio 0 its sections stay flat.
std::string beam(int columns, const std::string& more = "", const std::string& material = "") {
  return R"(
[time]
duration = 10
[contact]
enabled = false
[material.solid]
model = "shell"
youngs_modulus = 1e7
poisson_ratio = 0
shell_thickness = 0.02
volume_density = 1000
)" + material +
         R"(
[[body]]
name = "beam"
position = [0.5, 0, 0]
shape = { type = "rectangle", size = [1, 0.2], resolution = [4, )" +
         std::to_string(columns) + "] }\n" + more;
}
const std::string clamp = "[[body.pin]]\nedges = [\"first_col\"]\nclamp = true\n";

// The frequencies of a clamped beam (rad/s): (beta L)^2 sqrt(E h^2 / (12 rho)) / L^2.
const double slowness = std::sqrt(1e7 * 0.02 * 0.02 / (12 * 1000));
double beam_frequency(int mode) {
  const double beta = reference_value("cantilever_beam_root_" + std::to_string(mode));
  return beta * beta * slowness;
}

// The lowest frequency (rad/s) by inverse iteration from a parabola, with this form of the mass.
double lowest_frequency(int columns, MassOperator::Form form) {
  SimulatedCase sim(beam(columns, clamp));
  Dynamics& dynamics = sim.dynamics();
  MassOperator mass(sim.scene(), form);
  mass.attach(dynamics.stiffness().shared_pattern());
  const std::vector<double> y = dynamics.initial_state();
  dynamics.assemble(0, y);
  TangentFactors factors(dynamics);
  EXPECT_TRUE(factors.factorise());
  std::vector<Vec3> shape, weighted(dynamics.particle_count());
  for (const Vec3& x : StateView::of(y).position) shape.emplace_back(0, 0, x.x() * x.x());
  double square = 0;
  for (int i = 0; i < 12; ++i) {
    mass.multiply(shape, weighted, 1);
    EXPECT_TRUE(factors.solve(weighted, shape));
    // v = K^-1 M u: the Rayleigh quotient v . K v / v . M v, with K v = M u.
    square = 0;
    for (std::size_t k = 0; k < shape.size(); ++k) square += shape[k].dot(weighted[k]);
    square /= mass.product(shape, shape, 1);
    const double size = shape.back().norm();
    for (Vec3& each : shape) each /= size;
  }
  return std::sqrt(square);
}

TEST(ShellMotion, FrequenciesConvergeWithTheFourthPowerOfTheSize) {
  const double exact = beam_frequency(1);
  std::vector<double> consistent, lumped;
  for (const int elements : {2, 4, 8}) {
    consistent.push_back(lowest_frequency(elements + 3, MassOperator::Form::consistent) / exact -
                         1);
    lumped.push_back(lowest_frequency(elements + 3, MassOperator::Form::lumped) / exact - 1);
  }
  EXPECT_LT(std::abs(consistent[2]), 1e-5);
  for (int i = 1; i < 3; ++i) EXPECT_GT(consistent[i - 1] / consistent[i], 12) << consistent[i];
  // Row sums keep the second order only.
  EXPECT_GT(std::abs(lumped[2]), 5e-3);
  EXPECT_LT(lumped[1] / lumped[2], 5);
}

// The tip of the beam at a time after its weight begins to act, m: the sum of its modes.
double tip_under_weight(double gravity, double time) {
  double sum = 0;
  for (int mode = 1; mode <= 5; ++mode) {
    const double beta = reference_value("cantilever_beam_root_" + std::to_string(mode));
    const double ratio = (std::cosh(beta) + std::cos(beta)) / (std::sinh(beta) + std::sin(beta));
    const double omega = beam_frequency(mode);
    sum += (mode % 2 == 1 ? 4 : -4) * ratio / beta * gravity / (omega * omega) *
           (1 - std::cos(omega * time));
  }
  return sum;
}

constexpr const char* light_gravity = "world.gravity=[0,0,2e-4]";

// Compares the tip with the closed form at times, s.
void expect_closed_form(int columns, const Overrides& options,
                        std::initializer_list<double> times) {
  SimulatedCase sim(beam(columns, clamp), options);
  constexpr double gravity = 2e-4;
  const double rest = tip_under_weight(gravity, std::numbers::pi / beam_frequency(1)) / 2;
  for (const double time : times) {
    const double tip = sim.positions_at(time)[columns - 1].z();
    EXPECT_NEAR(tip, tip_under_weight(gravity, time), 1.5e-3 * rest) << time;
  }
}

class SwingingBeam : public testing::TestWithParam<Overrides> {};
TEST_P(SwingingBeam, FollowsTheClosedForm) {
  Overrides options = GetParam();
  for (const char* each : {light_gravity, "time.position_tolerance=1e-10",
                           "time.velocity_tolerance=1e-9", "time.relative_tolerance=1e-7"})
    options.emplace_back(each);
  expect_closed_form(11, options, {0.7, 1.6, 2.9, 4.4});
}
INSTANTIATE_TEST_SUITE_P(All, SwingingBeam,
                         testing::Values(method("cvode"), method("arkode"),
                                         method("implicit_midpoint", {"time.step=0.01"})));

// The steps of verlet, limited by stability, are far shorter than this motion needs.
TEST(ShellMotion, VerletFollowsTheClosedForm) {
  expect_closed_form(7, method("verlet", {light_gravity}), {0.7, 1.6});
}

// A shell at rest falls as a stone does, up to rounding. Lengths of up to 1 m round by some 1e-16
// m, and the square of the highest frequency turns these into accelerations.
TEST(ShellMotion, FallsWithGravity) {
  SimulatedCase sim(beam(7), {"world.gravity=[1,2,-9]"});
  Dynamics& dynamics = sim.dynamics();
  std::vector<Vec3> acceleration(sim.scene().mass.size());
  ASSERT_FALSE(dynamics.acceleration(0, dynamics.initial_state(), acceleration));
  dynamics.assemble(0, dynamics.initial_state());
  VelocitySystem system(dynamics);
  const double rounding = 1e-15 * std::pow(system.highest_frequency(), 2);
  EXPECT_LT(rounding, 1e-6);
  for (const Vec3& each : acceleration) EXPECT_LT((each - Vec3(1, 2, -9)).norm(), rounding);
}

TEST(ShellMotion, MassDampingSlowsItExponentially) {
  SimulatedCase sim(
      beam(7, "velocity = [0, 0, 2]\n", "mass_damping = 1.5\n"),
      {"world.gravity=[0,0,0]", "time.relative_tolerance=1e-7", "time.position_tolerance=1e-8"});
  const std::vector<double> y = sim.advance_to(0.8);
  for (const Vec3& v : StateView::of(y).velocity)
    EXPECT_LT((v - Vec3(0, 0, 2 * std::exp(-1.5 * 0.8))).norm(), 1e-5);
}

// A pin that shakes the clamped edge.
const std::string shaken = R"([[body.pin]]
edges = ["first_col"]
clamp = true
motion = { keyframes = [{ time = 0.0 }, { time = 1.0, translation = [0, 0.05, 0.2] }] }
)";

// The pins' forces and the weight change the momentum of a shell whose edge is shaken.
TEST(ShellMotion, SupportsCarryTheInertiaOfWhatTheyHold) {
  SimulatedCase sim(beam(7, shaken), {"world.gravity=[0,0,-9]"});
  Dynamics& dynamics = sim.dynamics();
  constexpr double time = 0.3;
  std::vector<double> y = dynamics.initial_state(), rate(y.size());
  dynamics.place_pins(time, y);
  ASSERT_FALSE(dynamics.rate(time, y, rate));
  ForceParts parts;
  dynamics.find_force_parts(time, y, parts);
  Vec3 momentum_rate = Vec3::Zero(), forces = Vec3::Zero();
  const StateView change = StateView::of(rate);
  for (int i = 0; i < dynamics.particle_count(); ++i) {
    momentum_rate += sim.scene().mass[i] * change.velocity[i];
    forces += parts.own[i] + parts.support[i];
    const Vec3 product = dynamics.mass().row_product(i, change.velocity.data());
    EXPECT_LT((product - parts.own[i] - parts.support[i]).norm(), 1e-9);
  }
  EXPECT_GT(momentum_rate.norm(), 1);
  EXPECT_LT((momentum_rate - forces).norm(), 1e-9);
}

// The energy that a shell gains is the work of its pins.
TEST(ShellMotion, GainsTheWorkOfItsPins) {
  SimulatedCase sim(beam(9, shaken), {"time.relative_tolerance=1e-8", "time.maximum_step=2e-3",
                                      "time.position_tolerance=1e-9"});
  ExternalWork external(sim.dynamics(), sim.integrator().state());
  const auto free_energy = [&](double time, std::span<const double> y) {
    const Energies now = sim.dynamics().energies(time, y);
    return now.total() - external.held_kinetic_energy() - external.held_gravitational_energy();
  };
  const double start = free_energy(0, sim.integrator().state());
  double most = 0;
  while (sim.integrator().time() < 0.3) {
    const auto failure = sim.integrator().step();
    ASSERT_FALSE(failure) << failure->text;
    const double time = sim.integrator().time();
    external.add_step(time, sim.integrator().state());
    most = std::max(most, std::abs(external.work()));
    // The first steps, of order 1, lose 1e-7 J of the beam's fall.
    EXPECT_NEAR(free_energy(time, sim.integrator().state()) - start, external.work(),
                3e-5 * most + 2e-7);
  }
  EXPECT_GT(most, 1);
}

// (I - gamma J) by differences of the rates, on the rows and columns of free particles.
Eigen::MatrixXd newton_matrix(Dynamics& dynamics, double time, std::vector<double> y,
                              double gamma) {
  const auto size = static_cast<Eigen::Index>(y.size());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(size, size);
  std::vector<double> plus(y.size()), minus(y.size());
  constexpr double step = 1e-6;
  for (Eigen::Index k = 0; k < size; ++k) {
    if (dynamics.scene().pinned[static_cast<std::size_t>(k) % (y.size() / 2) / 3] != 0) continue;
    const double value = y[k];
    y[k] = value + step;
    EXPECT_FALSE(dynamics.rate(time, y, plus));
    y[k] = value - step;
    EXPECT_FALSE(dynamics.rate(time, y, minus));
    y[k] = value;
    for (Eigen::Index i = 0; i < size; ++i)
      matrix(i, k) -= gamma * (plus[i] - minus[i]) / (2 * step);
  }
  return matrix;
}

// The residual of a solution of the Newton system, against that of no solution.
double newton_residual(const Eigen::MatrixXd& matrix, const std::vector<double>& solution,
                       const std::vector<double>& b) {
  double left = 0, all = 0;
  for (std::size_t i = b.size() / 2; i < b.size(); ++i) {
    double row = 0;
    for (std::size_t k = 0; k < b.size(); ++k)
      row += matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) * solution[k];
    left += (row - b[i]) * (row - b[i]);
    all += b[i] * b[i];
  }
  return std::sqrt(left / all);
}

class NewtonSystem : public testing::TestWithParam<std::string> {};
TEST_P(NewtonSystem, IsThatOfTheRates) {
  const std::string more = GetParam();
  for (const char* preconditioner : {"block_jacobi", "multigrid"}) {
    SimulatedCase sim(beam(8, shaken, more),
                      {"time.preconditioner=\"" + std::string(preconditioner) + "\""});
    Dynamics& dynamics = sim.dynamics();
    constexpr double time = 0.4, gamma = 3e-3;
    std::vector<double> y = dynamics.initial_state();
    auto* const x = reinterpret_cast<Vec3*>(y.data());
    for (int i = 0; i < dynamics.particle_count(); ++i)
      x[i].z() += 0.02 * std::sin(3 * x[i].x() + x[i].y());
    dynamics.place_pins(time, y);
    // All particles move as the pins do: the matrices leave out what strain rates change in the
    // stiffness.
    Vec3* const v = x + dynamics.particle_count();
    for (int i = 0; i < dynamics.particle_count(); ++i) {
      if (dynamics.scene().pinned[i] == 0) v[i] = v[0];
    }
    std::vector<double> b(y.size(), 0.0), weight(y.size(), 1.0), solution(y.size());
    for (std::size_t i = 0; i < b.size(); ++i) {
      if (dynamics.scene().pinned[i % (b.size() / 2) / 3] == 0)
        b[i] = (i < b.size() / 2 ? 1e-3 : 1) * std::sin(1.7 * static_cast<double>(i));
    }
    const Eigen::MatrixXd matrix = newton_matrix(dynamics, time, y, gamma);
    std::vector<double> rate(y.size());
    const auto judge = [&](bool joined) {
      ASSERT_FALSE(dynamics.rate(time, y, rate));
      if (joined) {
        std::vector<Vec3> residual;
        for (const Vec3& each : StateView::of(b).position) residual.emplace_back(-each);
        dynamics.assemble_joined(time, y, Definiteness::exact, gamma, residual);
      } else {
        dynamics.assemble(time, y);
      }
      VelocitySystem system(dynamics);
      system.set_up(gamma);
      EXPECT_TRUE(system.solve(gamma, b, weight, {.residual = 1e-10}, solution).converged);
      EXPECT_LT(newton_residual(matrix, solution, b), 1e-6) << preconditioner;
      EXPECT_TRUE(system.solve_directly(gamma, b, weight, solution));
      EXPECT_LT(newton_residual(matrix, solution, b), 1e-6);
    };
    judge(false);
    judge(true);
  }
}
INSTANTIATE_TEST_SUITE_P(All, NewtonSystem,
                         testing::Values("", "mass_damping = 20\n",
                                         "mass_damping = 2\nstiffness_damping = 1e-3\n"
                                         "bending_damping = 2e-3\n"));

// In steps so short that A is nearly M, the error of a solution meets the goal of its residual.
TEST(ShellMotion, ResidualsAreDividedByTheConsistentMass) {
  SimulatedCase sim(beam(12, clamp), {"time.preconditioner=\"block_jacobi\""});
  Dynamics& dynamics = sim.dynamics();
  const std::vector<double> y = dynamics.initial_state();
  dynamics.assemble(0, y);
  std::vector<double> b(y.size(), 0.0), weight(y.size(), 1.0), solution(y.size()), exact(y.size());
  for (std::size_t i = b.size() / 2; i < b.size(); ++i)
    b[i] = std::sin(1.7 * static_cast<double>(i * i));
  constexpr double gamma = 1e-7;
  VelocitySystem system(dynamics);
  system.set_up(gamma);
  ASSERT_TRUE(system.solve_directly(gamma, b, weight, exact));
  for (const double goal : {1e-1, 1e-2, 1e-3}) {
    EXPECT_TRUE(system.solve(gamma, b, weight, {.residual = goal}, solution).converged);
    double square = 0;
    for (std::size_t i = b.size() / 2; i < b.size(); ++i)
      square += std::pow(solution[i] - exact[i], 2);
    EXPECT_LT(std::sqrt(square), 1.01 * goal);
    EXPECT_GT(std::sqrt(square), 1e-3 * goal);
  }
}

// The factor by which the change of the result falls when the step is halved once more, for a beam
// that swings far. The damping (s) limits the steps of verlet.
double ratio_of_changes(const std::string& name, double step, const std::string& damping) {
  const auto state = [&](const Overrides& options) {
    return SimulatedCase(beam(6, clamp, "stiffness_damping = " + damping + "\n"), options)
        .advance_to(0.5);
  };
  const auto halved = [&](int times) {
    return state(method(name, {key("step", std::ldexp(step, -times))}));
  };
  const std::vector<double> first = halved(0), second = halved(1), third = halved(2);
  const std::vector<double> exact =
      state({"time.relative_tolerance=1e-7", "time.position_tolerance=1e-8"});
  EXPECT_LT(position_difference(third, exact), 2e-3) << name;
  return position_difference(first, second) / position_difference(second, third);
}

TEST(ShellMotion, StepsConvergeWithTheirOrder) {
  EXPECT_NEAR(ratio_of_changes("euler", 1.0 / 512, "2e-3"), 2, 0.25);
  EXPECT_NEAR(ratio_of_changes("implicit_midpoint", 1.0 / 128, "2e-3"), 4, 0.6);
  EXPECT_NEAR(ratio_of_changes("verlet", 1.0 / 8192, "2e-6"), 4, 0.6);
}

TEST(ShellMotion, TolerancesAreKept) {
  const auto state = [](const std::string& name, double tolerance) {
    return SimulatedCase(beam(6, clamp), method(name, {key("relative_tolerance", tolerance),
                                                       key("position_tolerance", 0.1 * tolerance)}))
        .advance_to(0.5);
  };
  const std::vector<double> exact = state("cvode", 1e-9);
  for (const char* name : {"cvode", "arkode"}) {
    double last = 1;
    for (const double tolerance : {1e-3, 1e-5, 1e-7}) {
      const double error = position_difference(state(name, tolerance), exact);
      EXPECT_LT(error, 0.3 * last) << name << ' ' << tolerance;
      // Undamped, the errors of some thousand steps add up.
      EXPECT_LT(error, 200 * tolerance) << name;
      last = error;
    }
  }
}

// A steel plate that swings far, without damping. Steps of order p go with the (p+1)-th root of the
// tolerance, and errors with its power p / (p + 1).
TEST(ShellMotion, ErrorsFallWithTheToleranceByEveryMethod) {
  const auto positions = [](const std::string& name, double tolerance) {
    Simulation plate(build_scene(
        read_case(WEFT_CASES_DIR "/plucked_plate.toml",
                  method(name, {"time.duration=0.1", key("position_tolerance", tolerance),
                                key("relative_tolerance", 10 * tolerance)}))));
    std::vector<std::vector<Vec3>> frames;
    for (const double time : {0.05, 0.1}) {
      if (const auto failure = plate.advance(time - plate.time())) ADD_FAILURE() << failure->text;
      frames.push_back(plate.position("plate"));
    }
    return frames;
  };
  const auto exact = positions("cvode", 1e-8);
  const auto error_of = [&](const std::string& name, double tolerance) {
    const auto found = positions(name, tolerance);
    double largest = 0;
    for (std::size_t frame = 0; frame < exact.size(); ++frame) {
      for (std::size_t i = 0; i < exact[frame].size(); ++i)
        largest = std::max(largest, (found[frame][i] - exact[frame][i]).norm());
    }
    return largest;
  };
  struct Ladder {
    const char* name;
    double loose, order;
  };
  for (const auto& [name, loose, order] :
       {Ladder{"cvode", 1e-5, 2}, Ladder{"arkode", 1e-4, 2}, Ladder{"euler", 1e-4, 1}}) {
    const double coarse = error_of(name, loose), fine = error_of(name, loose / 100);
    // Rounding changes the steps of cvode, and the finer error by up to a third.
    EXPECT_GT(coarse / fine, 0.3 * std::pow(100, order / (order + 1))) << name << ' ' << coarse;
    EXPECT_GT(fine, 1e-7) << name;  // the reference is exact enough
  }
}

// Without damping the energy of a large swing stays.
TEST(ShellMotion, KeepsItsEnergy) {
  const auto drift = [](const Overrides& options, double duration) {
    SimulatedCase sim(beam(8, clamp), options);
    const double start = sim.energy(0, sim.dynamics().initial_state());
    const std::vector<double> y = sim.advance_to(duration);
    const Energies now = sim.dynamics().energies(duration, y);
    return std::abs(now.total() - start) / now.kinetic;
  };
  EXPECT_LT(drift(method("verlet"), 1.3), 1e-2);
  EXPECT_LT(
      drift(method("cvode", {"time.relative_tolerance=1e-7", "time.position_tolerance=1e-8"}), 1.3),
      1e-3);
}

// A step of verlet beyond the limit of stability is refused, and the limit is that of M^-1 K.
TEST(ShellMotion, VerletKnowsItsLongestStep) {
  SimulatedCase sim(beam(8, clamp), method("verlet"));
  ASSERT_FALSE(sim.integrator().step());
  const double chosen = sim.integrator().last_step();
  SimulatedCase shorter(beam(8, clamp), method("verlet", {key("step", 4.5 * chosen)}));
  EXPECT_FALSE(shorter.integrator().step());
  SimulatedCase longer(beam(8, clamp), method("verlet", {key("step", 5.5 * chosen)}));
  const auto failure = longer.integrator().step();
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->kind, Failure::Kind::unstable);
}

TEST(ShellMotion, HasTheSameBitsOnAnyNumberOfThreadsAndAfterRestoring) {
  const auto positions = [](const Overrides& options, bool restored) {
    const std::string text = beam(19, shaken, "mass_damping = 1\n");
    Simulation first(build_scene(parse_case(text, "test.toml", options)));
    EXPECT_FALSE(first.advance(0.02));
    if (!restored) {
      EXPECT_FALSE(first.advance(0.02));
      return first.position("beam");
    }
    Simulation second(build_scene(parse_case(text, "test.toml", options)));
    second.restore(first.save());
    EXPECT_FALSE(second.advance(0.02));
    return second.position("beam");
  };
  for (const char* step : {"time.step=2e-3", "time.step=5e-4"}) {
    const auto one = positions(method("euler", {step, "compute.threads=1"}), false);
    EXPECT_EQ(one, positions(method("euler", {step, "compute.threads=3"}), false));
    EXPECT_EQ(one, positions(method("euler", {step, "compute.threads=1"}), true));
  }
}

}  // namespace
}  // namespace weft::sim::shell_motion_test
