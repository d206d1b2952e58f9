#include "bench/method_ladders.h"

#include <cmath>
#include <cstdio>

#include "bench/reference_run.h"

namespace weft::bench {

namespace {

using namespace sim;

// Sets a fixed step. Its equations are solved far more exactly than its error, so that the method
// is judged and not its iterations.
void set_step(TimeCase& time, TimeMethod method, double step, int newton) {
  time.method = method;
  time.step = step;
  time.newton = newton;
  time.position_tolerance = 1e-3 * step;
  time.relative_tolerance = 1e-3;
}

constexpr Ladder ladders[] = {
    {"cvode", StepKind::controlled, false, 1e-2, std::sqrt(10.0), 11,
     [](TimeCase& time, double setting) { set_tolerance(time, TimeMethod::cvode, setting); }},
    {"arkode", StepKind::controlled, false, 1e-2, std::sqrt(10.0), 11,
     [](TimeCase& time, double setting) { set_tolerance(time, TimeMethod::arkode, setting); }},
    {"euler", StepKind::controlled, false, 1e-2, std::sqrt(10.0), 7,
     [](TimeCase& time, double setting) { set_tolerance(time, TimeMethod::euler, setting); }},
    {"linear-euler", StepKind::implicit, true, first_step, step_divisor, step_count,
     [](TimeCase& time, double setting) { set_step(time, TimeMethod::euler, setting, 1); }},
    {"backward-euler", StepKind::implicit, true, first_step, step_divisor, step_count,
     [](TimeCase& time, double setting) { set_step(time, TimeMethod::euler, setting, 0); }},
    {"implicit-midpoint", StepKind::implicit, true, first_step, step_divisor, step_count,
     [](TimeCase& time, double setting) {
       set_step(time, TimeMethod::implicit_midpoint, setting, 0);
     }},
    // This ladder starts at nine tenths of verlet's longest stable step.
    {"verlet", StepKind::explicit_, false, 2.1e-4, 4, 5,
     [](TimeCase& time, double setting) { set_tolerance(time, TimeMethod::verlet, setting); }},
};

}  // namespace

std::span<const Ladder> method_ladders() { return ladders; }

std::string step_text(double step) {
  char text[40];
  std::snprintf(text, sizeof text, "step %.3g s", step);
  return text;
}

std::string setting_text(const Ladder& ladder, double setting) {
  if (ladder.by_step) return step_text(setting);
  char text[40];
  std::snprintf(text, sizeof text, "tolerance %.2g m", setting);
  return text;
}

}  // namespace weft::bench
