// Converged runs of the stability grid, with which the ends of its cells are compared.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "bench/stability_grid.h"
#include "sim/scene/scene.h"

namespace weft::bench {

// The end of a converged run: two methods of different kinds agree in it within `agreement`.
struct ConvergedEnd {
  std::vector<sim::Vec3> position;  // m, of the dynamic particles
  double agreement = 0;             // m
};

class ConvergedEnds {
 public:
  // Runs references with a tolerance (m), one for all cells of the same physics, `jobs` at a time.
  // Each of the two methods may take `limit` (s of CPU time) times the size of the cell.
  void find(std::span<const Cell> cells, double tolerance, double limit, int jobs);
  // Returns null if no reference was asked for, reached the end of the cell or converged: buckling
  // cloth is chaotic. Equilibria have no reference.
  const ConvergedEnd* at_end_of(const Cell& cell) const;

 private:
  std::map<std::vector<std::string>, std::map<double, ConvergedEnd>> by_physics_;  // then by time
};

}  // namespace weft::bench
