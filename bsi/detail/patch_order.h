// The order of a body's patches in which each group is a run of neighbouring patches. The CPU and
// the device share this rule.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace weft::bsi {

// Returns the patches in the order of their groups. Each group is split along the longest side of
// the box around its patches' places. `places` may be in any unit. O(patches log^2 patches).
std::vector<std::int32_t> order_by_place(std::span<const std::array<float, 3>> places);

}  // namespace weft::bsi
