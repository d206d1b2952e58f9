// Checks of a case that compare one value with another.
#pragma once

#include <string>

#include "sim/case/case.h"
#include "sim/case/case_locations.h"

namespace weft::sim {

// Throws CaseError, placed at the value that breaks a rule or at the header of the table that lacks
// a value. Preconditions: every single value is within its limits (case_schema.h), and
// BodyCase::material is set for every body.
void check_case(const Case& target, const Locations& locations);

// Returns the largest time.position_tolerance (m) at which contact is reliable, or infinity if
// contact is disabled.
double position_tolerance_limit(const Case& target);

// Returns a notice if the fixed step is longer than 1 / frames_per_second. Returns an empty string
// if it is not, or if no step is fixed.
std::string long_step_notice(const TimeCase& time);
// Returns a notice about the first pin whose hold_time or release_time is not before the end of the
// run. Returns an empty string if there is none.
std::string late_pins_notice(const Case& target);
// Returns a notice if the case asks for a device that has nothing to search. Returns an empty
// string if it does not.
std::string idle_device_notice(const Case& target);

}  // namespace weft::sim
