#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "sim/integrator/integrator_makers.h"
#include "sim/integrator/one_step_integrator.h"
#include "sim/motion/tolerances.h"
#include "sim/solver/velocity_system.h"

namespace weft::sim {

namespace {

// A pseudo-step is one Newton iteration of backward Euler from rest. Short ones follow the forces;
// long ones are Newton's method for the equilibrium.
constexpr double first_pseudo_step = 0.05;     // s; cloth swings in some tenths of a second
constexpr double longest_pseudo_step = 1e4;    // s
constexpr double shortest_pseudo_step = 1e-6;  // s
constexpr double newton_step = 1;  // s; from here on the correction measures the distance left
constexpr double growth = 5;       // after a step that was not shortened
// Limit of pseudo-steps per load, however small the load: hanging cloth may have to rotate all the
// way towards gravity. A smaller load would start over.
constexpr int most_pseudo_steps = 600;
// Limit of pseudo-steps at full stiffness before bodies are softened. A hanging sheet takes some 30
// to 100; beyond that, its stiffness slows it down.
constexpr int patience = 100;
// Residual acceleration at rest (mass-weighted RMS) as a fraction of gravity, at full stiffness and
// with softened bodies.
constexpr double residual_fraction = 1e-4, softened_fraction = 1e-2;
// Softening starts at a stiffness of `softest` times the weight of the body per width. Each stage
// multiplies it by `hardening`.
constexpr double softest = 100, hardening = 10;
// Accuracy of the linear solve for a direction: relative error in the norm of the matrix.
constexpr VelocitySystem::Goal linear_goal{.error = 1e-2,
                                           .scale = VelocitySystem::Goal::Scale::matrix};
constexpr double shortest_fraction = 1e-6;  // of a step
// Number of pseudo-steps after an indefinite exact matrix before the next exact one is tried.
constexpr int exact_interval = 4;

class StaticIntegrator final : public OneStepIntegrator {
 public:
  StaticIntegrator(const Scene& scene, Dynamics& dynamics)
      : OneStepIntegrator(scene, dynamics),
        system_(dynamics),
        rate_(dynamics.state_size()),
        right_(dynamics.state_size()),
        correction_(dynamics.state_size()),
        reached_(dynamics.state_size()),
        weight_(dynamics.state_size(), 1.0),
        gravity_(scene.source.world.gravity.constant().norm()) {
    if (dynamics.contact() != nullptr) dynamics.contact()->keep_matrix_definite();
    for (const double mass : scene.mass) mass_ += mass;
  }

  int last_order() const override { return 0; }
  bool transfer(StateArchive& archive) override {
    transfer_steps(archive);
    archive(newton_iterations_, linear_iterations_);
    system_.transfer(archive);
    return true;
  }
  IntegratorCounts counts() const override {
    IntegratorCounts counts = OneStepIntegrator::counts();
    counts.newton_iterations = newton_iterations_;
    counts.linear_iterations = linear_iterations_;
    counts.linear_setups = newton_iterations_;
    return counts;
  }

 private:
  bool checks_its_own_path() const override { return true; }

  // Relaxes the bodies at full stiffness. If that is slow, it relaxes them again, from softened to
  // full stiffness. Slack stiff bodies rotate by a small angle per pseudo-step, because straight
  // paths stretch them. Softened bodies rotate by large angles. Both reach the same place except
  // for their stretch.
  Trouble attempt(double& end, std::span<double> y) override {
    dynamics().set_load(end / scene().source.time.duration);
    const auto half = static_cast<std::ptrdiff_t>(y.size() / 2);
    std::copy(state().begin(), state().begin() + half, y.begin());
    std::fill(y.begin() + half, y.end(), 0.0);
    from_ = positions();
    from_time_ = time();
    pseudo_steps_ = indefinite_steps_ = 0;
    pseudo_step_ = first_pseudo_step;
    const double least = least_hardness();
    Progress progress = relax(end, y, 1, least < 1 ? patience : most_pseudo_steps);
    if (progress == Progress::slow && least < 1) {
      progress = Progress::at_rest;
      for (double hardness = least; progress == Progress::at_rest; hardness *= hardening) {
        progress = relax(end, y, std::min(hardness, 1.0), most_pseudo_steps);
        if (hardness >= 1) break;
      }
    }
    switch (progress) {
      case Progress::at_rest:
        return Trouble::none;
      case Progress::blocked:
        return Trouble::surfaces;
      case Progress::slow:
      case Progress::stuck:
        end = time();
    }
    dynamics().set_hardness(1);
    set_fault({});
    set_place(worst_particle(rate_, weight_));
    return Trouble::not_converged;
  }

