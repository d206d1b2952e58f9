// The contacts that a sweep has to solve again.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace weft::sim {

// A queue of rows, each of one sphere or two, in ascending order. It holds the rows of spheres that
// have changed since the row was solved, so that sweeps skip regions that have converged. Rows are
// numbered in the order in which they are added.
class RowQueue {
 public:
  // Removes all rows, and begins with a number of spheres.
  void clear(int spheres) {
    last_row_.assign(spheres, none);
    next_.clear();
    words_.clear();
  }
  // Adds a row, and puts it into the queue. `other` is negative if there is no second sphere.
  void add(int sphere, int other) {
    const int row = static_cast<int>(next_.size() / 2);
    next_.push_back(last_row_[sphere]);
    last_row_[sphere] = 2 * row;
    next_.push_back(other < 0 ? none : last_row_[other]);
    if (other >= 0) last_row_[other] = 2 * row + 1;
    if (row % 64 == 0) words_.push_back(0);
    push(row);
  }
  // Puts all rows of a sphere into the queue.
  void push_rows_of(int sphere) {
    for (int side = last_row_[sphere]; side != none; side = next_[side]) push(side / 2);
  }
  void remove(int row) { words_[row / 64] &= ~(std::uint64_t{1} << row % 64); }
  // Calls `solve` with each row of the queue in ascending order, after it has been removed. Rows
  // that come into the queue meanwhile take part if they come later in the order. Returns false if
  // the queue was empty.
  template <class Solve>
  bool sweep(const Solve& solve) {
    bool is_any = false;
    for (std::size_t k = 0; k < words_.size(); ++k) {
      std::uint64_t rest = words_[k];
      while (rest != 0) {
        is_any = true;
        const int bit = std::countr_zero(rest);
        const int row = static_cast<int>(64 * k) + bit;
        remove(row);
        solve(row);
        rest = bit == 63 ? 0 : words_[k] & ~std::uint64_t{0} << (bit + 1);
      }
    }
    return is_any;
  }

 private:
  static constexpr int none = -1;

  void push(int row) { words_[row / 64] |= std::uint64_t{1} << row % 64; }

  std::vector<int> last_row_;         // by sphere: the last side of a row, 2 row or 2 row + 1
  std::vector<int> next_;             // by side: the side of the same sphere before
  std::vector<std::uint64_t> words_;  // one bit per row
};

}  // namespace weft::sim
