// The time integration methods, each with a ladder of settings from coarse to fine.
#pragma once

#include <span>
#include <string>

#include "bench/cost_ratios.h"
#include "sim/case/case.h"

namespace weft::bench {

// A method whose accuracy is set by a tolerance (m) or by a step (s).
struct Ladder {
  const char* name;
  StepKind kind;
  bool by_step;
  double first;    // coarsest setting
  double divisor;  // ratio of a setting to the next
  int count;
  void (*apply)(sim::TimeCase& time, double setting);
};

std::span<const Ladder> method_ladders();

// Fixed steps, of Weft's methods and of other libraries': up to 14 of them, from the first down by
// the divisor, as far as the budget allows.
inline constexpr double first_step = 1.0 / 30;  // s
inline constexpr double step_divisor = 2;
inline constexpr int step_count = 14;

// Tells when to stop climbing a ladder: two settings in a row have exceeded the budget. Coarse
// settings may fail to finish where finer ones succeed, so they count only after one has finished.
class LadderEnd {
 public:
  // Call after each setting.
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
