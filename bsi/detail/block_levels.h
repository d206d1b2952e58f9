// Nested blocks: rules by which a pyramid splits the quads of a patch and groups the patches of a
// body. For the CPU and the device.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

namespace weft::bsi {

// Returns ceil(log2(count)). Precondition: count >= 1.
inline int ceil_log2(int count) {
  return static_cast<int>(std::bit_width(static_cast<unsigned>(count) - 1));
}

// Returns floor(k * count / 2^log), boundary k of the 2^log nested blocks that divide `count`
// items.
inline int block_boundary(int k, int count, int log) {
  return static_cast<int>((static_cast<std::int64_t>(k) * count) >> log);
}

// A rectangle of quads of a patch: rows [row_begin, row_end) and columns [col_begin, col_end).
struct QuadRange {
  int row_begin = 0, row_end = 0;
  int col_begin = 0, col_end = 0;
  bool empty() const { return row_begin == row_end || col_begin == col_end; }
  bool operator==(const QuadRange&) const = default;
};

// One level of a patch, with 2^log_u x 2^log_v blocks (u along columns, v along rows). Blocks are
// numbered row by row, starting with `first`.
struct BlockLevel {
  std::size_t first = 0;
  int log_u = 0;
  int log_v = 0;
  std::size_t count() const { return std::size_t{1} << (log_u + log_v); }
  std::size_t block(int u, int v) const {
    return first + (static_cast<std::size_t>(v) << log_u) + static_cast<std::size_t>(u);
  }
};

// Returns the number of levels of groups above `patches` patches. Level k has 2^k groups.
inline int group_levels_above(int patches) { return ceil_log2(patches); }

// The patches of a group: items [begin, end) of the ordered list of patches. No group is empty, and
// groups of one level differ in size by at most one patch.
struct GroupRange {
  int begin = 0, end = 0;
};
inline GroupRange group_range(int patches, int level, int u) {
  return {block_boundary(u, patches, level), block_boundary(u + 1, patches, level)};
}

}  // namespace weft::bsi
