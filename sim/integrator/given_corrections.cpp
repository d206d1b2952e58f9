// Implicit stages by a given number of corrections.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/base/parallel.h"
#include "sim/integrator/stage_solver_state.h"
#include "sim/motion/tolerances.h"
#include "sim/scene/sliding_supports.h"

namespace weft::sim {

namespace {

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

bool all_finite(std::span<const double> y) {
  double sum = 0;
  for (double value : y) sum += value - value;
  return sum == 0;
}

}  // namespace

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
                       .from_guess = solves > 1,
                       .keeps_momentum = true},
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

}  // namespace weft::sim
