#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "sim/integrator/integrator_makers.h"
#include "sim/integrator/one_step_integrator.h"
#include "sim/integrator/tolerances.h"
#include "sim/integrator/velocity_system.h"

namespace weft::sim {

namespace {

// Pseudo-steps: one Newton iteration of backward Euler from rest each. Short ones go along the
// forces, long ones are Newton's method on the equilibrium.
constexpr double first_pseudo_step = 0.05;     // s; cloth swings in some tenths of a second
constexpr double longest_pseudo_step = 1e4;    // s
constexpr double shortest_pseudo_step = 1e-6;  // s
constexpr double newton_step = 1;              // s; from here on a step tells the distance left
constexpr double growth = 5;                   // after a step that was taken whole
// However small the load: what hangs has to turn all the way to where gravity points. A smaller one
// would only begin again.
constexpr int most_pseudo_steps = 600;
// A sheet that hangs takes some 30 to 100. What takes more is held up by its stiffness.
constexpr int patience = 100;
// What may be left of the forces, as a fraction of the weight; of a softened body.
constexpr double residual_fraction = 1e-4, softened_fraction = 1e-2;
// Of the softest body, to the force per width of its own weight; and from one stage to the next.
constexpr double softest = 100, hardening = 10;
// What a linear solve may leave of a direction.
constexpr VelocitySystem::Goal linear_goal{.error = 1e-2,
                                           .scale = VelocitySystem::Goal::Scale::matrix};
constexpr double shortest_fraction = 1e-6;  // of a step
// Where the exact matrix was indefinite, it is looked at again after so many pseudo-steps.
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
        gravity_(scene.source.world.gravity.norm()) {
    if (dynamics.contact() != nullptr) dynamics.contact()->keep_matrix_definite();
    for (const double mass : scene.mass) mass_ += mass;
  }

  int last_order() const override { return 0; }
  IntegratorCounts counts() const override {
    IntegratorCounts counts = OneStepIntegrator::counts();
    counts.newton_iterations = newton_iterations_;
    counts.linear_iterations = linear_iterations_;
    counts.linear_setups = newton_iterations_;
    return counts;
  }

 private:
  bool checks_its_own_path() const override { return true; }

  // With the bodies as they are. Stiff ones that hang slack turn by a small angle a step, since
  // straight paths stretch them: softened they turn by large ones. Where they then hang is where
  // harder ones hang, but for their stretch.
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
  // Takes pseudo-steps until the forces balance, or until there have been so many in this load.
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

  // (M + h^2 K) dv = h F, dx = h dv; K semi-definite where the exact one leads nowhere. That is
  // found out by iterations in vain, and stays so for a while.
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

  // How much of the correction is taken: shortened until the forces at its end do not push back
  // with more than half of what they pull with at its start. Their work decides, not their size: a
  // straight path stretches what turns, and the forces of a stiff body grow long before its energy
  // does. 0: none of it; the last evaluation is that of `y`.
  double descend(double end, std::span<double> y) {
    std::copy(y.begin(), y.end(), reached_.begin());
    const double start = pull();
    for (double fraction = 1; fraction > shortest_fraction;) {
      for (std::size_t i = 0; i < y.size() / 2; ++i) y[i] = reached_[i] + fraction * correction_[i];
      set_fault(dynamics().rate(end, y, rate_));
      const double now = fault() ? 0 : pull();
      if (now < -0.5 * start) {
        // What pushes back grows as the third power of the way.
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

  // The work of the forces along the correction, at the rate at which it begins (J).
  double pull() const {
    const StateView way = StateView::of(correction_), force = StateView::of(rate_);
    double sum = 0;
    for (std::size_t i = 0; i < way.position.size(); ++i)
      sum += scene().mass[i] * way.position[i].dot(force.velocity[i]);
    return sum;
  }

  // From one pseudo-step to the next; makes `y` the start of the next path.
  bool path_is_safe(double end, std::span<const double> y) {
    if (dynamics().contact() == nullptr) return true;
    dynamics().expand(end, y, to_, scratch_);
    set_fault(dynamics().check_path(from_time_, from_, end, to_));
    if (fault()) return false;
    from_time_ = end;  // what is prescribed has arrived
    from_.swap(to_);
    return true;
  }

  // Judged by the forces themselves and, at last, by how far a Newton step still goes.
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

  // The part of its stiffness with which the stiffest body, hung up, would stretch by a hundredth.
  double least_hardness() const {
    double hardness = 1;
    for (int b = 0; b < scene().dynamic_bodies; ++b) {
      const SceneBody& body = scene().bodies[b];
      const MaterialCase& material = *body.material;
      Eigen::AlignedBox3d box;
      for (const Vec3& x : body.rest) box.extend(x);
      const double weight = material.density * gravity_ * box.diagonal().norm();
      const double stiffness =
          std::max(material.membrane_stiffness, material.structural_stiffness.value_or(0));
      if (stiffness > 0) hardness = std::min(hardness, softest * weight / stiffness);
    }
    return hardness > 0 ? hardness : 1;
  }

  VelocitySystem system_;
  double pseudo_step_ = first_pseudo_step;  // s
  int pseudo_steps_ = 0;                    // of the load in hand
  int indefinite_steps_ = 0;                // from that whose exact matrix was
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
