#include "sim/integrator/integrator_makers.h"
#include "sim/integrator/stage_integrator.h"

namespace weft::sim {

namespace {

class MidpointIntegrator final : public StageIntegrator {
 public:
  using StageIntegrator::StageIntegrator;

  int last_order() const override { return 2; }

 private:
  // A backward Euler step of half the length gives the midpoint. The end is extrapolated linearly
  // from the start and the midpoint.
  Trouble attempt(double& end, std::span<double> y) override {
    const double h = end - time();
    const Trouble trouble = solve_stage(time() + h / 2, h / 2, y);
    if (trouble != Trouble::none) return trouble;
    for (std::size_t i = 0; i < y.size(); ++i) y[i] = 2 * y[i] - state()[i];
    return Trouble::none;
  }
};

}  // namespace

std::unique_ptr<Integrator> make_midpoint_integrator(const Scene& scene, Dynamics& dynamics) {
  return std::make_unique<MidpointIntegrator>(scene, dynamics);
}

}  // namespace weft::sim
