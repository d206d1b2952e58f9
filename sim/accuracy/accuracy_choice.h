// Chooses a method and its setting for a given accuracy. The choice is based on measurements that
// ship with the source: calibration_table.inc, written by `weft bench calibrate`.
#pragma once

#include <span>
#include <string>

#include "sim/case/case.h"

namespace weft::sim {

// A method that can be set for an accuracy, by a tolerance (m) or by a step (s).
struct CalibratedMethod {
  const char* name;
  TimeMethod method;
  bool by_step;
};
std::span<const CalibratedMethod> calibrated_methods();

// Sets the method and the options that belong to its setting. A tolerance becomes
// position_tolerance and, in proportion, relative_tolerance (at most 0.1). A step comes with one
// Newton iteration, whose linear system is solved far more exactly than the step itself.
void apply_setting(TimeCase& time, const CalibratedMethod& method, double setting);

// True if there is contact and more than one body or obstacle. Errors then grow faster, so such
// scenes have their own rows in the table.
bool has_meetings(const Case& source);

// One measurement. Errors grow with the simulated time, and the setting determines their rate of
// growth.
struct CalibrationRow {
  const char* method;
  bool meetings;
  double setting;     // m or s; ascending within a method
  double error_rate;  // m/s: largest error of a run (accuracy in case.h) over its duration
  double factor;      // nine of ten scenes had this rate within this factor
  double cost;        // s of CPU per simulated second, mean over the scenes; for comparison
};

// error_rate_at() returns the error rate (m/s) that the table gives for the method of `source` at a
// tolerance (m). tolerance_at() returns the tolerance for an error rate, at most the table's
// coarsest one and the limit that contact sets. Beyond the table's ends, errors grow with the power
// 2/3 of the tolerance. Precondition: the table has rows by tolerance for the method.
double error_rate_at(const Case& source, double tolerance);
double tolerance_at(const Case& source, double error_rate);
// True if choose_accuracy() has set a tolerance and not a step.
bool has_chosen_tolerance(const Case& source);

// Applies `time.accuracy` if it is given and not settled yet. Chooses the cheapest method whose
// CalibrationRow::factor is at most 3. Without such a method, chooses the one with the smallest
// factor. Keeps a method that the case names. Tolerances stay within the limit that contact sets.
// Writes the choice to Case::accuracy_choice. Throws CaseError, with the table's range, for an
// accuracy that the table does not cover. Also throws it for a method without calibration.
void choose_accuracy(Case& target);

}  // namespace weft::sim
