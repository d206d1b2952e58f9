// Ranges of rows or columns in case files.
#pragma once

#include <string>
#include <vector>

#include "sim/case/case.h"

namespace weft::sim {

struct IndexRange {
  int first = 0, last = -1;  // first and last index of the range, both included
};

// Returns the range that a case file gives as [first, last], in an image of `count` rows or
// columns. Negative numbers count from the end. An empty `range` selects all rows or columns.
// Throws CaseError at `location` if the range lies outside the image or if first > last. `owner`
// and `axis` name the range in the message, as in "pin rows".
IndexRange resolve_range(const std::vector<int>& range, int count, const std::string& owner,
                         const std::string& axis, const SourceLocation& location);

}  // namespace weft::sim
