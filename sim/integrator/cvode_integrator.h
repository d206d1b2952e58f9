// Variable-order, variable-step BDF by SUNDIALS CVODE, with every step checked for collisions.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/integrator/dynamics.h"

namespace weft::sim {

struct IntegratorCounts {
  std::int64_t steps = 0;
  std::int64_t vetoed_steps = 0;  // cut because surfaces would have touched or crossed
  std::int64_t error_test_failures = 0;
  std::int64_t convergence_failures = 0;
  std::int64_t newton_iterations = 0;
  std::int64_t linear_iterations = 0;
  std::int64_t linear_setups = 0;
};

// Integrates from t = 0 and the scene's initial state. Tolerances: the local error of a step,
// divided by position_tolerance (m) for positions and by velocity_tolerance + relative_tolerance
// |v| (m/s) for velocities, has a root mean square of at most 1 over all components of all
// particles together. Independent of where the origin lies and of how the axes are turned.
class CvodeIntegrator {
 public:
  CvodeIntegrator(const Scene& scene, Dynamics& dynamics);
  ~CvodeIntegrator();
  CvodeIntegrator(const CvodeIntegrator&) = delete;
  CvodeIntegrator& operator=(const CvodeIntegrator&) = delete;

  // Takes one step. On failure the state stays that of the last step, and the reason is returned:
  // what failed, the bodies concerned and the time.
  [[nodiscard]] std::optional<std::string> step();
  double time() const;       // s, reached so far
  double last_step() const;  // s
  int last_order() const;
  std::span<const double> state() const;  // at time()
  // State at a time within the last step, interpolated to the order of the method; where contact is
  // on and the interpolated path is not certain to keep surfaces apart, along the straight path
  // that is.
  void state_at(double time, std::span<double> y) const;
  IntegratorCounts counts() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::sim
