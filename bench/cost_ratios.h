// Cost of an error by method, and ratios of such costs.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace weft::bench {

// One rung of a ladder of settings.
struct CostPoint {
  double cpu = 0;               // s
  std::optional<double> error;  // m; empty if the run failed
};

// How steps are chosen, and how each is taken.
enum class StepKind {
  controlled,  // implicit, chosen by an error tolerance
  implicit,    // fixed and implicit
  explicit_    // fixed and explicit
};

// A method with one kind of setting, from coarse to fine.
struct CostLadder {
  std::string method;
  StepKind kind = StepKind::controlled;
  bool is_peer = false;  // of another library
  std::vector<CostPoint> points;
};

// Returns the cost (CPU s) of this error (m), interpolated between two rungs on logarithmic scales;
// empty if the ladder does not reach it.
std::optional<double> cost_at(const CostLadder& ladder, double error);
// Returns the least cost of the ladders for which `counts` holds.
template <class Counts>
std::optional<double> least_cost(const std::vector<CostLadder>& ladders, double error,
                                 const Counts& counts) {
  std::optional<double> least;
  for (const CostLadder& ladder : ladders) {
    if (!counts(ladder)) continue;
    const auto cost = cost_at(ladder, error);
    if (cost && (!least || *cost < *least)) least = cost;
  }
  return least;
}

// Ratios of costs at one error; empty if either side does not reach it. A ratio below 1 means that
// the method named second costs more.
struct CostRatios {
  std::optional<double> fixed_over_controlled;     // the cheapest fixed step of any kind
  std::optional<double> implicit_over_controlled;  // the cheapest implicit fixed step
  std::optional<double> implicit_over_explicit;    // the same over the explicit fixed step, Verlet
  std::optional<double> peers_over_controlled, peers_over_explicit;
};
CostRatios cost_ratios(const std::vector<CostLadder>& ladders, double error);

}  // namespace weft::bench
