// How the quads of an atlas are split into the nested blocks of a pyramid: the numbers alone,
// shared by every hierarchy over the atlas, on the CPU and the GPU.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "bsi/geometry_image.h"

namespace weft::bsi {

// ceil(log2(count)), count >= 1.
inline int ceil_log2(int count) {
  return static_cast<int>(std::bit_width(static_cast<unsigned>(count) - 1));
}

// Boundary k of 2^log nested blocks of `count` items: floor(k * count / 2^log).
inline int block_boundary(int k, int count, int log) {
  return static_cast<int>((static_cast<std::int64_t>(k) * count) >> log);
}

// Quads [row_begin, row_end) x [col_begin, col_end) of a patch.
struct QuadRange {
  int row_begin = 0, row_end = 0;
  int col_begin = 0, col_end = 0;
  bool empty() const { return row_begin == row_end || col_begin == col_end; }
  bool operator==(const QuadRange&) const = default;
};

// The 2^log_u x 2^log_v blocks of one level of a patch (u along columns, v along rows), numbered
// row by row from `first` on, in the order of patches and levels.
struct BlockLevel {
  std::size_t first = 0;
  int log_u = 0;
  int log_v = 0;
  std::size_t count() const { return std::size_t{1} << (log_u + log_v); }
  std::size_t block(int u, int v) const {
    return first + (static_cast<std::size_t>(v) << log_u) + static_cast<std::size_t>(u);
  }
};

// Level l splits the quads of a patch into up to 2^l x 2^l nested blocks, each axis stopping at
// ceil(log2 of its quads); block boundaries are block_boundary(k, quads, log). The last level has
// blocks of one quad or, where the quads of an axis are not a power of two, of none; no block of
// the levels above is empty.
//
// Above the patch tops of an atlas of several patches stand group_levels() more levels: level k has
// 2^k groups, which join the patches from block_boundary(i, patches, k) to the next boundary, never
// none.
class BlockLevels {
 public:
  BlockLevels() = default;
  explicit BlockLevels(const Atlas& atlas);

  int patch_count() const { return static_cast<int>(first_level_.size()) - 1; }
  int levels(int patch) const { return first_level_[patch + 1] - first_level_[patch]; }
  const BlockLevel& at(int patch, int level) const { return table_[first_level_[patch] + level]; }
  // Blocks of all levels of all patches.
  std::size_t block_count() const {
    return table_.empty() ? 0 : table_.back().first + table_.back().count();
  }
  QuadRange quads(int patch, int level, int u, int v) const;

  int group_levels() const { return group_levels_; }
  // First patch of a group and the one after its last.
  std::array<int, 2> patches_of_group(int level, int index) const {
    return {block_boundary(index, patch_count(), level),
            block_boundary(index + 1, patch_count(), level)};
  }

 private:
  std::vector<std::array<int, 2>> quads_;  // by patch: rows and columns
  std::vector<int> first_level_{0};        // by patch, into table_
  std::vector<BlockLevel> table_;
  int group_levels_ = 0;
};

}  // namespace weft::bsi
