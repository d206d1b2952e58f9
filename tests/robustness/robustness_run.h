// One run of the suite `robustness`: every accepted step is judged.
#pragma once

#include <string>

#include "sim/case/case.h"

namespace weft::robustness {

struct Judgement {
  std::string fault;  // empty: none
  double time = 0;    // s, reached
  long steps = 0, vetoed = 0;
  double cpu_time = 0;      // s
  double gained_share = 0;  // largest gain of energy, divided by the largest energy in motion
};

// CPU time (s) of a run after which it counts as stalled.
constexpr double run_limit = 100;
// Gain of energy that errors of integration may make, as a share of the largest kinetic, elastic
// and contact energy of the run so far.
constexpr double energy_slack = 0.02;

// Runs a case up to `end` (s) or a little beyond. The fault is the first of these: a case that is
// refused; a step that fails, for lack of progress or another reason; a state after a step that is
// not finite, or in which surfaces cross that contact keeps apart; a gain of energy, if nothing
// feeds the bodies; and more CPU time than run_limit.
Judgement judge(const sim::Case& source, double end);

std::string to_text(const Judgement& judgement);
Judgement from_text(const std::string& text);

}  // namespace weft::robustness
