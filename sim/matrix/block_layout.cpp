#include "sim/matrix/block_layout.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <new>

#include "sim/matrix/block_matrix.h"

namespace weft::sim {

namespace {

// Rows are stored and multiplied by diagonals if these have at most this many places for each block
// that there is: a product of several rows costs less than half of one for each row.
constexpr int most_places_per_block = 2;

void make_unique(std::vector<int>& numbers) {
  std::ranges::sort(numbers);
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

// Reduces the diagonals of the blocks of several rows to different ones in ascending order. Returns
// false if they have too many places for the blocks.
bool have_much_in_common(std::vector<int>& diagonals, int rows) {
  const std::size_t blocks = diagonals.size();
  make_unique(diagonals);
  return diagonals.size() * rows <= most_places_per_block * blocks;
}

}  // namespace

BlockLayout::BlockLayout(const BlockPattern& pattern) {
  static_assert(2 * materials::lane_count <= margin);
  find_tiles(pattern);
  place_blocks(pattern);
  by_doubles_ = groups_of(pattern, materials::lane_count);
  by_floats_ = groups_of(pattern, 2 * materials::lane_count);
}

void BlockLayout::find_tiles(const BlockPattern& pattern) {
  const int rows = pattern.rows();
  std::int64_t size = 0;
  for (int begin = 0; begin < rows; begin += rows_per_tile) {
    Tile& tile = tiles_.emplace_back();
    const int end = std::min(begin + rows_per_tile, rows);
    for (int row = begin; row < end; ++row) {
      for (int slot = pattern.diagonal_slot(row); slot < pattern.row_end(row); ++slot)
        tile.diagonals.push_back(pattern.column(slot) - row);
    }
    if (!have_much_in_common(tile.diagonals, end - begin)) tile.diagonals.clear();
    if (!tile.diagonals.empty()) farthest_ = std::max(farthest_, tile.diagonals.back());
    tile.first = static_cast<int>(size);
    size += std::int64_t{9} * stride * static_cast<std::int64_t>(tile.diagonals.size());
    if (size + std::int64_t{9} * pattern.upper_count() > std::numeric_limits<int>::max())
      throw std::bad_alloc();
  }
  end_of_tiles_ = static_cast<int>(size);
}

void BlockLayout::place_blocks(const BlockPattern& pattern) {
  first_.reserve(pattern.upper_count());
  size_ = end_of_tiles_;
  for (int row = 0; row < pattern.rows(); ++row) {
    const int tile = row / rows_per_tile;
    for (int slot = pattern.diagonal_slot(row); slot < pattern.row_end(row); ++slot) {
      const bool is_apart = tiles_[tile].diagonals.empty();
      first_.push_back(is_apart ? size_ : find(tile, pattern.column(slot) - row, row));
      if (is_apart) size_ += 9;
    }
  }
}

// Returns the place of the first entry of a row's block on a diagonal of a tile, or -1 if the tile
// does not store the diagonal. The row may lie up to `margin` outside of the tile.
int BlockLayout::find(int tile, int diagonal, int row) const {
  const std::vector<int>& diagonals = tiles_[tile].diagonals;
  const auto found = std::ranges::lower_bound(diagonals, diagonal);
  if (found == diagonals.end() || *found != diagonal) return -1;
  return tiles_[tile].first + static_cast<int>(found - diagonals.begin()) * 9 * stride + margin +
         (row - tile * rows_per_tile);
}

BlockLayout::Groups BlockLayout::groups_of(const BlockPattern& pattern, int size) const {
  static_assert(rows_per_tile % margin == 0);
  Groups result{size, {}, {}};
  std::vector<Term>& terms = result.terms;
  for (int row = 0; row + size <= pattern.rows(); row += size) {
    Group group;
    group.first_term = static_cast<int>(terms.size());
    if (!add_terms(pattern, row, size, terms)) terms.resize(group.first_term);
    group.end_term = static_cast<int>(terms.size());
    group.first_upper_term = group.first_term;
    while (group.first_upper_term < group.end_term && terms[group.first_upper_term].column < row)
      ++group.first_upper_term;
    result.groups.push_back(group);
  }
  return result;
}

// Adds the terms of the group that begins at `row`. Returns false if the rows have too little in
// common, or if a block is in no tile with diagonals.
bool BlockLayout::add_terms(const BlockPattern& pattern, int row, int size,
                            std::vector<Term>& terms) const {
  std::vector<int> diagonals;
  for (int i = row; i < row + size; ++i) {
    for (int slot = pattern.row_begin(i); slot < pattern.row_end(i); ++slot)
      diagonals.push_back(pattern.column(slot) - i);
  }
  if (!have_much_in_common(diagonals, size)) return false;
  for (const int diagonal : diagonals) {
    if (diagonal < 0) {
      if (!add_lower_terms(pattern, row, size, -diagonal, terms)) return false;
      continue;
    }
    const int first = find(row / rows_per_tile, diagonal, row);
    if (first < 0) return false;
    terms.push_back({first, row + diagonal});
  }
  return true;
}

// Adds the terms of blocks below the diagonal. Their mirror images belong to the rows `diagonal`
// above, which may lie in two tiles. Each of these has a term of its own, with zeros for the rows
// of the other.
bool BlockLayout::add_lower_terms(const BlockPattern& pattern, int row, int size, int diagonal,
                                  std::vector<Term>& terms) const {
  const int begin = row - diagonal;
  for (int above = std::max(begin, 0); above < begin + size;) {
    const int tile = above / rows_per_tile;
    const int end = std::min(begin + size, (tile + 1) * rows_per_tile);
    const int first = find(tile, diagonal, begin);
    if (first >= 0) {
      terms.push_back({first, begin});
    } else {
      for (; above < end; ++above) {
        if (pattern.find_slot(above, above + diagonal) >= 0) return false;
      }
    }
    above = end;
  }
  return true;
}

}  // namespace weft::sim
