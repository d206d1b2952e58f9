#include "bench/stability_verdict.h"

#include <algorithm>

namespace weft::bench {

void Shares::add(const Cell& cell, const CellResult& result) {
  if (cell.has_moving_parts) return;
  ++cells;
  failed += result.outcome == Outcome::failed ? 1 : 0;
  inexact += result.outcome == Outcome::inexact && cell.tolerance > 0 ? 1 : 0;
  limited += result.outcome == Outcome::limited ? 1 : 0;
}

void SimulatedTimes::add(const Cell& cell) {
  shortest = cells == 0 ? cell.duration : std::min(shortest, cell.duration);
  longest = std::max(longest, cell.duration);
  ++cells;
  long_cells += cell.duration >= 1 ? 1 : 0;
}

}  // namespace weft::bench
