// The order in which matrices of 3x3 blocks store their entries, by diagonal.
#pragma once

#include <span>
#include <vector>

#include "materials/lanes.h"

namespace weft::sim {

class BlockPattern;

// In an image, particles that follow each other couple with the same neighbours: row i of a matrix
// has blocks in the columns i + d for the same distances d. Blocks of a diagonal d >= 0 therefore
// lie side by side, entry by entry, and the same entry of the blocks of consecutive rows is read
// and written as a vector. Blocks below the diagonal are the transposes of those above.
//
// The rows are divided into tiles. Blocks on diagonals that few rows of their tile share, as those
// of seams and ties, are stored one after the other: they are loose.
class BlockLayout {
 public:
  static constexpr int rows_per_tile = 256;
  // Number of entries, always zero, on either side of those of a tile's diagonal. A vector that
  // begins or ends outside of the tile can therefore be read.
  static constexpr int margin = 16;
  // Distance between the entries of a block in a tile with diagonals.
  static constexpr int stride = rows_per_tile + 2 * margin;

  // O(blocks). Throws std::bad_alloc if an int might not number all entries: a matrix of 16 GiB, or
  // somewhat less.
  explicit BlockLayout(const BlockPattern& pattern);

  // Returns the number of entries, zeros of margins and of missing blocks included.
  int size() const { return size_; }
  // Returns the place of the first entry of an upper block. The nine entries, column by column, lie
  // at the places first + i * stride_at(first).
  int first(int upper) const { return first_[upper]; }
  int stride_at(int first) const { return first < end_of_tiles_ ? stride : 1; }

  // A block of each of several consecutive rows.
  struct Term {
    int first = 0;   // place of the first entry of the first row's block
    int column = 0;  // of the first row's block, from -margin on
  };
  // The terms of a product for several consecutive rows, without loose blocks. Those of blocks
  // below the diagonal come first.
  struct Group {
    int first_term = 0, first_upper_term = 0, end_term = 0;
  };
  // Groups of `size` rows each. Rows left over at the end belong to none.
  struct Groups {
    int size = 0;
    std::vector<Group> groups;
    std::vector<Term> terms;
  };
  // Returns the groups of as many rows as there are numbers of this type in a vector register.
  const Groups& groups_for(double) const { return by_doubles_; }
  const Groups& groups_for(float) const { return by_floats_; }
  // A loose block of a row, on either side of the diagonal. Below the diagonal, `first` is the
  // place of the block above it whose transpose it is.
  struct Loose {
    int first = 0, column = 0;
  };
  // Returns the loose blocks of the rows from `row` to `end` - 1, row by row.
  std::span<const Loose> loose_of(int row, int end) const {
    return std::span(loose_).subspan(loose_start_[row], loose_start_[end] - loose_start_[row]);
  }
  // Returns the least number of zeros that must follow a vector of the matrix, so that products by
  // groups may read it at the columns of all terms.
  int numbers_after() const { return farthest_ + margin; }

 private:
  struct Tile {
    std::vector<int> diagonals;  // ascending
    int first = 0;               // place of the first entry
  };

  void find_tiles(const BlockPattern& pattern);
  void place_blocks(const BlockPattern& pattern);
  void list_loose_blocks(const BlockPattern& pattern);
  Groups groups_of(const BlockPattern& pattern, int size) const;
  void add_terms(const BlockPattern& pattern, int row, int size, std::vector<Term>& terms) const;
  void add_lower_terms(int row, int size, int diagonal, std::vector<Term>& terms) const;
  int find(int tile, int diagonal, int row) const;

  std::vector<Tile> tiles_;
  std::vector<int> first_;        // by upper block
  std::vector<int> loose_start_;  // by row, and the end
  std::vector<Loose> loose_;
  int size_ = 0, end_of_tiles_ = 0, farthest_ = 0;
  Groups by_doubles_, by_floats_;
};

}  // namespace weft::sim
