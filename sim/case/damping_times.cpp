// Damping times of materials, as given or by a loss factor.
#include <numbers>

#include "sim/case/case.h"

namespace weft::sim {

namespace {

// Returns the damping time (s) whose loss factor at the frequency f (Hz) is eta: a force k (x +
// beta x') in a vibration of 2 pi f has the loss factor 2 pi f beta.
Varying<double> time_of(const MaterialCase& material, const Varying<double>& given) {
  if (!material.loss_factor) return given;
  return *material.loss_factor / (2 * std::numbers::pi * material.loss_frequency.value_or(1));
}

}  // namespace

Varying<double> MaterialCase::membrane_damping_time() const {
  return time_of(*this, stiffness_damping);
}

Varying<double> MaterialCase::bending_damping_time() const {
  return time_of(*this, bending_damping);
}

}  // namespace weft::sim
