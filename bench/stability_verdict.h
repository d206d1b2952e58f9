// The verdict on the stability grid as a whole.
#pragma once

#include <span>

#include "bench/stability_cell.h"

namespace weft::bench {

// Shares of the cells whose obstacles and pins are at rest. Most of these fail only if a method
// cannot do what it is asked, and few are so slow that they are ended. `inexact` counts only runs
// of methods with a tolerance: the error of a fixed step follows from the step.
struct Shares {
  int cells = 0, failed = 0, limited = 0, inexact = 0;
  static constexpr double most_failed = 0.15, most_limited = 0.05, most_inexact = 0.1;

  void add(const Cell& cell, const CellResult& result);
  bool are_small() const {
    return failed <= most_failed * cells && limited <= most_limited * cells &&
           inexact <= most_inexact * cells;
  }
};

// Number of all cells, number of those simulated for at least a second, and the range of simulated
// times.
struct SimulatedTimes {
  int cells = 0, long_cells = 0;
  double shortest = 0, longest = 0;  // s

  void add(const Cell& cell);
};

}  // namespace weft::bench
