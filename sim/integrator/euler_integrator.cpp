#include <algorithm>
#include <cmath>

#include "sim/integrator/integrator_makers.h"
#include "sim/integrator/one_step_integrator.h"
#include "sim/integrator/stage_solver.h"
#include "sim/integrator/tolerances.h"

namespace weft::sim {

namespace {

class EulerIntegrator final : public OneStepIntegrator {
 public:
  EulerIntegrator(const Scene& scene, Dynamics& dynamics)
      : OneStepIntegrator(scene, dynamics),
        solver_(scene, dynamics, scene.source.time.newton),
        rate_(dynamics.state_size()),
        weight_(dynamics.state_size()) {}

  int last_order() const override { return 1; }
  IntegratorCounts counts() const override {
    IntegratorCounts counts = OneStepIntegrator::counts();
    solver_.add_counts(counts);
    return counts;
  }

 private:
  Trouble attempt(double& end, std::span<double> y) override {
    const double h = end - time();
    const StageSolver::Outcome outcome = solver_.solve(end, h, state(), positions(), y);
    set_fault(solver_.fault());
    if (outcome == StageSolver::Outcome::blocked) return Trouble::surfaces;
    if (outcome == StageSolver::Outcome::not_converged) {
      set_place(solver_.worst_particle());
      return Trouble::not_converged;
    }
    return is_fixed() ? Trouble::none : test_error(h, y);
  }

  // The local error, h^2 y'' / 2, from the slopes of this step and the last one.
  Trouble test_error(double h, std::span<const double> y) {
    if (last_step() == 0 && dynamics().rate(0, state(), rate_)) return Trouble::surfaces;
    if (!error_weights(scene().source.time, state(), weight_)) return Trouble::not_finite;
    const double factor = h * h / (h + last_step());
    double sum = 0;
    for (std::size_t i = 0; i < y.size(); ++i) {
      const double error = factor * ((y[i] - state()[i]) / h - rate_[i]) * weight_[i];
      sum += error * error;
    }
    const double size = std::sqrt(sum / static_cast<double>(y.size()));
    propose(h * std::clamp(0.9 / std::sqrt(std::max(size, 1e-10)), 0.1, 2.0));
    if (!(size <= 1)) return Trouble::error_too_large;
    for (std::size_t i = 0; i < y.size(); ++i) rate_[i] = (y[i] - state()[i]) / h;
    return Trouble::none;
  }

  StageSolver solver_;
  std::vector<double> rate_;  // slope of the step before; at the start, of the motion
  std::vector<double> weight_;
};

}  // namespace

std::unique_ptr<Integrator> make_euler_integrator(const Scene& scene, Dynamics& dynamics) {
  return std::make_unique<EulerIntegrator>(scene, dynamics);
}

}  // namespace weft::sim
