// Chooses a method and its setting for a given accuracy. The choice is based on measurements that
// ship with the source: calibration_table.inc, written by `weft bench calibrate`.
#pragma once

#include <span>
#include <string>

#include "sim/case/case.h"

namespace weft::sim {

// A method whose accuracy is controlled by one setting: the length of fixed steps (s) if `by_step`,
// else a tolerance (m).
struct CalibratedMethod {
  const char* name;
  TimeMethod method;
  bool by_step;
};
std::span<const CalibratedMethod> calibrated_methods();

// Sets the method and the options that its setting determines. A tolerance determines
// position_tolerance and, in proportion, relative_tolerance (at most 0.1). A step determines the
// length of steps, one Newton iteration per step, and tolerances. These tolerances make the error
// of the linear solve much smaller than that of the step.
void apply_setting(TimeCase& time, const CalibratedMethod& method, double setting);

// Returns true if contact is enabled and the case has at least two bodies or obstacles. Errors then
// grow faster, so such scenes have rows of their own in the table.
bool has_meetings(const Case& source);

// The measured error and cost of a method with one setting. Errors grow with the simulated time,
// and the setting determines their rate of growth.
struct CalibrationRow {
  const char* method;
  bool meetings;
  double setting;     // tolerance (m) or step (s); ascending for equal `method` and `meetings`
  double error_rate;  // largest error during a run divided by the run's duration, m/s
  double factor;      // in nine of ten scenes, error_rate holds within this factor
  double cost;        // CPU time per simulated second, geometric mean of the scenes
};

// error_rate_at() returns the error rate (m/s) that the table gives for the method of `source` at a
// tolerance (m). tolerance_at() returns the tolerance for an error rate. It exceeds neither the
// table's largest tolerance nor the limit that contact sets. Beyond the table's ends, error rates
// are extrapolated as proportional to tolerance^(2/3). Precondition: the table has rows by
// tolerance for the method.
double error_rate_at(const Case& source, double tolerance);
double tolerance_at(const Case& source, double error_rate);
// Returns true if `time.accuracy` is given and choose_accuracy() has set a tolerance, not a step.
bool has_chosen_tolerance(const Case& source);

// Chooses the method and its setting if `time.accuracy` is given and no choice has been made yet.
// Chooses the cheapest method whose CalibrationRow::factor is at most 3. Without such a method,
// chooses the method with the smallest factor. A method that the case names is kept. Tolerances do
// not exceed the limit that contact sets. Writes the choice to Case::time, Case::accuracy_choice
// and Case::resolved_text. Throws CaseError if the table does not cover the accuracy, or has no
// rows for the method that the case names.
void choose_accuracy(Case& target);

}  // namespace weft::sim
