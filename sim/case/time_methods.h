// The properties of the time integration methods, one line per method.
#pragma once

#include <cstddef>
#include <span>

#include "sim/case/case.h"

namespace weft::sim {

struct TimeMethodTraits {
  // The origin of the step length: `time.step`, the method, either of these, or one load step per
  // frame.
  enum class Steps { fixed, chosen, either, loads };

  TimeMethod method;
  const char* name;   // as in `time.method`
  const char* title;  // in words, for `weft check`
  int order;          // of convergence; for cvode, the largest time.maximum_order
  Steps steps;
  bool is_explicit;    // needs no stiffness matrix
  bool is_calibrated;  // `time.accuracy` may choose its tolerance from the calibration table
  bool finds_equilibria() const { return steps == Steps::loads; }
};

// True if the table has one line per TimeMethod, in the order of that enum. Each line needs a
// member `method`.
constexpr bool is_in_order_of_methods(const auto& table) {
  for (std::size_t i = 0; i < table.size(); ++i) {
    if (table[i].method != static_cast<TimeMethod>(i)) return false;
  }
  return table.size() == static_cast<std::size_t>(TimeMethod::verlet) + 1;
}

// Returns the properties of all methods, in the order of TimeMethod. sim/integrator/integrator.cpp
// makes the integrators.
std::span<const TimeMethodTraits> time_methods();
const TimeMethodTraits& traits_of(TimeMethod method);

}  // namespace weft::sim
