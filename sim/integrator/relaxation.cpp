#include "sim/integrator/relaxation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/case/membrane_stiffness.h"
#include "sim/motion/tolerances.h"

namespace weft::sim {

namespace {

// First pseudo-step (s): short against the period with which hanging cloth swings.
constexpr double first_pseudo_step = 0.05;
constexpr double longest_pseudo_step = 1e4;    // s
constexpr double shortest_pseudo_step = 1e-6;  // s
// Longest pseudo-step h, times the highest frequency w of the bodies. K has no stiffness against
// motions of a free body as a whole, only rounding errors, which are 1e-16 (h w)^2 times M in the
// matrix M + h^2 K. Linear solves begin to fail where these exceed M.
constexpr double longest_in_vibrations = 1e7;
// Shortest pseudo-step (s) after which a search may end.
constexpr double shortest_last_step = 1;
// Pseudo-step that judges an equilibrium, times the frequency at which the applied acceleration
// swings bodies of their size. A force that a pseudo-step of this length does not show accelerates
// particles by less than 1e-6 position_tolerance / size of the applied acceleration.
constexpr double judging_periods = 1e3;
// Smallest fraction of the judging step that is long enough: the estimate of the highest frequency,
// which limits it, varies from matrix to matrix.
constexpr double long_enough = 0.9;
// Factor by which a pseudo-step grows after one whose correction was not shortened.
constexpr double growth = 5;
// Limit of pseudo-steps per load. It does not shrink with the load: under any load, hanging cloth
// may have to rotate all the way towards gravity.
constexpr int most_pseudo_steps = 600;
// Limit of pseudo-steps at full stiffness before bodies are softened. A hanging sheet takes some 30
// to 100 pseudo-steps. If it takes more, its stiffness slows the search.
constexpr int patience = 100;
// Largest residual acceleration at rest (mass-weighted RMS) as a fraction of the applied
// acceleration: at full stiffness, and with softened bodies.
constexpr double stiff_fraction = 1e-4, softened_fraction = 1e-2;
// Relative error of a rounded position, with what its stretched neighbours add.
constexpr double position_rounding = 2 * std::numeric_limits<double>::epsilon();
// In the softest stage, the membrane that is stiffest relative to its weight has a stiffness (N/m)
// of `softest` times its weight per width. One factor softens all bodies. Each later stage
// multiplies the factor by `hardening`, up to 1.
constexpr double softest = 100, hardening = 10;
// Accuracy of the linear solve for a direction: relative error in the norm of the matrix.
constexpr VelocitySystem::Goal linear_goal{.error = 1e-2,
                                           .scale = VelocitySystem::Goal::Scale::matrix};
// Largest error of the correction that judges an equilibrium, relative to position_tolerance. The
// matrix is at least M. Its norm would hide the error of a light load beside a heavy one.
constexpr double judged_error = 0.1;
constexpr double smallest_fraction = 1e-6;  // smallest fraction of a correction that is tried
// Number of pseudo-steps after an indefinite exact matrix until the exact matrix is tried again.
constexpr int exact_interval = 4;

}  // namespace

double applied_acceleration(Dynamics& dynamics, double time, std::span<const double> y) {
  std::vector<Vec3> force(dynamics.particle_count());
  dynamics.applied_loads(time, y, true, force);
  double sum = 0, mass = 0;
  for (std::size_t i = 0; i < force.size(); ++i) {
    sum += force[i].squaredNorm() / dynamics.scene().mass[i];
    mass += dynamics.scene().mass[i];
  }
  return std::sqrt(sum / mass);
}

Relaxation::Relaxation(const Scene& scene, Dynamics& dynamics)
    : scene_(scene),
      dynamics_(dynamics),
      system_(dynamics),
      rate_(dynamics.state_size()),
      right_(dynamics.state_size()),
      correction_(dynamics.state_size()),
      reached_(dynamics.state_size()),
      weight_(dynamics.state_size(), 1.0) {
  if (dynamics.contact() != nullptr) dynamics.contact()->keep_matrix_definite();
  for (const double mass : scene.mass) mass_ += mass;
  Eigen::AlignedBox3d box;
  for (int i = 0; i < scene.dynamic_particles; ++i) box.extend(scene.initial_position[i]);
  size_ = box.isEmpty() ? 0 : box.diagonal().norm();
}

int Relaxation::worst_particle() const { return sim::worst_particle(rate_, weight_); }

// Relaxes the bodies at full stiffness. If the search is slow and bodies can be softened, it
// continues with softened bodies, whose stiffness increases in stages to its full value. Slack
// stiff bodies rotate by a small angle per pseudo-step, because straight paths stretch them.
// Softened bodies rotate by large angles. Softened and stiff bodies reach nearly the same
// equilibrium: it differs only by their stretch.
Relaxation::End Relaxation::relax(const Goal& goal, std::span<double> y, SafePath& path) {
  goal_ = &goal;
  path_ = &path;
  pseudo_steps_ = indefinite_steps_ = 0;
  pseudo_step_ = first_pseudo_step;
  const double least = least_hardness();
  End end = descend_at(1, y, least < 1 ? patience : most_pseudo_steps);
  if (end == End::slow && least < 1) {
    end = End::at_rest;
    for (double hardness = least; end == End::at_rest; hardness *= hardening) {
      end = descend_at(std::min(hardness, 1.0), y, most_pseudo_steps);
      if (hardness >= 1) break;
    }
  }
  dynamics_.set_hardness(1);
  return end;
}

// Takes pseudo-steps until the forces balance. Ends earlier if pseudo-steps of any length fail, if
// the search should stop, or if it has taken `most_steps` pseudo-steps in all stages. Near rest, an
// exact pseudo-step shows whether the state is an equilibrium: the others have errors that hide the
// motion of bodies whose forces are small.
Relaxation::End Relaxation::descend_at(double hardness, std::span<double> y, int most_steps) {
  dynamics_.set_hardness(hardness);
  fault_ = dynamics_.rate(goal_->time, y, rate_);
  if (fault_) return End::blocked;
  const bool approaches = hardness < 1 || goal_->approaches;
  is_exact_ = false;
  while (pseudo_steps_ < most_steps && !goal_->should_stop()) {
    ++pseudo_steps_;
    fault_.reset();
    const bool is_solved = find_direction(y);
    const double taken = is_solved ? take_correction(y) : 0;
    // At an equilibrium, rounding decides which part of a correction is taken. There the whole
    // correction is judged.
    const bool is_judged = taken == 1 || (is_solved && !approaches);
    const bool is_near = is_judged && is_near_rest(y, hardness < 1, approaches);
    if (is_near && (is_exact_ || approaches)) return End::at_rest;
    is_exact_ = is_near;
    if (is_near) {
      pseudo_step_ = judging_step(approaches);
    } else if (taken == 0) {
      pseudo_step_ /= 4;
      if (pseudo_step_ < shortest_pseudo_step) return fault_ ? End::blocked : End::stuck;
    } else {
      pseudo_step_ = taken == 1 ? std::min(growth * pseudo_step_, longest_useful_step())
                                : std::max(taken, 0.3) * pseudo_step_;
    }
  }
  return End::slow;
}

// Computes the correction of one pseudo-step h: (M + h D + h^2 K) dv = h F, dx = h dv. If conjugate
// gradients find the exact K indefinite, a semi-definite K replaces it, in this and in the next
// pseudo-steps (`exact_interval`). An exact pseudo-step also takes what a solve has reached within
// its limit of iterations: that is more than other pseudo-steps ask for.
bool Relaxation::find_direction(std::span<const double> y) {
  ++newton_iterations_;
  const double h = pseudo_step_;
  const std::size_t half = y.size() / 2;
  std::fill_n(right_.begin(), half, 0.0);
  for (std::size_t i = half; i < y.size(); ++i) right_[i] = h * rate_[i];
  if (indefinite_steps_ % exact_interval == 0) {
    const VelocitySystem::Outcome outcome = solve(y, Definiteness::exact);
    indefinite_steps_ = outcome.indefinite ? 1 : 0;
    if (!outcome.indefinite) return outcome.converged || is_exact_;
  } else {
    ++indefinite_steps_;
  }
  const VelocitySystem::Outcome outcome = solve(y, Definiteness::semi_definite);
  return outcome.converged || (is_exact_ && !outcome.indefinite);
}
VelocitySystem::Outcome Relaxation::solve(std::span<const double> y, Definiteness definiteness) {
  dynamics_.assemble(goal_->time, y, definiteness);
  PhaseTimer timer(dynamics_.statistics().phases.linear_solve);
  system_.set_up(pseudo_step_);
  const double move = judged_error * scene_.source.time.position_tolerance;
  const VelocitySystem::Goal exact_goal{.residual = move / pseudo_step_};
  const VelocitySystem::Outcome outcome = system_.solve(
      pseudo_step_, right_, weight_, is_exact_ ? exact_goal : linear_goal, correction_);
  linear_iterations_ += outcome.iterations;
  return outcome;
}

// Moves `y` along the correction, shortened until surfaces stay apart and pull() at its end is at
// least -1/2 of pull() at its start. Returns the fraction taken. If no fraction is accepted,
// returns 0 and restores `y` and rate_. The test uses the work of the forces, not their size. A
// straight path stretches a rotating body, and the forces of a stiff body grow long before its
// energy does.
double Relaxation::take_correction(std::span<double> y) {
  std::copy(y.begin(), y.end(), reached_.begin());
  const double start = pull();
  for (double fraction = 1; fraction > smallest_fraction;) {
    for (std::size_t i = 0; i < y.size() / 2; ++i) y[i] = reached_[i] + fraction * correction_[i];
    fault_ = dynamics_.rate(goal_->time, y, rate_);
    const double now = fault_ ? 0 : pull();
    if (now < -0.5 * start) {
      // The restoring force grows with the cube of the distance.
      fraction *= std::clamp(std::cbrt(start / (start - now)), 0.1, 0.8);
    } else if (fault_ || !path_is_safe(y)) {
      fraction /= 2;
    } else {
      return fraction;
    }
  }
  std::copy(reached_.begin(), reached_.end(), y.begin());
  static_cast<void>(dynamics_.rate(goal_->time, y, rate_));
  return 0;
}

// Returns the work (J) that the present forces would do along the whole correction.
double Relaxation::pull() const {
  const StateView way = StateView::of(correction_), force = StateView::of(rate_);
  double sum = 0;
  for (std::size_t i = 0; i < way.position.size(); ++i)
    sum += scene_.mass[i] * way.position[i].dot(force.velocity[i]);
  return sum;
}

// Checks the path from the last accepted pseudo-step to `y`. If it is safe, the next path starts
// at `y`.
bool Relaxation::path_is_safe(std::span<const double> y) {
  fault_ = path_->move_to(goal_->time, y);
  return !fault_;
}

// Returns the length (s) beyond which a pseudo-step only loses digits. Precondition: matrices have
// been assembled.
double Relaxation::longest_useful_step() {
  return std::min(longest_pseudo_step, longest_in_vibrations / system_.highest_frequency());
}

// Returns the length (s) of the pseudo-steps that judge whether the state is an equilibrium.
// Precondition: matrices have been assembled.
double Relaxation::judging_step(bool approaches) {
  const double longest = longest_useful_step();
  if (goal_->acceleration == 0) return longest;
  const double period = approaches ? 0 : std::sqrt(size_ / goal_->acceleration);
  return std::min(std::max(shortest_last_step, judging_periods * period), longest);
}

// True if the pseudo-step is about as long as judging_step(), and the residual forces are small.
// At full stiffness, the last correction must also move no particle by more than
// time.position_tolerance. Without applied forces, the residual is not judged.
bool Relaxation::is_near_rest(std::span<const double> y, bool softened, bool approaches) {
  if (pseudo_step_ < long_enough * judging_step(approaches)) return false;
  if (!softened) {
    double largest_move = 0;
    for (const Vec3& way : StateView::of(correction_).position)
      largest_move = std::max(largest_move, way.norm());
    if (largest_move > scene_.source.time.position_tolerance) return false;
  }
  if (goal_->acceleration == 0) return true;
  const double fraction = softened ? softened_fraction : stiff_fraction;
  return residual_acceleration(y) <= fraction * goal_->acceleration;
}

// Returns the root mean square, weighted by mass, of the residual accelerations of `y`, without
// what rounded positions may cause: stiff springs, such as supports of pins with axes, turn the
// rounding errors of positions into forces that no correction removes. Preconditions: rate_ belongs
// to `y`, and matrices have been assembled.
double Relaxation::residual_acceleration(std::span<const double> y) const {
  const std::span<const Vec3> position = StateView::of(y).position;
  const std::span<const Vec3> acceleration = StateView::of(rate_).velocity;
  double sum = 0;
  for (std::size_t i = 0; i < acceleration.size(); ++i) {
    const double stiffness = dynamics_.stiffness().diagonal_block(static_cast<int>(i)).norm();
    const double rounding = position_rounding * stiffness * position[i].norm() / scene_.mass[i];
    const double left = std::max(acceleration[i].norm() - rounding, 0.0);
    sum += scene_.mass[i] * left * left;
  }
  return std::sqrt(sum / mass_);
}

// Returns the factor of the stiffness, at most 1, at which the stiffest membrane would stretch by 1
// / `softest` under the weight that its mass has at goal_->acceleration. Returns 1 if that is zero.
double Relaxation::least_hardness() const {
  double hardness = 1;
  for (int b = 0; b < scene_.dynamic_bodies; ++b) {
    const SceneBody& body = scene_.bodies[b];
    const MaterialCase& material = *body.material;
    if (material.is_shell()) continue;  // only membranes and springs can be softened
    Eigen::AlignedBox3d box;
    for (const Vec3& x : body.rest) box.extend(x);
    const double weight = material.density * goal_->acceleration * box.diagonal().norm();
    const double stiffness = largest_membrane_stiffness(material);
    if (stiffness > 0) hardness = std::min(hardness, softest * weight / stiffness);
  }
  return hardness > 0 ? hardness : 1;
}

}  // namespace weft::sim
