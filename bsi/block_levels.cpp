#include "bsi/block_levels.h"

#include <algorithm>

namespace weft::bsi {

BlockLevels::BlockLevels(const Atlas& atlas) {
  std::size_t first = 0;
  for (const Patch& patch : atlas.patches()) {
    quads_.push_back({patch.quad_rows(), patch.quad_cols()});
    const int depth_u = ceil_log2(patch.quad_cols());
    const int depth_v = ceil_log2(patch.quad_rows());
    for (int level = 0; level <= std::max(depth_u, depth_v); ++level) {
      table_.push_back({first, std::min(level, depth_u), std::min(level, depth_v)});
      first += table_.back().count();
    }
    first_level_.push_back(static_cast<int>(table_.size()));
  }
  group_levels_ = patch_count() > 0 ? ceil_log2(patch_count()) : 0;
}

QuadRange BlockLevels::quads(int patch, int level, int u, int v) const {
  const BlockLevel& place = at(patch, level);
  const auto [rows, cols] = quads_[patch];
  return {block_boundary(v, rows, place.log_v), block_boundary(v + 1, rows, place.log_v),
          block_boundary(u, cols, place.log_u), block_boundary(u + 1, cols, place.log_u)};
}

}  // namespace weft::bsi
