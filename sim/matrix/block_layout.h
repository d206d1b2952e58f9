// The order in which matrices of 3x3 blocks store their entries, by diagonal.
#pragma once

#include <vector>

#include "materials/lanes.h"

namespace weft::sim {

class BlockPattern;

// In an image, particles that follow each other couple with the same neighbours: row i of a matrix
// has blocks in the columns i + d for the same distances d. Blocks of a diagonal d >= 0 therefore
// lie side by side, entry by entry, and the same entry of the blocks of consecutive rows is read
// and written as a vector. Blocks below the diagonal are the transposes of those above.
//
// The rows are divided into tiles. Rows of a tile that have too few diagonals in common, as beside
// seams, store their blocks one after the other.
class BlockLayout {
 public:
  static constexpr int rows_per_tile = 128;
  // Number of entries, always zero, on either side of those of a tile's diagonal. A vector that
  // begins or ends outside of the tile can therefore be read.
  static constexpr int margin = 16;
  // Distance between the entries of a block in a tile with diagonals.
  static constexpr int stride = rows_per_tile + 2 * margin;

  // O(blocks). Throws std::bad_alloc if there are more entries than an int can number: a matrix of
  // 16 GiB.
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
  // The terms of a product for several consecutive rows. Those of blocks below the diagonal come
  // first. A group without terms has rows that must be multiplied one by one.
  struct Group {
    int first_term = 0, first_upper_term = 0, end_term = 0;
    bool is_empty() const { return first_term == end_term; }
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
  // Returns the least number of zeros that must follow a vector of the matrix, so that products by
  // groups may read it at the columns of all terms.
  int numbers_after() const { return farthest_ + margin; }

 private:
  struct Tile {
    std::vector<int> diagonals;  // ascending; empty if blocks are stored one after the other
    int first = 0;               // place of the first entry
  };

  void find_tiles(const BlockPattern& pattern);
  void place_blocks(const BlockPattern& pattern);
  Groups groups_of(const BlockPattern& pattern, int size) const;
  bool add_terms(const BlockPattern& pattern, int row, int size, std::vector<Term>& terms) const;
  bool add_lower_terms(const BlockPattern& pattern, int row, int size, int diagonal,
                       std::vector<Term>& terms) const;
  int find(int tile, int diagonal, int row) const;

  std::vector<Tile> tiles_;
  std::vector<int> first_;  // by upper block
  int size_ = 0, end_of_tiles_ = 0, farthest_ = 0;
  Groups by_doubles_, by_floats_;
};

}  // namespace weft::sim
