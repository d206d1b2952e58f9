// A roof that snaps through: its limit load, and its path by arc length and by displacement.
#pragma once

#include <vector>

#include "bench/case_check.h"

namespace weft::bench {

std::vector<CaseCheck> snap_through_checks();

}  // namespace weft::bench
