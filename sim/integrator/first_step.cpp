#include "sim/integrator/first_step.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "sim/integrator/short_steps.h"
#include "sim/motion/tolerances.h"

namespace weft::sim {

namespace {

// Estimated local error of the first step, as a fraction of the tolerances.
constexpr double error_share = 0.25;

double weighted_norm(std::span<const double> values, std::span<const double> weights) {
  double sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    sum += values[i] * values[i] * weights[i] * weights[i];
  return std::sqrt(sum / static_cast<double>(values.size()));
}

}  // namespace

double first_step(Dynamics& dynamics, double time, std::span<const double> y) {
  const double shortest = ShortSteps::shortest_ever(dynamics.scene().source.time);
  std::vector<double> weight(y.size()), rate(y.size()), ahead(y.size()), change(y.size());
  if (!error_weights(dynamics.scene(), y, weight) || dynamics.rate(time, y, rate)) return shortest;
  const double slope = weighted_norm(rate, weight);
  double trial = std::min(longest_first_step, 1 / slope);
  while (trial > shortest) {
    for (std::size_t i = 0; i < y.size(); ++i) ahead[i] = y[i] + trial * rate[i];
    if (dynamics.rate(time + trial, ahead, change)) {
      trial /= 10;
      continue;
    }
    for (std::size_t i = 0; i < y.size(); ++i) change[i] = (change[i] - rate[i]) / trial;
    const double step = std::sqrt(2 * error_share / weighted_norm(change, weight));
    return std::max(std::min(step, longest_first_step), shortest);
  }
  return shortest;
}

}  // namespace weft::sim
