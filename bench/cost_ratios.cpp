#include "bench/cost_ratios.h"

#include <algorithm>
#include <cmath>

namespace weft::bench {

std::optional<double> cost_at(const CostLadder& ladder, double error) {
  std::optional<double> best;
  const CostPoint* before = nullptr;
  for (const CostPoint& point : ladder.points) {
    if (point.error && *point.error <= error) {
      double cost = point.cpu;
      if (before != nullptr && *before->error > error) {
        const double part =
            std::log(error / *before->error) / std::log(*point.error / *before->error);
        // If the coarser setting costs more, this setting is the better choice.
        cost = std::min(cost, before->cpu * std::pow(point.cpu / before->cpu, part));
      }
      if (!best || cost < *best) best = cost;
    }
    before = point.error ? &point : nullptr;
  }
  return best;
}

CostRatios cost_ratios(const std::vector<CostLadder>& ladders, double error) {
  const auto own = [&](StepKind kind) {
    return least_cost(ladders, error, [&](const CostLadder& ladder) {
      return !ladder.is_peer && ladder.kind == kind;
    });
  };
  const auto ratio = [](const std::optional<double>& a,
                        const std::optional<double>& b) -> std::optional<double> {
    if (!a || !b) return std::nullopt;
    return *a / *b;
  };
  const auto controlled = own(StepKind::controlled), fixed_implicit = own(StepKind::implicit),
             fixed_explicit = own(StepKind::explicit_);
  const auto fixed = least_cost(ladders, error, [](const CostLadder& ladder) {
    return !ladder.is_peer && ladder.kind != StepKind::controlled;
  });
  const auto peers =
      least_cost(ladders, error, [](const CostLadder& ladder) { return ladder.is_peer; });
  return {ratio(fixed, controlled), ratio(fixed_implicit, controlled),
          ratio(fixed_implicit, fixed_explicit), ratio(peers, controlled),
          ratio(peers, fixed_explicit)};
}

}  // namespace weft::bench
