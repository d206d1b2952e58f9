// Variable-order, variable-step BDF by SUNDIALS CVODE. With contact, every step is checked for
// collisions.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>

#include "sim/integrator/integrator.h"

namespace weft::sim {

// Integrates from t = 0 and the scene's initial state. Tolerances: estimated position errors of a
// step are divided by position_tolerance (m), and velocity errors by velocity_tolerance +
// relative_tolerance |v| (m/s). A step is accepted if the root mean square of these quotients, over
// all components of all particles, is at most 1. Apart from rounding, the result does not depend on
// the origin or the directions of the axes. Prescribed motions limit the steps (motion_limits.h).
// The method restarts when a prescribed velocity or a curve jumps.
class CvodeIntegrator final : public Integrator {
 public:
  CvodeIntegrator(const Scene& scene, Dynamics& dynamics);
  ~CvodeIntegrator() override;

  [[nodiscard]] std::optional<Failure> step() override;
  double time() const override;
  double last_step() const override;
  int last_order() const override;
  std::span<const double> state() const override;
  // Interpolates with the polynomial of the method.
  [[nodiscard]] std::optional<Failure> state_at(double time, std::span<double> y) const override;
  IntegratorCounts counts() const override;
  void restart(double time, std::span<const double> y) override;
  // After reading, and until the next step, state_at() interpolates by AcceptedStep::interpolate().
  void transfer(StateArchive& archive) override;
  void tighten() override;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::sim
