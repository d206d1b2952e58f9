// Shells that fall on other bodies: crossings, none allowed, and CPU time per simulated second.
#pragma once

#include <vector>

#include "bench/table_part.h"

namespace weft::bench {

std::vector<TablePart> shell_drops();

}  // namespace weft::bench
