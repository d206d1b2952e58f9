#include "sim/scene/index_range.h"

#include "sim/case/case_error.h"

namespace weft::sim {

IndexRange resolve_range(const std::vector<int>& range, int count, const std::string& owner,
                         const std::string& axis, const SourceLocation& location) {
  if (range.empty()) return {0, count - 1};
  const auto from_end = [&](int i) { return i < 0 ? i + count : i; };
  const IndexRange resolved{from_end(range.front()), from_end(range.back())};
  if (resolved.first < 0 || resolved.last >= count || resolved.first > resolved.last) {
    throw CaseError(location,
                    owner + " " + axis + " [" + std::to_string(range.front()) + ", " +
                        std::to_string(range.back()) + "] lie outside the image",
                    "expected first <= last within 0.." + std::to_string(count - 1) +
                        ", or counted from the end: -1 is the last");
  }
  return resolved;
}

}  // namespace weft::sim
