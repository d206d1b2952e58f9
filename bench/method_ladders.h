// The methods of time integration, each with a ladder of settings from coarse to fine.
#pragma once

#include <span>
#include <string>

#include "sim/case/case.h"

namespace weft::bench {

// How a method is set for a given accuracy: by a tolerance (m) or by a step (s).
struct Ladder {
  const char* name;
  bool baseline;  // fixed steps, as others do
  bool implicit;
  bool by_step;
  double first;    // its coarsest setting
  double divisor;  // from one to the next
  int count;
  void (*apply)(sim::TimeCase& time, double setting);
};

std::span<const Ladder> method_ladders();

// "step 0.001 s"
std::string step_text(double step);
// "tolerance 1e-05 m", or the step.
std::string setting_text(const Ladder& ladder, double setting);

}  // namespace weft::bench
