// A one-step method with one implicit stage.
#pragma once

#include "sim/integrator/one_step_integrator.h"
#include "sim/integrator/stage_solver.h"

namespace weft::sim {

class StageIntegrator : public OneStepIntegrator {
 public:
  StageIntegrator(const Scene& scene, Dynamics& dynamics)
      : OneStepIntegrator(scene, dynamics), solver_(scene, dynamics, scene.source.time.newton) {
    solver_.set_stop([this] { return should_stop(); });
  }

  IntegratorCounts counts() const final {
    IntegratorCounts counts = OneStepIntegrator::counts();
    solver_.add_counts(counts);
    return counts;
  }
  void transfer(StateArchive& archive) override {
    transfer_steps(archive);
    solver_.transfer(archive);
  }

 protected:
  void forget() override { solver_.forget(); }

  // Solves y - gamma f(t, y) = state() by StageSolver::solve(), with positions() as the start of
  // its paths.
  Trouble solve_stage(double t, double gamma, std::span<double> y) {
    const StageSolver::Outcome outcome = solver_.solve(t, gamma, state(), positions(), y);
    set_fault(solver_.fault());
    if (outcome == StageSolver::Outcome::blocked) return Trouble::surfaces;
    if (outcome == StageSolver::Outcome::solved) return Trouble::none;
    set_place(solver_.worst_particle());
    return Trouble::not_converged;
  }

 private:
  StageSolver solver_;
};

}  // namespace weft::sim
