// The paths of equilibria of the hinged roof, cases/benchmarks/hinged_roof_*.toml.
#pragma once

#include <vector>

#include "sim/case/case.h"

namespace weft::bench {

// Deflections of the roof's centre (mm) and load factors of the whole force of 3000 N.
struct RoofPath {
  std::vector<double> deflection, factor;

  // Returns the largest load factor before the path first falls; 0 if it has no such point.
  double first_limit() const;
  // Returns the distance of a point from the nearest one on the path, whose points are joined by
  // straight lines. Deflections and load factors are measured in their ranges on the path: the
  // largest less the smallest.
  double distance(double at_deflection, double at_factor) const;
};

// Follows the path of hinged_roof_arc_length.toml to its end. Throws std::runtime_error if that
// fails.
RoofPath follow_by_arc_length(const sim::Case& source);

// Pushes the centre as hinged_roof_displacement.toml does; one point per frame. The factors are
// those of the reaction at the centre. Throws std::runtime_error if that fails.
RoofPath follow_by_displacement(const sim::Case& source);

// Returns the largest distance of the points of a path from another, in ranges of the latter.
double largest_distance(const RoofPath& points, const RoofPath& path);

}  // namespace weft::bench
