#include <algorithm>
#include <cmath>

#include "sim/integrator/integrator_makers.h"
#include "sim/integrator/stage_integrator.h"

namespace weft::sim {

namespace {

// Pseudo-steps of backward Euler, whose velocity is taken away whenever the kinetic energy has
// passed a maximum: short ones fall towards the equilibrium, long ones are Newton's method on it.
constexpr double first_pseudo_step = 0.05;     // s; cloth swings in some tenths of a second
constexpr double longest_pseudo_step = 1e4;    // s
constexpr double shortest_pseudo_step = 1e-6;  // s
// However small the load: what hangs has to turn all the way to where gravity points. A smaller one
// would only begin again.
constexpr int most_pseudo_steps = 2000;
// What may be left of the forces, as a fraction of the weight.
constexpr double residual_fraction = 1e-4;

class StaticIntegrator final : public StageIntegrator {
 public:
  StaticIntegrator(const Scene& scene, Dynamics& dynamics)
      : StageIntegrator(scene, dynamics, true), rate_(dynamics.state_size()) {
    reached_.assign(state().begin(), state().end());
    stop(reached_);
  }

  int last_order() const override { return 0; }

 private:
  bool checks_its_own_path() const override { return true; }

  Trouble attempt(double& end, std::span<double> y) override {
    dynamics().set_load(end / scene().source.time.duration);
    std::copy(y.begin(), y.end(), reached_.begin());
    from_ = positions();
    double h = pseudo_step_;
    for (int k = 0; k < most_pseudo_steps; ++k) {
      std::copy(reached_.begin(), reached_.end(), y.begin());
      const std::int64_t before = counts().newton_iterations;
      Trouble trouble = solve_stage(end, h, reached_, from_, y);
      if (trouble == Trouble::none && !path_is_safe(end, y)) trouble = Trouble::surfaces;
      if (trouble != Trouble::none) {
        h /= 4;
        if (h < shortest_pseudo_step) return trouble;
        continue;
      }
      if (is_at_rest(end, y)) {
        pseudo_step_ = h;
        stop(y);
        return Trouble::none;
      }
      const bool slower = kinetic_energy(y) < kinetic_energy(reached_);
      std::copy(y.begin(), y.end(), reached_.begin());
      if (slower) stop(reached_);
      // Many iterations mean that a step reaches beyond where its start tells anything.
      const std::int64_t iterations = counts().newton_iterations - before;
      h = std::min(h * (iterations <= 6 ? 2 : iterations <= 12 ? 1.2 : 0.6), longest_pseudo_step);
    }
    end = time();
    return Trouble::not_converged;
  }

  static void stop(std::span<double> y) {
    std::fill(y.begin() + static_cast<std::ptrdiff_t>(y.size() / 2), y.end(), 0.0);
  }

  double kinetic_energy(std::span<const double> y) const {
    const StateView state = StateView::of(y);
    double sum = 0;
    for (std::size_t i = 0; i < state.velocity.size(); ++i) {
      sum += 0.5 * scene().mass[i] * state.velocity[i].squaredNorm();
    }
    return sum;
  }

  // From one pseudo-step to the next; makes `y` the start of the next path.
  bool path_is_safe(double end, std::span<const double> y) {
    if (dynamics().contact() == nullptr) return true;
    dynamics().expand(end, y, to_, scratch_);
    if (const auto fault = dynamics().contact()->check_path(from_, to_)) {
      set_fault(fault);
      return false;
    }
    from_.swap(to_);
    return true;
  }

  // Judged by the forces themselves: a step within its tolerance may have left all of them.
  bool is_at_rest(double end, std::span<const double> y) {
    const StateView now = StateView::of(y), before = StateView::of(reached_);
    double largest_move = 0;
    for (std::size_t i = 0; i < now.position.size(); ++i)
      largest_move = std::max(largest_move, (now.position[i] - before.position[i]).norm());
    if (largest_move > scene().source.time.position_tolerance) return false;
    const double weight = scene().source.world.gravity.norm();
    if (weight == 0) return true;
    if (dynamics().rate(end, y, rate_)) return false;
    const StateView left = StateView::of(rate_);
    double force = 0, mass = 0;
    for (std::size_t i = 0; i < left.velocity.size(); ++i) {
      force += scene().mass[i] * left.velocity[i].squaredNorm();
      mass += scene().mass[i];
    }
    return std::sqrt(force / mass) <= residual_fraction * weight;
  }

  double pseudo_step_ = first_pseudo_step;  // s, of the next load
  std::vector<double> reached_;             // by pseudo-steps
  std::vector<double> rate_;
  std::vector<Vec3> from_, to_, scratch_;
};

}  // namespace

std::unique_ptr<Integrator> make_static_integrator(const Scene& scene, Dynamics& dynamics) {
  return std::make_unique<StaticIntegrator>(scene, dynamics);
}

}  // namespace weft::sim
