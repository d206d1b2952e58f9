// Ranges of rows and columns as cases give them.
#pragma once

#include <string>
#include <vector>

#include "sim/case/case.h"

namespace weft::sim {

struct IndexRange {
  int first = 0, last = -1;  // both within the range
};

// Returns the range of [first, last], negative from the end, in an image of `count` rows or
// columns; all of them if it is empty. Throws CaseError at `location` if it lies outside; `owner`
// and `axis` name it, as in "pin rows".
IndexRange resolve_range(const std::vector<int>& range, int count, const std::string& owner,
                         const std::string& axis, const SourceLocation& location);

}  // namespace weft::sim
