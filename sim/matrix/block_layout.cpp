#include "sim/matrix/block_layout.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <new>

#include "sim/matrix/block_matrix.h"

namespace weft::sim {

namespace {

// A tile stores a diagonal if at least one in so many of its rows has a block on it. By its
// operations, a loose block costs about as much as so many places of a diagonal.
constexpr int most_places_per_block = 8;

void make_unique(std::vector<int>& numbers) {
  std::ranges::sort(numbers);
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

// Returns the different diagonals among those of the blocks of several rows that are not loose, in
// ascending order.
std::vector<int> shared_diagonals(std::vector<int> diagonals, int rows) {
  std::ranges::sort(diagonals);
  std::vector<int> shared;
  for (auto each = diagonals.begin(); each != diagonals.end();) {
    const auto next = std::upper_bound(each, diagonals.end(), *each);
    if ((next - each) * most_places_per_block >= rows) shared.push_back(*each);
    each = next;
  }
  return shared;
}

}  // namespace

BlockLayout::BlockLayout(const BlockPattern& pattern) {
  static_assert(2 * materials::lane_count <= margin);
  find_tiles(pattern);
  place_blocks(pattern);
  list_loose_blocks(pattern);
  by_doubles_ = groups_of(pattern, materials::lane_count);
  by_floats_ = groups_of(pattern, 2 * materials::lane_count);
}

void BlockLayout::find_tiles(const BlockPattern& pattern) {
  const int rows = pattern.rows();
  std::int64_t size = 0;
  for (int begin = 0; begin < rows; begin += rows_per_tile) {
    const int end = std::min(begin + rows_per_tile, rows);
    std::vector<int> diagonals;
    for (int row = begin; row < end; ++row) {
      for (int slot = pattern.diagonal_slot(row); slot < pattern.row_end(row); ++slot)
        diagonals.push_back(pattern.column(slot) - row);
    }
    Tile& tile = tiles_.emplace_back();
    tile.diagonals = shared_diagonals(std::move(diagonals), end - begin);
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
    for (int slot = pattern.diagonal_slot(row); slot < pattern.row_end(row); ++slot) {
      const int place = find(row / rows_per_tile, pattern.column(slot) - row, row);
      first_.push_back(place < 0 ? size_ : place);
      if (place < 0) size_ += 9;
    }
  }
}

void BlockLayout::list_loose_blocks(const BlockPattern& pattern) {
  loose_start_.reserve(pattern.rows() + 1);
  for (int row = 0; row < pattern.rows(); ++row) {
    loose_start_.push_back(static_cast<int>(loose_.size()));
    for (int slot = pattern.row_begin(row); slot < pattern.row_end(row); ++slot) {
      const int place = first(pattern.upper(row, slot));
      if (place >= end_of_tiles_) loose_.push_back({place, pattern.column(slot)});
    }
  }
  loose_start_.push_back(static_cast<int>(loose_.size()));
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
    add_terms(pattern, row, size, terms);
    group.end_term = static_cast<int>(terms.size());
    group.first_upper_term = group.first_term;
    while (group.first_upper_term < group.end_term && terms[group.first_upper_term].column < row)
      ++group.first_upper_term;
    result.groups.push_back(group);
  }
  return result;
}

// Adds the terms of the group that begins at `row`.
void BlockLayout::add_terms(const BlockPattern& pattern, int row, int size,
                            std::vector<Term>& terms) const {
  std::vector<int> diagonals;
  for (int i = row; i < row + size; ++i) {
    for (int slot = pattern.row_begin(i); slot < pattern.row_end(i); ++slot) {
      if (first(pattern.upper(i, slot)) < end_of_tiles_)
        diagonals.push_back(pattern.column(slot) - i);
    }
  }
  make_unique(diagonals);
  for (const int diagonal : diagonals) {
    if (diagonal < 0) {
      add_lower_terms(row, size, -diagonal, terms);
    } else {
      terms.push_back({find(row / rows_per_tile, diagonal, row), row + diagonal});
    }
  }
}

// Adds the terms of blocks below the diagonal. Their mirror images belong to the rows `diagonal`
// above, which may lie in two tiles. Each of these has a term of its own, with zeros for the rows
// of the other.
void BlockLayout::add_lower_terms(int row, int size, int diagonal, std::vector<Term>& terms) const {
  const int begin = row - diagonal, last = begin + size - 1;
  for (int tile = std::max(begin, 0) / rows_per_tile; tile <= last / rows_per_tile; ++tile) {
    const int place = find(tile, diagonal, begin);
    if (place >= 0) terms.push_back({place, begin});
  }
}

}  // namespace weft::sim
