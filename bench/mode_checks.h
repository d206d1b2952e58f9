// Natural frequencies of plates and critical loads of plates and columns.
#pragma once

#include <vector>

#include "bench/case_check.h"

namespace weft::bench {

std::vector<CaseCheck> mode_checks();

}  // namespace weft::bench
