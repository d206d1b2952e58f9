// The methods of time integration, each with a ladder of settings from coarse to fine.
#pragma once

#include <span>
#include <string>

#include "bench/cost_ratios.h"
#include "sim/case/case.h"

namespace weft::bench {

// How a method is set for a given accuracy: by a tolerance (m) or by a step (s).
struct Ladder {
  const char* name;
  StepKind kind;
  bool by_step;
  double first;    // its coarsest setting
  double divisor;  // from one to the next
  int count;
  void (*apply)(sim::TimeCase& time, double setting);
};

std::span<const Ladder> method_ladders();

// Steps that are given, of Weft's methods and of other libraries': from the first down by the
// divisor, 14 of them, as far as the budget allows.
inline constexpr double first_step = 1.0 / 30;  // s
inline constexpr double step_divisor = 2;
inline constexpr int step_count = 14;

// When to leave a ladder: two settings in a row have spent the budget. Coarse ones may fail to come
// to an end where finer ones do: these do not count before one has.
class LadderEnd {
 public:
  // After each setting.
  bool is_reached(bool over_budget) {
    counts_ = counts_ || !over_budget;
    too_slow_ = over_budget && counts_ ? too_slow_ + 1 : 0;
    return too_slow_ == 2;
  }

 private:
  bool counts_ = false;
  int too_slow_ = 0;
};

// "step 0.001 s"
std::string step_text(double step);
// "tolerance 1e-05 m", or the step.
std::string setting_text(const Ladder& ladder, double setting);

}  // namespace weft::bench
