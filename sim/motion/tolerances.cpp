#include "sim/motion/tolerances.h"

#include <algorithm>
#include <cmath>

#include "sim/motion/dynamics.h"

namespace weft::sim {

double velocity_tolerance(const TimeCase& options) {
  return options.velocity_tolerance.value_or(100 * options.position_tolerance);
}

bool error_weights(const TimeCase& options, std::span<const double> y, std::span<double> weights) {
  const double tolerance = velocity_tolerance(options);
  const StateView view = StateView::of(y);
  const std::size_t half = y.size() / 2;
  std::fill_n(weights.begin(), half, 1 / options.position_tolerance);
  for (std::size_t i = 0; i < view.velocity.size(); ++i) {
    const double value = 1 / (tolerance + options.relative_tolerance * view.velocity[i].norm());
    if (!std::isfinite(value)) return false;
    std::fill_n(weights.begin() + static_cast<std::ptrdiff_t>(half + 3 * i), 3, value);
  }
  return true;
}

StepLimit largest_error_part(const Dynamics& dynamics, std::span<const double> weighted) {
  const StateView error = StateView::of(weighted);
  std::vector<char> in_contact(error.position.size(), 0);
  if (dynamics.contact() != nullptr) dynamics.contact()->mark_particles_in_reach(in_contact);
  ErrorParts parts;
  for (std::size_t i = 0; i < error.position.size(); ++i) {
    auto& [position, velocity] = parts.sum[in_contact[i]];
    position += error.position[i].squaredNorm();
    velocity += error.velocity[i].squaredNorm();
  }
  return parts.largest();
}

int worst_particle(std::span<const double> errors, std::span<const double> weights) {
  const StateView error = StateView::of(errors), weight = StateView::of(weights);
  int worst = 0;
  double largest = -1;
  for (std::size_t i = 0; i < error.position.size(); ++i) {
    const double size = error.position[i].cwiseProduct(weight.position[i]).squaredNorm() +
                        error.velocity[i].cwiseProduct(weight.velocity[i]).squaredNorm();
    if (size <= largest) continue;
    largest = size;
    worst = static_cast<int>(i);
    if (!std::isfinite(size)) break;
  }
  return worst;
}

}  // namespace weft::sim
