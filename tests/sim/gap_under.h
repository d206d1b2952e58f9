// The gap at which the barrier of contact carries a load.
#pragma once

#include "materials/contact.h"

namespace weft::sim {

// Returns the gap (m) at which the barrier carries a pressure (Pa).
inline double gap_under(double pressure, double range = 2e-3, double stiffness = 1e6) {
  double low = 1e-9 * range, high = range;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (-materials::barrier(middle, range, stiffness).first > pressure ? low : high) = middle;
  }
  return low;
}

}  // namespace weft::sim