  enum class Progress { at_rest, slow, stuck, blocked };
  // Takes pseudo-steps until the forces balance or the load has taken `most_steps`.
  Progress relax(double end, std::span<double> y, double hardness, int most_steps) {
    dynamics().set_hardness(hardness);
    set_fault(dynamics().rate(end, y, rate_));
    if (fault()) return Progress::blocked;
    const double fraction = hardness < 1 ? softened_fraction : residual_fraction;
    while (pseudo_steps_ < most_steps && !should_stop()) {
      ++pseudo_steps_;
      set_fault({});
      const double taken = find_direction(end, y) ? descend(end, y) : 0;
      if (taken == 0) {
        pseudo_step_ /= 4;
        if (pseudo_step_ < shortest_pseudo_step)
          return fault() ? Progress::blocked : Progress::stuck;
        continue;
      }
      if (taken == 1 && is_at_rest(fraction, hardness < 1)) return Progress::at_rest;
      pseudo_step_ = taken == 1 ? std::min(growth * pseudo_step_, longest_pseudo_step)
                                : std::max(taken, 0.3) * pseudo_step_;
    }
    return Progress::slow;
  }

  // Solves (M + h^2 K) dv = h F, dx = h dv. If conjugate gradients find the exact K indefinite, K
  // is made semi-definite, here and in the next pseudo-steps.
  bool find_direction(double end, std::span<const double> y) {
    ++newton_iterations_;
    const double h = pseudo_step_;
    const std::size_t half = y.size() / 2;
    std::fill_n(right_.begin(), half, 0.0);
    for (std::size_t i = half; i < y.size(); ++i) right_[i] = h * rate_[i];
    if (indefinite_steps_ % exact_interval == 0) {
      const VelocitySystem::Outcome outcome = solve(end, y, Definiteness::exact);
      indefinite_steps_ = outcome.indefinite ? 1 : 0;
      if (!outcome.indefinite) return outcome.converged;
    } else {
      ++indefinite_steps_;
    }
    return solve(end, y, Definiteness::semi_definite).converged;
  }
  VelocitySystem::Outcome solve(double end, std::span<const double> y, Definiteness definiteness) {
    dynamics().assemble(end, y, definiteness);
    PhaseTimer timer(dynamics().statistics().phases.linear_solve);
    system_.set_up(pseudo_step_);
    const VelocitySystem::Outcome outcome =
        system_.solve(pseudo_step_, right_, weight_, linear_goal, correction_);
    linear_iterations_ += outcome.iterations;
    return outcome;
  }

