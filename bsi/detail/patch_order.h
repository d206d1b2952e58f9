// Orders the patches of a body so that each group is a contiguous range of nearby patches. For the
// CPU and the device.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace weft::bsi {

// Returns the patches in the order of their groups. `places` holds a position per patch, in any
// unit. Each group is split along the longest side of the box around its patches' positions.
// O(patches log^2 patches).
std::vector<std::int32_t> order_by_place(std::span<const std::array<float, 3>> places);

}  // namespace weft::bsi
