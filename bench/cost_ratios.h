// Cost of an error by method, and the ratios that are drawn from it.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace weft::bench {

// One rung of a ladder of settings.
struct CostPoint {
  double cpu = 0;               // s
  std::optional<double> error;  // m; nothing where the run failed
};

// Who chooses the steps, and how each is taken.
enum class StepKind {
  controlled,  // implicit, chosen by an error tolerance
  implicit,    // fixed and implicit
  explicit_    // fixed and explicit
};

// A method with one way of setting it, from coarse to fine.
struct CostLadder {
  std::string method;
  StepKind kind = StepKind::controlled;
  bool is_peer = false;  // of another library
  std::vector<CostPoint> points;
};

// Returns the cost (CPU s) of this error (m), between two rungs on logarithmic scales; nothing
// where it does not get there.
std::optional<double> cost_at(const CostLadder& ladder, double error);
// The least of all ladders for which `counts` holds.
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

// Costs at one error as multiples of each other; nothing where either side does not get there.
// Below 1: the method named second is the dearer one.
struct CostRatios {
  std::optional<double> fixed_over_controlled;     // the cheapest fixed step of any kind
  std::optional<double> implicit_over_controlled;  // the cheapest implicit fixed step
  std::optional<double> implicit_over_explicit;    // the same over the explicit fixed step, Verlet
  std::optional<double> peers_over_controlled, peers_over_explicit;
};
CostRatios cost_ratios(const std::vector<CostLadder>& ladders, double error);

}  // namespace weft::bench
