// Checks the rules of a case that compare one value with another.
#pragma once

#include <string>

#include "sim/case/case.h"
#include "sim/case/case_locations.h"

namespace weft::sim {

// Throws CaseError, placed at the value that breaks a rule. Preconditions: every single value is
// within its limits (case_schema.h), and every body has the name of a material.
void check_case(const Case& target, const Locations& locations);

// Returns the largest time.position_tolerance (m) at which contact is reliable; infinite without
// contact.
double position_tolerance_limit(const Case& target);

// Returns a notice if the fixed step is longer than the time between frames, else nothing.
std::string long_step_notice(const TimeCase& time);
// Returns a notice about the first pin whose hold_time or release_time is not within the run, else
// nothing.
std::string late_pins_notice(const Case& target);

}  // namespace weft::sim
