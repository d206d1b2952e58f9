#include "sim/forces/block_matrix.h"

#include <algorithm>
#include <cassert>

#include "sim/parallel.h"

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
}

int BlockPattern::slot(int row, int column) const {
  const auto begin = column_.begin() + row_start_[row];
  const auto end = column_.begin() + row_start_[row + 1];
  const auto found = std::lower_bound(begin, end, column);
  assert(found != end && *found == column);
  return static_cast<int>(found - column_.begin());
}

BlockMatrix::BlockMatrix(std::shared_ptr<const BlockPattern> pattern)
    : pattern_(std::move(pattern)),
      values_(9 * static_cast<std::size_t>(pattern_->block_count())) {}

void BlockMatrix::set_zero() { std::fill(values_.begin(), values_.end(), 0.0); }

void BlockMatrix::multiply(std::span<const Vec3> in, std::span<Vec3> out, int threads) const {
  assert(static_cast<int>(in.size()) == pattern_->rows() && in.size() == out.size());
  const BlockPattern& pattern = *pattern_;
  parallel_chunks(pattern.rows(), threads, [&](int first, int last) {
    for (int row = first; row < last; ++row) {
      double sum0 = 0, sum1 = 0, sum2 = 0;
      for (int slot = pattern.row_begin(row); slot < pattern.row_end(row); ++slot) {
        const double* value = values_.data() + 9 * static_cast<std::size_t>(slot);
        const Vec3& x = in[pattern.column(slot)];
        sum0 += value[0] * x[0] + value[3] * x[1] + value[6] * x[2];
        sum1 += value[1] * x[0] + value[4] * x[1] + value[7] * x[2];
        sum2 += value[2] * x[0] + value[5] * x[1] + value[8] * x[2];
      }
      out[row] = Vec3(sum0, sum1, sum2);
    }
  });
}

}  // namespace weft::sim
