#include "sim/integrator/tolerances.h"

#include <algorithm>
#include <cmath>

#include "sim/integrator/dynamics.h"

namespace weft::sim {

bool error_weights(const TimeCase& options, std::span<const double> y, std::span<double> weights) {
  const double velocity_tolerance =
      options.velocity_tolerance.value_or(100 * options.position_tolerance);
  const StateView view = StateView::of(y);
  const std::size_t half = y.size() / 2;
  std::fill_n(weights.begin(), half, 1 / options.position_tolerance);
  for (std::size_t i = 0; i < view.velocity.size(); ++i) {
    const double value =
        1 / (velocity_tolerance + options.relative_tolerance * view.velocity[i].norm());
    if (!std::isfinite(value)) return false;
    std::fill_n(weights.begin() + static_cast<std::ptrdiff_t>(half + 3 * i), 3, value);
  }
  return true;
}

}  // namespace weft::sim
