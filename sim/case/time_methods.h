// The methods of time integration: one line each, read by all who ask about a method's nature.
#pragma once

#include <span>

#include "sim/case/case.h"

namespace weft::sim {

struct TimeMethodTraits {
  // Lengths of steps: given by `time.step`, chosen by the method, either of these, or one load a
  // frame.
  enum class Steps { fixed, chosen, either, loads };

  TimeMethod method;
  const char* name;   // of `time.method`
  const char* title;  // in words, for weft check
  int order;          // of convergence in the step; the highest that time.maximum_order allows
  Steps steps;
  bool is_explicit;    // takes no matrix
  bool is_calibrated;  // `time.accuracy` may set its tolerance by the table
  bool finds_equilibria() const { return steps == Steps::loads; }
};

// In the order of TimeMethod. Their makers are in sim/integrator/integrator.cpp.
std::span<const TimeMethodTraits> time_methods();
const TimeMethodTraits& traits_of(TimeMethod method);

}  // namespace weft::sim
