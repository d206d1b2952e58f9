// Shells under loads against closed forms and published figures.
#pragma once

#include <vector>

#include "bench/case_check.h"

namespace weft::bench {

std::vector<CaseCheck> strip_checks();  // strips and narrow sheets
std::vector<CaseCheck> shell_checks();  // plates and curved shells

}  // namespace weft::bench
