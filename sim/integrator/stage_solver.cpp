#include "sim/integrator/stage_solver.h"

#include <kinsol/kinsol.h>
#include <kinsol/kinsol_ls.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/integrator/stage_solver_state.h"
#include "sim/integrator/vector_operations.h"
#include "sim/motion/tolerances.h"

namespace weft::sim {

namespace {

// Relative error allowed in the linear solves if corrections follow until convergence. A larger
// error takes more corrections.
constexpr double linear_error = 3e-2;

// Limit of convergence: the iteration ends once no weighted component of the last correction, or of
// the residual, exceeds it.
constexpr double largest_last_correction = 0.3;

// KINSOL measures corrections relative to |u| + 1 / uscale. With this small scale, 1 / uscale
// dominates, and results do not depend on the origin.
constexpr double scale_of_corrections = 1e-9;

// Limit of corrections with a line search. A stage that takes more of them costs more than two
// stages of half the step.
constexpr int largest_newton_count = 20;

// Limit of full corrections. After 12 of them, convergence is unlikely.
constexpr int most_whole_corrections = 12;

// Limit of the number of times that a correction is halved. Beyond it, a shorter step is cheaper.
constexpr int most_cuts = 8;

}  // namespace

void StageSolver::Implementation::create() {
  if (dynamics.contact() != nullptr) dynamics.contact()->keep_matrix_definite();
  if (newton_count > 0) {
    system.emplace(dynamics);
    for (auto* vector : {&right, &solution, &weight}) vector->resize(dynamics.state_size());
    return;
  }
  SUNContext_Create(nullptr, &context);
  u = make_vector(static_cast<sunindextype>(dynamics.state_size()), dynamics.threads(), context);
  step_scale = N_VClone(u);
  residual_scale = N_VClone(u);
  if (dynamics.contact() != nullptr) trial.resize(dynamics.state_size());
  kinsol = KINCreate(context);
  KINSetErrHandlerFn(
      kinsol, [](int, const char*, const char*, char*, void*) {}, nullptr);
  KINSetUserData(kinsol, this);
  KINInit(
      kinsol,
      [](N_Vector state, N_Vector out, void* self) {
        return static_cast<Implementation*>(self)->residual(values(state), values(out));
      },
      u);
  newton_solver =
      make_newton_solver(dynamics,
                         {.gamma = [this] { return gamma; },
                          .goal = VelocitySystem::Goal{.error = linear_error},
                          .make_definite = [this] { return make_definite(); },
                          .limit = [this](std::span<double> correction) { limit(correction); }},
                         context);
  KINSetLinearSolver(kinsol, newton_solver, nullptr);
  // KINSOL calls the setup function only if there is a solve function, too. The latter is never
  // called.
  KINSetPreconditioner(
      kinsol,
      [](N_Vector state, N_Vector, N_Vector, N_Vector, void* self) {
        return static_cast<Implementation*>(self)->assemble(values(state));
      },
      [](N_Vector, N_Vector, N_Vector, N_Vector, N_Vector, void*) { return 0; });
  KINSetJacTimesVecFn(kinsol, [](N_Vector, N_Vector out, N_Vector, booleantype*, void* self) {
    return static_cast<Implementation*>(self)->multiply_correction(values(out));
  });
  KINSetMaxSetupCalls(kinsol, 1);
  KINSetMaxNewtonStep(kinsol, 1 / scale_of_corrections);
  KINSetScaledStepTol(kinsol, largest_last_correction * scale_of_corrections);
  KINSetFuncNormTol(kinsol, largest_last_correction);
}

// Computes the residual r at y. Returns 1 if the forces cannot be evaluated. If a correction led to
// y, KINSOL then halves it.
int StageSolver::Implementation::residual(std::span<const double> y, std::span<double> r) {
  if (auto bad = dynamics.rate(time, y, r)) {
    fault = bad;
    return 1;
  }
  for (std::size_t i = 0; i < r.size(); ++i) r[i] = y[i] - gamma * r[i] - right_side[i];
  last_residual = r;
  return 0;
}

int StageSolver::Implementation::assemble(std::span<const double> state) {
  ++linear_setups;
  linearised_at = state;
  assemble_joined();
  return 0;
}

// Assembles the stiffness K and the damping D for the next linear system. Its right-hand side is
// minus the residual.
void StageSolver::Implementation::assemble_joined() {
  dynamics.assemble_joined(time, linearised_at,
                           definite ? Definiteness::semi_definite : Definiteness::exact, gamma,
                           StateView::of(last_residual).position);
}

bool StageSolver::Implementation::make_definite() {
  if (definite) return false;
  definite = true;
  assemble_joined();
  return true;
}

bool StageSolver::Implementation::path_is_safe(std::span<const double> state) {
  dynamics.expand(time, state, position, velocity);
  auto crossing = dynamics.check_path(start_time, *start, time, position);
  if (crossing) fault = crossing;
  return !crossing;
}

// Sets `y` to the guess a + gamma times the slope of the last stage, or to `a` if the slope is
// unknown. The error of the guess is of second order in the step. If it is within the tolerance,
// one iteration suffices. From `a` itself, the iteration could end after one correction with an
// error of first order. With contact the iteration starts at `a`, because the guess saves no time
// there.
void StageSolver::Implementation::guess(std::span<double> y) {
  std::copy(right_side.begin(), right_side.end(), y.begin());
  for (std::size_t i = 0; i < slope.size(); ++i) y[i] += gamma * slope[i];
  if (dynamics.pins_move()) guess_pins(y);
}

// Sets the positions and velocities of pins in `y` to their solution, which depends on no other
// unknown.
void StageSolver::Implementation::guess_pins(std::span<double> y) {
  const auto* const from = reinterpret_cast<const Vec3*>(right_side.data());
  auto* const to = reinterpret_cast<Vec3*>(y.data());
  const int count = scene.dynamic_particles;
  for (int i = 0; i < count; ++i) {
    if (scene.pinned[i] == 0) continue;
    to[i] = from[i];
    to[count + i] = from[count + i];
  }
  dynamics.advance_pins(time, gamma, y);
}

void StageSolver::Implementation::limit(std::span<double> correction) {
  shortened = false;
  kept_part = 1;
  if (dynamics.contact() == nullptr) return;
  for (int cuts = 0; cuts <= most_cuts; ++cuts) {
    const double fraction = std::ldexp(1.0, -cuts);
    for (std::size_t i = 0; i < trial.size(); ++i) {
      trial[i] = linearised_at[i] + fraction * correction[i];
    }
    if (!path_is_safe(trial)) continue;
    shortened = fraction < 1;
    kept_part = fraction;
    gap_change = dynamics.gap_change_since_evaluation(*start, position, closing_factor);
    if (!shortened) return;
    for (double& c : correction) c *= fraction;
    return;
  }
  shortened = true;
  kept_part = 0;
  gap_change = 0;
  std::fill(correction.begin(), correction.end(), 0.0);
}

// Computes the product of the Jacobian and the last correction, for KINSOL's line search. Since the
// correction solves the linear system, the product is minus the residual, scaled like the
// correction. KINSOL would otherwise form a finite difference with displacements of metres, because
// corrections are small. This would cost one evaluation of the forces per correction, and fail if
// it moved surfaces into each other.
int StageSolver::Implementation::multiply_correction(std::span<double> product) const {
  for (std::size_t i = 0; i < product.size(); ++i) product[i] = -kept_part * last_residual[i];
  return 0;
}

StageSolver::Outcome StageSolver::Implementation::outcome(int flag) const {
  switch (flag) {
    case KIN_SUCCESS:
    case KIN_INITIAL_GUESS_OK:
      return Outcome::solved;
    case KIN_STEP_LT_STPTOL:  // a cut correction may be short far from the solution
      return shortened ? Outcome::blocked : Outcome::solved;
    case KIN_MAXITER_REACHED:
      return shortened ? Outcome::blocked : Outcome::not_converged;
    case KIN_FIRST_SYSFUNC_ERR:
    case KIN_REPTD_SYSFUNC_ERR:
    case KIN_SYSFUNC_FAIL:
      return Outcome::blocked;
    default:
      return Outcome::not_converged;
  }
}

// Runs KINSOL from the start `u`, which receives the solution. A correction that is small but
// changes a gap by a large part is not the last one.
int StageSolver::Implementation::run_kinsol(int strategy) {
  for (int runs = 0; runs < most_whole_corrections; ++runs) {
    gap_change = 0;
    const int flag = KINSol(kinsol, u, strategy, step_scale, residual_scale);
    long newton = 0, linear = 0;
    KINGetNumNonlinSolvIters(kinsol, &newton);
    KINGetNumLinIters(kinsol, &linear);
    newton_iterations += newton;
    linear_iterations += linear;
    if (flag != KIN_STEP_LT_STPTOL || shortened || gap_change <= most_gap_change) return flag;
  }
  return KIN_MAXITER_REACHED;
}

StageSolver::Outcome StageSolver::Implementation::iterate(int strategy, int most_iterations) {
  KINSetNumMaxIters(kinsol, most_iterations);
  if (dynamics.contact() != nullptr) dynamics.contact()->begin_newton();
  int flag = run_kinsol(strategy);
  const bool is_good_guess = flag == KIN_INITIAL_GUESS_OK;
  if (is_good_guess) {
    // One correction is always made: small residuals of guesses would add up over many short steps.
    KINSetFuncNormTol(kinsol, std::numeric_limits<double>::min());
    flag = run_kinsol(strategy);
    KINSetFuncNormTol(kinsol, largest_last_correction);
  }
  return is_good_guess && shortened ? Outcome::solved : outcome(flag);
}

StageSolver::StageSolver(const Scene& scene, Dynamics& dynamics, int newton_count)
    : implementation_(std::make_unique<Implementation>(scene, dynamics, newton_count)) {
  implementation_->create();
}

StageSolver::~StageSolver() = default;

void StageSolver::set_stop(std::function<bool()> stop) {
  implementation_->velocity_system().set_stop(std::move(stop));
}

StageSolver::Outcome StageSolver::solve(double t, double gamma, std::span<const double> a,
                                        const std::vector<Vec3>& start, std::span<double> y) {
  Implementation& self = *implementation_;
  self.time = t;
  self.start_time = std::min(self.dynamics.step_start(), t);
  self.gamma = gamma;
  self.right_side = a;
  self.start = &start;
  self.definite = self.newton_count > 0;
  self.shortened = false;
  self.fault.reset();
  if (self.newton_count > 0) {
    std::copy(a.begin(), a.end(), y.begin());
    if (self.dynamics.pins_move()) self.guess_pins(y);
    const Outcome outcome = self.iterate_by_number(y);
    if (self.dynamics.contact() != nullptr) {
      self.dynamics.contact()->clear_stops();
      self.dynamics.contact()->end_newton();
    }
    return outcome;
  }
  const std::span<double> u = values(self.u);
  error_weights(self.scene, a, values(self.residual_scale));
  N_VScale(scale_of_corrections, self.residual_scale, self.step_scale);
  self.guess(u);
  // Full corrections come first. Stiff cloth rotates along straight lines: one correction stretches
  // it, and the next one pulls it back. The residual between the two is far larger, so a line
  // search would allow only tiny corrections.
  Outcome outcome = self.iterate(KIN_NONE, most_whole_corrections);
  if (outcome == Outcome::not_converged) {
    std::copy(a.begin(), a.end(), u.begin());
    if (self.dynamics.pins_move()) self.guess_pins(u);
    outcome = self.iterate(KIN_LINESEARCH, largest_newton_count);
  }
  if (outcome != Outcome::solved) {
    self.slope.clear();
    return outcome;
  }
  std::copy(u.begin(), u.end(), y.begin());
  if (self.dynamics.contact() != nullptr) return outcome;
  self.slope.resize(y.size());
  for (std::size_t i = 0; i < y.size(); ++i) self.slope[i] = (y[i] - a[i]) / gamma;
  return outcome;
}

const std::optional<ContactFault>& StageSolver::fault() const { return implementation_->fault; }

int StageSolver::worst_particle() const {
  Implementation& self = *implementation_;
  if (self.last_residual.empty()) return 0;
  const StateView residual = StateView::of(self.last_residual);
  const StateView weight = StateView::of(
      self.kinsol == nullptr ? std::span<const double>(self.weight) : values(self.residual_scale));
  int worst = 0;
  double largest = -1;
  for (std::size_t i = 0; i < residual.velocity.size(); ++i) {
    const double size = residual.velocity[i].cwiseProduct(weight.velocity[i]).squaredNorm();
    if (size <= largest) continue;
    largest = size;
    worst = static_cast<int>(i);
  }
  return worst;
}

void StageSolver::forget() { implementation_->slope.clear(); }

void StageSolver::transfer(StateArchive& archive) {
  Implementation& self = *implementation_;
  archive(self.slope, self.newton_iterations, self.linear_iterations, self.linear_setups);
  self.velocity_system().transfer(archive);
}

void StageSolver::add_counts(IntegratorCounts& counts) const {
  counts.newton_iterations += implementation_->newton_iterations;
  counts.linear_iterations += implementation_->linear_iterations;
  counts.linear_setups += implementation_->linear_setups;
}

}  // namespace weft::sim
