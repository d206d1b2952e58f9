// The rules of a case that compare one value with another.
#pragma once

#include <string>

#include "sim/case/case.h"
#include "sim/case/case_locations.h"

namespace weft::sim {

// Throws CaseError at the value that breaks a rule. Every value alone is within its limits
// (case_schema.h) and every body has the name of a material already.
void check_case(const Case& target, const Locations& locations);

// The largest time.position_tolerance with which contact is sound, m; infinite without contact.
double position_tolerance_limit(const Case& target);

// Notice for a step that is longer than the time between frames; empty for others.
std::string long_step_notice(const TimeCase& time);

}  // namespace weft::sim
