// Cloth and shells that bend, in every direction of their grid.
#pragma once

#include <vector>

#include "bench/case_check.h"

namespace weft::bench {

std::vector<CaseCheck> cloth_checks();

}  // namespace weft::bench
