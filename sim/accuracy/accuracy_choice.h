// Chooses a method and its setting for an accuracy that is asked for. The choice uses measurements
// that ship with the source: calibration_table.inc, written by `weft bench calibrate`.
#pragma once

#include <span>
#include <string>

#include "sim/case/case.h"

namespace weft::sim {

// A method as it can be set for an accuracy: by a tolerance (m) or by a step (s).
struct CalibratedMethod {
  const char* name;
  TimeMethod method;
  bool by_step;
};
std::span<const CalibratedMethod> calibrated_methods();

// Sets the method and the options that go with its setting. A tolerance sets that of positions and,
// in proportion, those of speeds. A step comes with one Newton iteration solved far below its own
// error.
void apply_setting(TimeCase& time, const CalibratedMethod& method, double setting);

// True if bodies may meet something other than themselves. Errors then grow faster, so that such
// scenes have a table of their own.
bool has_meetings(const Case& source);

// One measurement. Errors grow with the time simulated: what a setting determines is their rate.
struct CalibrationRow {
  const char* method;
  bool meetings;
  double setting;     // m or s; ascending within a method
  double error_rate;  // m/s: the largest error of a run (accuracy in case.h) over its duration
  double factor;      // within which nine of ten scenes had that rate
  double cost;        // s of CPU per simulated second, mean over the scenes: for comparison only
};

// error_rate_at() returns the error rate (m/s) of the method of `source` with a tolerance (m) by
// the table; tolerance_at() returns the tolerance for an error rate. Beyond the table's ends errors
// go with the 2/3rd power of the tolerance; tolerances are never coarser than the table's.
// Precondition: the table has the method by tolerances.
double error_rate_at(const Case& source, double tolerance);
double tolerance_at(const Case& source, double error_rate);
// True if choose_accuracy() has set a tolerance, not a step.
bool has_chosen_tolerance(const Case& source);

// Applies `time.accuracy`, if it is given and not settled yet. Chooses the cheapest method that is
// sure to a factor 3 or, where none is, the surest; a method that the case gives is kept. Describes
// the choice in Case::accuracy_choice. Tolerances stay within what contact allows. Throws CaseError
// for an accuracy outside the table (with its range) and for a method that is not in it.
void choose_accuracy(Case& target);

}  // namespace weft::sim
