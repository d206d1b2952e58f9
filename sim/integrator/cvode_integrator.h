// Variable-order, variable-step BDF by SUNDIALS CVODE, with every step checked for collisions.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>

#include "sim/integrator/integrator.h"

namespace weft::sim {

// Integrates from t = 0 and the scene's initial state. Tolerances: the local error of a step,
// divided by position_tolerance (m) for positions and by velocity_tolerance + relative_tolerance
// |v| (m/s) for velocities, has a root mean square of at most 1 over all components of all
// particles together. Independent of where the origin lies and of how the axes are turned. Steps
// are bounded by prescribed motions (motion_limits.h), and begin anew where one of their velocities
// jumps.
class CvodeIntegrator final : public Integrator {
 public:
  CvodeIntegrator(const Scene& scene, Dynamics& dynamics);
  ~CvodeIntegrator() override;

  [[nodiscard]] std::optional<Failure> step() override;
  double time() const override;
  double last_step() const override;
  int last_order() const override;
  std::span<const double> state() const override;
  // Interpolated to the order of the method.
  [[nodiscard]] std::optional<Failure> state_at(double time, std::span<double> y) const override;
  IntegratorCounts counts() const override;
  void restart(double time, std::span<const double> y) override;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::sim
