// Ranges of rows or columns, as case files give them.
#pragma once

#include <string>
#include <vector>

#include "sim/case/case.h"

namespace weft::sim {

struct IndexRange {
  int first = 0, last = -1;  // both belong to the range
};

// Returns the range [first, last] in an image of `count` rows or columns. Negative numbers count
// from the end; an empty `range` selects all. Throws CaseError at `location` if the range lies
// outside the image or first > last. `owner` and `axis` name the range in the message, as in "pin
// rows".
IndexRange resolve_range(const std::vector<int>& range, int count, const std::string& owner,
                         const std::string& axis, const SourceLocation& location);

}  // namespace weft::sim
