// Converged runs of the stability grid: what the ends of its cells are compared with.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "bench/stability_grid.h"
#include "sim/scene/scene.h"

namespace weft::bench {

// Two methods of different kinds agree in this state within `agreement`.
struct ConvergedEnd {
  std::vector<sim::Vec3> position;  // m, of the dynamic particles
  double agreement = 0;             // m
};

class ConvergedEnds {
 public:
  // Runs them with a tolerance (m) for cells in which different things happen, `jobs` at a time,
  // each of the two methods for at most `limit` (s of CPU time) times the size of the cell.
  void find(std::span<const Cell> cells, double tolerance, double limit, int jobs);
  // Returns null where no reference was asked for, got to the end of the cell or converged:
  // buckling cloth is chaotic. Equilibria have no reference.
  const ConvergedEnd* at_end_of(const Cell& cell) const;

 private:
  std::map<std::vector<std::string>, std::map<double, ConvergedEnd>> by_physics_;  // then by time
};

}  // namespace weft::bench
