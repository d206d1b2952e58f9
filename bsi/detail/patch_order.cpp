#include "bsi/detail/patch_order.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "bsi/detail/block_levels.h"

namespace weft::bsi {

namespace {

// Sorts the patches of a group along the longest side of the box around their positions. The two
// halves of the group then lie side by side.
void sort_group(std::span<const std::array<float, 3>> places, std::span<std::int32_t> group) {
  float longest = -1;
  int along = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [low, high] = std::ranges::minmax_element(
        group, {}, [&](std::int32_t patch) { return places[patch][axis]; });
    const float side = places[*high][axis] - places[*low][axis];
    if (side > longest) along = axis;
    longest = std::max(longest, side);
  }
  std::ranges::sort(group, {},
                    [&](std::int32_t patch) { return std::pair(places[patch][along], patch); });
}

}  // namespace

std::vector<std::int32_t> order_by_place(std::span<const std::array<float, 3>> places) {
  const int patches = static_cast<int>(places.size());
  std::vector<std::int32_t> order(places.size());
  std::iota(order.begin(), order.end(), 0);
  for (int level = 0; level < group_levels_above(patches); ++level) {
    for (int u = 0; u < 1 << level; ++u) {
      const auto [begin, end] = group_range(patches, level, u);
      sort_group(places, std::span(order).subspan(begin, end - begin));
    }
  }
  return order;
}

}  // namespace weft::bsi
