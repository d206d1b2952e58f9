#include "sim/integrator/stage_solver.h"

#include <kinsol/kinsol.h>
#include <kinsol/kinsol_ls.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "sim/base/parallel.h"
#include "sim/integrator/newton_solver.h"
#include "sim/integrator/sundials_access.h"
#include "sim/integrator/vector_operations.h"
#include "sim/motion/external_work.h"
#include "sim/motion/tolerances.h"
#include "sim/scene/sliding_supports.h"
#include "sim/solver/velocity_system.h"

namespace weft::sim {

namespace {

// Relative error allowed in the linear solves if corrections follow until convergence. A larger
// error takes more corrections.
constexpr double linear_error = 3e-2;

// Relative error allowed in the linear solves if the number of corrections is given and gamma is at
// least `longest_gamma` (s). With a single correction, this linear error changes the error of steps
// of 1/60 s by 1 to 5 % (docs/benchmarks.md). For a shorter gamma, the allowed error is
// proportional to gamma: errors of short steps add up, and their sum must decrease with the step.
constexpr double linear_error_by_number = 0.1, longest_gamma = 1.0 / 60;

// Error that friction may leave in a sliding velocity in a step of `longest_gamma`, as a fraction
// of the velocity tolerance. It is proportional to gamma, too.
constexpr double friction_error = 0.1;

// Largest residual velocity of a particle after a given number of corrections, as a fraction of the
// fastest velocity. The velocity tolerance is added to it. A larger residual requires further
// corrections, up to `most_driven_corrections`. Both apply only with contact and prescribed motion
// (docs/decisions/0107).
constexpr double largest_driven_residual = 0.1;
constexpr int most_driven_corrections = 2;

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

// With contact, a step by a given number of corrections is too long if the largest stretch grows by
// more than `largest_stretch_growth`, or if motion and strain gain more energy than contact, wind,
// loads and motions give and `largest_gain` of the kinetic energy. Corrections move particles on
// straight lines: an edge that turns by the angle a in a step is stretched by a^2 / 2
// (docs/decisions/0080). Bodies that a motion turns are stretched so in every step, and gain no
// more by it: `largest_driven_gain` applies then.
constexpr double largest_stretch_growth = 0.03;
constexpr double largest_gain = 0.005, largest_driven_gain = 0.02;

// Steps shorter than this part of time.step are never too long: such a run must go on.
constexpr double shortest_judged = 1.0 / 16;

// Limit of the solves of one correction. All but the last are followed by new stops. If surfaces
// still meet after it, a shorter step is cheaper.
constexpr int most_solves = 12;

// Limit of the number of times that a correction is halved. Beyond it, a shorter step is cheaper.
constexpr int most_cuts = 8;

bool all_finite(std::span<const double> y) {
  double sum = 0;
  for (double value : y) sum += value - value;
  return sum == 0;
}

}  // namespace

struct StageSolver::Implementation {
  Implementation(const Scene& scene_, Dynamics& dynamics_, int newton_count_)
      : scene(scene_), dynamics(dynamics_), newton_count(newton_count_) {}
  ~Implementation() {
    if (kinsol == nullptr) return;
    KINFree(&kinsol);
    SUNLinSolFree(newton_solver);
    for (N_Vector v : {u, step_scale, residual_scale}) N_VDestroy(v);
    SUNContext_Free(&context);
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  void create();
  VelocitySystem& velocity_system() { return system ? *system : velocity_system_of(newton_solver); }
  int residual(std::span<const double> y, std::span<double> r);
  int assemble(std::span<const double> state);
  void assemble_joined();
  bool make_definite();
  void guess(std::span<double> y);
  void guess_pins(std::span<double> y);
  void limit(std::span<double> correction);
  int multiply_correction(std::span<double> product) const;
  bool path_is_safe(std::span<const double> state);
  Outcome outcome(int flag) const;
  Outcome iterate(int strategy, int most_iterations);
  bool is_driven() const;
  bool leaves_small_residual(std::span<const double> residual);
  bool can_compare_energies() const;
  double held_energy() const;
  double work_of_wind_and_loads(std::span<const double> y);
  bool is_too_long(std::span<const double> y);
  void subtract_accelerations(std::span<double> from);
  void add_stop_forces(std::span<const double> y);
  Outcome correct(std::span<double> y);
  bool add_stops(std::span<const double> y, int* added);
  bool correct_friction(std::span<const double> y);
  Outcome iterate_by_number(std::span<double> y);

  const Scene& scene;
  Dynamics& dynamics;
  int newton_count;
  // Replaces KINSOL and its linear solver if the number of iterations is given.
  std::optional<VelocitySystem> system;
  std::vector<double> right, solution, weight;
  std::vector<double> slope;  // (y - a) / gamma of the last stage; empty if unknown or with contact
  SUNContext context = nullptr;
  void* kinsol = nullptr;
  SUNLinearSolver newton_solver = nullptr;
  N_Vector u = nullptr, step_scale = nullptr, residual_scale = nullptr;
  std::int64_t newton_iterations = 0, linear_iterations = 0, linear_setups = 0;

  // The arguments of the present solve(): t (s), gamma (s), start of the step (s), `a` and `start`.
  double time = 0, gamma = 0, start_time = 0;
  std::span<const double> right_side;
  const std::vector<Vec3>* start = nullptr;
  bool definite = false, shortened = false;
  // Energies (J) at the start of a step by a given number of corrections with contact, those of
  // held particles, and the work of the step. `driven_work` is empty unless a motion has
  // moved particles.
  Energies before;
  double held_before = 0;
  std::optional<ExternalWork> driven_work;
  double kept_part = 1;  // fraction of the present correction that limit() kept
  // Views of the state of the last assembly, and of the last residual.
  std::span<const double> linearised_at, last_residual;
  std::vector<double> trial;
  std::vector<double> free_residual;  // residual without the forces of stops
  std::vector<Mat3> diagonal;         // of the linear system, without stops
  std::vector<Vec3> added_force;      // N, of stops, or by which friction changes
  std::vector<Vec3> displacement, change;
  std::vector<Vec3> position, velocity;
  std::optional<ContactFault> fault;
};

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
    if (!shortened) return;
    for (double& c : correction) c *= fraction;
    return;
  }
  shortened = true;
  kept_part = 0;
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

// Runs KINSOL from the start `u`, which receives the solution.
StageSolver::Outcome StageSolver::Implementation::iterate(int strategy, int most_iterations) {
  KINSetNumMaxIters(kinsol, most_iterations);
  if (dynamics.contact() != nullptr) dynamics.contact()->begin_newton();
  int flag = KINSol(kinsol, u, strategy, step_scale, residual_scale);
  const bool is_good_guess = flag == KIN_INITIAL_GUESS_OK;
  if (is_good_guess) {
    // One correction is always made: small residuals of guesses would add up over many short steps.
    KINSetFuncNormTol(kinsol, std::numeric_limits<double>::min());
    flag = KINSol(kinsol, u, strategy, step_scale, residual_scale);
    KINSetFuncNormTol(kinsol, largest_last_correction);
  }
  long newton = 0, linear = 0;
  KINGetNumNonlinSolvIters(kinsol, &newton);
  KINGetNumLinIters(kinsol, &linear);
  newton_iterations += newton;
  linear_iterations += linear;
  return is_good_guess && shortened ? Outcome::solved : outcome(flag);
}

// Returns true if a prescribed motion has moved particles since t = 0. What it has set in motion
// goes on sliding when it ends.
bool StageSolver::Implementation::is_driven() const {
  bool is_driven = false;
  const auto add = [&](const RigidMotion& motion, double radius) {
    is_driven = is_driven || motion.bounds(0, time, radius).travel > 0;
  };
  for (const PrescribedMotion& held : scene.prescribed)
    if (held.moves) add(held.motion, held.radius);
  for (const SceneBody& body : scene.bodies)
    if (body.supports) body.supports->visit_motions(add);
  return is_driven;
}

// Returns true if the residual velocities are small compared with the fastest velocity of the
// scene, prescribed ones included.
bool StageSolver::Implementation::leaves_small_residual(std::span<const double> residual) {
  dynamics.expand_all(time, right_side, position, velocity);
  double fastest = 0, largest = 0;
  for (const Vec3& v : velocity) fastest = std::max(fastest, v.squaredNorm());
  for (const Vec3& r : StateView::of(residual).velocity)
    largest = std::max(largest, r.squaredNorm());
  return std::sqrt(largest) <=
         velocity_tolerance(scene.source.time) + largest_driven_residual * std::sqrt(fastest);
}

// True if nothing that varies changes the sum of the energies, but what `driven_work` counts.
bool StageSolver::Implementation::can_compare_energies() const {
  return !dynamics.varies() && (driven_work || !dynamics.has_moving_points());
}

// Returns the energies (J) of particles with prescribed motion, which pins supply and absorb.
double StageSolver::Implementation::held_energy() const {
  return driven_work ? driven_work->held_kinetic_energy() + driven_work->held_gravitational_energy()
                     : 0;
}

// Returns the work (J) of wind and loads in a step that ends at `y`: of their power at its end,
// which is the largest if they accelerate the bodies. Drag in still air only takes energy.
double StageSolver::Implementation::work_of_wind_and_loads(std::span<const double> y) {
  const bool has_wind = dynamics.has_external_forces() && !scene.source.world.wind.is_zero();
  if (!has_wind && !dynamics.has_loads()) return 0;
  return gamma * std::max(dynamics.external_power(time, y), 0.0);
}

// True if the step to `y` stretches edges too much or gains energy. Precondition: the last
// evaluation of the forces was at `y`.
bool StageSolver::Implementation::is_too_long(std::span<const double> y) {
  if (!(gamma > shortest_judged * scene.source.time.step.value_or(INFINITY))) return false;
  dynamics.expand(time, y, position, velocity);
  if (dynamics.largest_stretch(position) >
      std::max(dynamics.largest_stretch(*start), 0.0) + largest_stretch_growth)
    return true;
  if (!can_compare_energies()) return false;
  double work = 0;
  if (driven_work) {
    driven_work->add_step(time, y);
    work = driven_work->work() + driven_work->doubt();
  } else {
    work = work_of_wind_and_loads(y);
  }
  const Energies after = dynamics.energies_at_last_rate(time, y);
  const double gain = (after.total() - after.contact - held_energy()) -
                      (before.total() - before.contact - held_before);
  const double given = std::max(before.contact - after.contact, 0.0) + work;
  const double total_mass =
      std::accumulate(scene.mass.begin(), scene.mass.begin() + scene.dynamic_particles, 0.0);
  const double error = std::sqrt(1.5 * total_mass) * velocity_tolerance(scene.source.time);
  const double part = driven_work ? largest_driven_gain : largest_gain;
  return gain > given + part * after.kinetic + error * (error + std::sqrt(after.kinetic));
}

// Subtracts the accelerations by `added_force`, which it replaces, times gamma from a residual.
void StageSolver::Implementation::subtract_accelerations(std::span<double> from) {
  dynamics.mass().solve(added_force);
  auto* const velocity_of = reinterpret_cast<Vec3*>(from.data()) + scene.dynamic_particles;
  for (int i = 0; i < scene.dynamic_particles; ++i) {
    if (scene.pinned[i] == 0) velocity_of[i] -= gamma * added_force[i];
  }
}

// Applies the stops of contact, and subtracts their accelerations times gamma from the residual.
void StageSolver::Implementation::add_stop_forces(std::span<const double> y) {
  Contact* const contact = dynamics.contact();
  if (contact == nullptr || !contact->has_stops()) return;
  added_force.assign(scene.dynamic_particles, Vec3::Zero());
  contact->apply_stops(StateView::of(y).velocity, added_force);
  subtract_accelerations(right);
}

// Makes stops for the surfaces that would meet on the way to `y`. Returns false if that fails.
bool StageSolver::Implementation::add_stops(std::span<const double> y, int* added) {
  dynamics.expand(time, y, position, velocity);
  auto bad = dynamics.add_stops(start_time, *start, time, position, gamma,
                                StateView::of(y).velocity, diagonal, added);
  if (bad) fault = bad;
  return !bad;
}

// Makes friction obey Coulomb's law at the solution of a correction to `y`, and subtracts the
// change of its accelerations times gamma from the residual. Returns false if that changes hardly
// any sliding velocity.
bool StageSolver::Implementation::correct_friction(std::span<const double> y) {
  const StateView from = StateView::of(y), to = StateView::of(solution);
  displacement.resize(scene.dynamic_particles);
  change.resize(scene.dynamic_particles);
  for (int i = 0; i < scene.dynamic_particles; ++i) {
    displacement[i] = to.position[i] - from.position[i];
    change[i] = to.velocity[i] - from.velocity[i];
  }
  added_force.assign(scene.dynamic_particles, Vec3::Zero());
  const double largest =
      dynamics.contact()->correct_friction({gamma, displacement, change}, added_force);
  const double allowed = friction_error * velocity_tolerance(scene.source.time) * gamma;
  if (!(longest_gamma * largest > allowed)) return false;
  subtract_accelerations(free_residual);
  return true;
}

// Adds one correction to `y`, whose residual is in `right`. With contact, surfaces that would meet
// on the way get stops, friction is corrected once, and the system is solved again.
StageSolver::Outcome StageSolver::Implementation::correct(std::span<double> y) {
  ++newton_iterations;
  static_cast<void>(assemble(y));
  PhaseTimer timer(dynamics.statistics().phases.linear_solve);
  system->set_up(gamma);
  const bool may_meet = dynamics.contact() != nullptr;
  if (may_meet) {
    diagonal.resize(scene.dynamic_particles);
    system->find_diagonal(diagonal);
    free_residual = right;
  }
  const int count = static_cast<int>(y.size());
  bool has_friction = false;  // of the end of the step
  for (int solves = 1;; ++solves) {
    add_stop_forces(y);
    parallel_chunks(count, dynamics.threads(), [&](int first, int last) {
      for (int i = first; i < last; ++i) right[i] = -right[i];
    });
    const VelocitySystem::Outcome linear =
        system->solve(gamma, right, weight,
                      {.error = linear_error_by_number * std::min(1.0, gamma / longest_gamma),
                       .from_guess = solves > 1},
                      solution);
    linear_iterations += linear.iterations;
    if (!linear.converged) return Outcome::not_converged;
    parallel_chunks(count, dynamics.threads(), [&](int first, int last) {
      for (int i = first; i < last; ++i) solution[i] += y[i];
    });
    int added = 0;
    if (may_meet && solves < most_solves && !add_stops(solution, &added)) return Outcome::blocked;
    if (added == 0) {
      if (!may_meet || has_friction || !correct_friction(y)) break;
      has_friction = true;
    }
    std::copy(free_residual.begin(), free_residual.end(), right.begin());
    // Stops act locally, so that the solution without them is a good guess.
    parallel_chunks(count, dynamics.threads(), [&](int first, int last) {
      for (int i = first; i < last; ++i) solution[i] -= y[i];
    });
  }
  std::copy(solution.begin(), solution.end(), y.begin());
  return Outcome::solved;
}

// Applies the given number of corrections to `y`. With contact and prescribed motion, up to
// `most_driven_corrections` follow while the residual is large: what a pin pulls turns and
// stretches by more in a step than what moves by itself. After the last one, energy alone decides.
StageSolver::Outcome StageSolver::Implementation::iterate_by_number(std::span<double> y) {
  error_weights(scene, y, weight);
  const bool has_contact = dynamics.contact() != nullptr;
  driven_work.reset();
  if (has_contact && is_driven()) {
    driven_work.emplace(dynamics, right_side, start_time);
    before = dynamics.energies(start_time, right_side);
  }
  held_before = held_energy();
  if (has_contact) {
    dynamics.contact()->clear_stops();
    dynamics.contact()->begin_newton(gamma);
  }
  const int most = newton_count + (driven_work ? most_driven_corrections : 0);
  for (int corrections = 0;; ++corrections) {
    const bool is_enough = corrections >= newton_count;
    // With contact, the forces after the last correction are evaluated, too. They reveal surfaces
    // that this correction moved into each other.
    if (is_enough && !has_contact && all_finite(y)) return Outcome::solved;
    if (residual(y, right) != 0) return Outcome::blocked;
    if (has_contact && !driven_work && corrections == 0)
      before = dynamics.energies_at_last_rate(time, y);
    if (is_enough) {
      free_residual = right;
      if (corrections < most) add_stop_forces(y);
      if (corrections >= most || leaves_small_residual(right))
        return is_too_long(y) ? Outcome::not_converged : Outcome::solved;
      right = free_residual;
    }
    if (const Outcome outcome = correct(y); outcome != Outcome::solved) return outcome;
  }
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
