#include "sim/matrix/block_matrix.h"

#include <algorithm>
#include <cassert>

#include "sim/base/parallel.h"

namespace weft::sim {

BlockPattern::BlockPattern(const std::vector<std::vector<int>>& neighbours) {
  const int count = static_cast<int>(neighbours.size());
  row_start_.reserve(count + 1);
  row_start_.push_back(0);
  std::vector<int> row;
  for (int i = 0; i < count; ++i) {
    row = neighbours[i];
    row.push_back(i);
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    const auto diagonal = std::lower_bound(row.begin(), row.end(), i) - row.begin();
    diagonal_slot_.push_back(static_cast<int>(column_.size() + diagonal));
    column_.insert(column_.end(), row.begin(), row.end());
    row_start_.push_back(static_cast<int>(column_.size()));
  }
  find_mirrors();
}

// Finds the mirror image of every block below the diagonal. Rows are visited in ascending order.
// The blocks that mirror one row's upper blocks are then met in ascending order, so one counter per
// row is enough.
void BlockPattern::find_mirrors() {
  std::vector<int> next;  // by row: the upper block whose mirror image is met next
  for (int row = 0; row < rows(); ++row) {
    for (int slot = row_start_[row]; slot < diagonal_slot_[row]; ++slot) {
      assert(next[column_[slot]] <
             upper_start_[column_[slot]] + row_end(column_[slot]) - diagonal_slot_[column_[slot]]);
      mirror_.push_back(next[column_[slot]]++);
    }
    upper_start_.push_back(diagonal_slot_[row] - static_cast<int>(mirror_.size()));
    next.push_back(upper_start_.back() + 1);
  }
}

int BlockPattern::find_slot(int row, int column) const {
  const auto begin = column_.begin() + row_start_[row];
  const auto end = column_.begin() + row_start_[row + 1];
  const auto found = std::lower_bound(begin, end, column);
  return found != end && *found == column ? static_cast<int>(found - column_.begin()) : -1;
}

int BlockPattern::slot(int row, int column) const {
  const int found = find_slot(row, column);
  assert(found >= 0);
  return found;
}

void SingleBlockMatrix::set_zero(int threads) {
  if (is_empty()) return;
  parallel_chunks(pattern_->rows(), threads, [&](int first, int last) {
    std::fill(at(pattern_->upper_diagonal(first)), at(pattern_->upper_end(last - 1)), 0.0F);
  });
}

void SingleBlockMatrix::multiply(std::span<const Vec3> in, std::span<Vec3> out, int threads) const {
  assert(static_cast<int>(in.size()) == pattern_->rows() && in.size() == out.size());
  parallel_chunks(pattern_->rows(), threads, [&](int first, int last) {
    for (int row = first; row < last; ++row) out[row] = row_product(row, in.data());
  });
}

}  // namespace weft::sim
