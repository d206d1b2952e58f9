// Products with a symmetric block matrix, several rows at a time.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "bsi/detail/aligned_vector.h"
#include "materials/lanes.h"
#include "sim/matrix/block_matrix.h"

namespace weft::sim {

// A copy of a symmetric matrix in diagonal storage. In an image, particles that follow each other
// couple with the same neighbours: row i has blocks in the columns i + d for the same distances d.
// Blocks of a diagonal d >= 0 lie side by side, entry by entry, so that a product handles
// materials::lane_count rows at once, one per lane. Blocks below the diagonal are read as the
// transposes of those above. Rows whose neighbours follow no such pattern are multiplied by the
// matrix itself, one by one.
class DiagonalStorage {
 public:
  DiagonalStorage() = default;
  explicit DiagonalStorage(std::shared_ptr<const BlockPattern> pattern);

  bool is_empty() const { return pattern_ == nullptr; }
  // Returns the number of rows that a product handles several at a time.
  int grouped_rows() const;
  // Copies the blocks of the matrix, which has the pattern of this object. O(blocks), about the
  // cost of three products.
  void assign(const SingleBlockMatrix& matrix, int threads);
  // Computes out = matrix * in, summed in double. Preconditions: assign() was called with this
  // matrix, and `in` and `out` have one entry per row. O(blocks).
  void multiply(const SingleBlockMatrix& matrix, std::span<const Vec3> in, std::span<Vec3> out,
                int threads) const;

 private:
  static constexpr int lane_count = materials::lane_count;
  static constexpr int rows_per_tile = 64;
  // A tile also stores the first rows of the next one. Any lane_count rows that begin in a tile
  // then lie side by side.
  static constexpr int stored_rows = rows_per_tile + lane_count;

  // The blocks on and above the diagonal in rows_per_tile rows, by diagonal, entry and row.
  struct Tile {
    std::vector<int> diagonals;  // ascending; empty if the rows have too little in common
    std::ptrdiff_t first_value = 0;
  };
  // A block of each row of a group: rows `row` to `row` + lane_count - 1.
  struct Term {
    std::ptrdiff_t value = 0;  // index of the first entry of the first row's block
    int column = 0;            // of the first row's block
  };
  // The terms of lane_count rows. Those of blocks below the diagonal come first.
  struct Group {
    int first_term = 0, first_upper_term = 0, end_term = 0;
    bool is_empty() const { return first_term == end_term; }
  };

  void find_tiles();
  void find_groups();
  bool add_terms(int row);
  std::ptrdiff_t find_value(int row, int diagonal) const;
  void copy_tile(const SingleBlockMatrix& matrix, int index);
  void multiply_group(int index, std::span<Vec3> out) const;

  std::shared_ptr<const BlockPattern> pattern_;
  std::vector<Tile> tiles_;
  bsi::AlignedVector<float> values_;
  std::vector<Group> groups_;
  std::vector<Term> terms_;
  // Scratch of multiply(): the components of `in`. Lanes without a block read the zeros that
  // follow.
  mutable std::array<std::vector<double>, 3> in_;
};

}  // namespace weft::sim
