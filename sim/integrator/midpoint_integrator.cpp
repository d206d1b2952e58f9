#include "sim/integrator/integrator_makers.h"
#include "sim/integrator/one_step_integrator.h"
#include "sim/integrator/stage_solver.h"

namespace weft::sim {

namespace {

class MidpointIntegrator final : public OneStepIntegrator {
 public:
  MidpointIntegrator(const Scene& scene, Dynamics& dynamics)
      : OneStepIntegrator(scene, dynamics), solver_(scene, dynamics, scene.source.time.newton) {}

  int last_order() const override { return 2; }
  IntegratorCounts counts() const override {
    IntegratorCounts counts = OneStepIntegrator::counts();
    solver_.add_counts(counts);
    return counts;
  }

 private:
  // The middle is a step of backward Euler of half the length; the end lies as far beyond it.
  Trouble attempt(double& end, std::span<double> y) override {
    const double h = end - time();
    const StageSolver::Outcome outcome =
        solver_.solve(time() + h / 2, h / 2, state(), positions(), y);
    set_fault(solver_.fault());
    if (outcome == StageSolver::Outcome::blocked) return Trouble::surfaces;
    if (outcome == StageSolver::Outcome::not_converged) {
      set_place(solver_.worst_particle());
      return Trouble::not_converged;
    }
    for (std::size_t i = 0; i < y.size(); ++i) y[i] = 2 * y[i] - state()[i];
    return Trouble::none;
  }

  StageSolver solver_;
};

}  // namespace

std::unique_ptr<Integrator> make_midpoint_integrator(const Scene& scene, Dynamics& dynamics) {
  return std::make_unique<MidpointIntegrator>(scene, dynamics);
}

}  // namespace weft::sim