  // Takes the correction, shortened until the forces at its end push back by at most half of their
  // pull at its start. Returns the fraction taken. The work of the forces decides, not their size:
  // a straight path stretches a body that rotates, and the forces of a stiff body grow long before
  // its energy does. Returns 0 if no fraction is accepted; the last evaluation is then at `y`.
  double descend(double end, std::span<double> y) {
    std::copy(y.begin(), y.end(), reached_.begin());
    const double start = pull();
    for (double fraction = 1; fraction > shortest_fraction;) {
      for (std::size_t i = 0; i < y.size() / 2; ++i) y[i] = reached_[i] + fraction * correction_[i];
      set_fault(dynamics().rate(end, y, rate_));
      const double now = fault() ? 0 : pull();
      if (now < -0.5 * start) {
        // The push grows with the cube of the distance.
        fraction *= std::clamp(std::cbrt(start / (start - now)), 0.1, 0.8);
      } else if (fault() || !path_is_safe(end, y)) {
        fraction /= 2;
      } else {
        return fraction;
      }
    }
    std::copy(reached_.begin(), reached_.end(), y.begin());
    static_cast<void>(dynamics().rate(end, y, rate_));
    return 0;
  }

  // Returns the work (J) that the present forces would do along the whole correction.
  double pull() const {
    const StateView way = StateView::of(correction_), force = StateView::of(rate_);
    double sum = 0;
    for (std::size_t i = 0; i < way.position.size(); ++i)
      sum += scene().mass[i] * way.position[i].dot(force.velocity[i]);
    return sum;
  }

  // Checks the path from the last accepted pseudo-step to `y`. If it is safe, the next path starts
  // at `y`.
  bool path_is_safe(double end, std::span<const double> y) {
    if (dynamics().contact() == nullptr) return true;
    dynamics().expand(end, y, to_, scratch_);
    set_fault(dynamics().check_path(from_time_, from_, end, to_));
    if (fault()) return false;
    from_time_ = end;  // prescribed points have reached `end`
    from_.swap(to_);
    return true;
  }

  // Judges rest by the size of the forces and, at full stiffness, by the largest move of the last
  // Newton step.
  bool is_at_rest(double fraction, bool softened) const {
    if (pseudo_step_ < (gravity_ == 0 ? longest_pseudo_step : newton_step)) return false;
    if (!softened) {
      double largest_move = 0;
      for (const Vec3& way : StateView::of(correction_).position)
        largest_move = std::max(largest_move, way.norm());
      if (largest_move > scene().source.time.position_tolerance) return false;
    }
    if (gravity_ == 0) return true;
    const StateView left = StateView::of(rate_);
    double force = 0;
    for (std::size_t i = 0; i < left.velocity.size(); ++i)
      force += scene().mass[i] * left.velocity[i].squaredNorm();
    return std::sqrt(force / mass_) <= fraction * gravity_;
  }

  // Returns the factor of the stiffness at which the stiffest body, hung up, would stretch by a
  // hundredth.
  double least_hardness() const {
    double hardness = 1;
    for (int b = 0; b < scene().dynamic_bodies; ++b) {
      const SceneBody& body = scene().bodies[b];
      const MaterialCase& material = *body.material;
      Eigen::AlignedBox3d box;
      for (const Vec3& x : body.rest) box.extend(x);
      const double weight = material.area_density() * gravity_ * box.diagonal().norm();
      const double stiffness =
          std::max(material.membrane_stiffness, material.structural_stiffness.value_or(0));
      if (stiffness > 0) hardness = std::min(hardness, softest * weight / stiffness);
    }
    return hardness > 0 ? hardness : 1;
  }

  VelocitySystem system_;
  double pseudo_step_ = first_pseudo_step;  // s
  int pseudo_steps_ = 0;                    // of the present load
  int indefinite_steps_ = 0;  // pseudo-steps since an indefinite exact matrix; 0: none
  std::int64_t newton_iterations_ = 0, linear_iterations_ = 0;
  std::vector<double> rate_, right_, correction_, reached_;
  std::vector<double> weight_;  // all 1
  std::vector<Vec3> from_, to_, scratch_;
  double from_time_ = 0;  // s
  double gravity_ = 0;    // m/s^2
  double mass_ = 0;       // kg
};

}  // namespace

std::unique_ptr<Integrator> make_static_integrator(const Scene& scene, Dynamics& dynamics) {
  return std::make_unique<StaticIntegrator>(scene, dynamics);
}

}  // namespace weft::sim
