// The pattern of matrices of 3x3 blocks over particles, and matrices that are stored row by row.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "sim/base/vectors.h"
#include "sim/matrix/block_layout.h"

namespace weft::sim {

// The sparsity pattern: the pairs of coupled particles. Columns of a row are sorted; the diagonal
// is always present. All blocks are numbered row by row; this number is the block's slot. Blocks on
// and above the diagonal are called upper blocks. They are also numbered among themselves, row by
// row.
class BlockPattern {
 public:
  // `neighbours[i]` lists the particles coupled to particle i, in any order; repetitions are
  // allowed. Precondition: if j is in the list of i, i is in the list of j.
  explicit BlockPattern(const std::vector<std::vector<int>>& neighbours);

  int rows() const { return static_cast<int>(row_start_.size()) - 1; }
  int block_count() const { return row_start_.back(); }
  int row_begin(int row) const { return row_start_[row]; }
  int row_end(int row) const { return row_start_[row + 1]; }
  int column(int slot) const { return column_[slot]; }
  int diagonal_slot(int row) const { return diagonal_slot_[row]; }
  // Returns the slot of block (row, column). Precondition: the pattern contains the block.
  int slot(int row, int column) const;
  // Returns the slot of block (row, column), or -1 if the pattern does not contain the block.
  int find_slot(int row, int column) const;

  int upper_count() const { return block_count() - static_cast<int>(mirror_.size()); }
  int upper_diagonal(int row) const { return upper_start_[row]; }
  // Returns the number after that of the row's last upper block.
  int upper_end(int row) const {
    return upper_start_[row] + (row_start_[row + 1] - diagonal_slot_[row]);
  }
  // Returns the number of the upper block at a slot of `row`. If the slot is below the diagonal,
  // returns the number of the block's mirror image.
  int upper(int row, int slot) const {
    return slot >= diagonal_slot_[row] ? upper_start_[row] + (slot - diagonal_slot_[row])
                                       : mirror(row, slot);
  }
  // Returns the number of the mirror image of the block at a slot of `row` below the diagonal.
  int mirror(int row, int slot) const { return mirror_[slot - upper_start_[row]]; }

  // Returns the order of entries by diagonal. O(blocks) at the first call, O(1) later.
  const BlockLayout& layout() const {
    std::call_once(is_laid_out_, [this] { layout_ = std::make_unique<const BlockLayout>(*this); });
    return *layout_;
  }

 private:
  void find_mirrors();

  std::vector<int> row_start_, column_, diagonal_slot_;
  std::vector<int> upper_start_;  // by row: number of its diagonal block among the upper blocks
  std::vector<int> mirror_;       // by block below the diagonal: number of its mirror image
  mutable std::once_flag is_laid_out_;
  mutable std::unique_ptr<const BlockLayout> layout_;
};

// A symmetric matrix on a shared pattern, in single precision. It stores only the upper blocks, row
// by row, so that Gauss-Seidel sweeps read the blocks of a row together. Products are summed in
// double.
class SingleBlockMatrix {
 public:
  using Block = Eigen::Matrix3f;

  SingleBlockMatrix() = default;
  explicit SingleBlockMatrix(std::shared_ptr<const BlockPattern> pattern)
      : pattern_(std::move(pattern)),
        values_(9 * static_cast<std::size_t>(pattern_->upper_count()) + padding) {}

  bool is_empty() const { return pattern_ == nullptr; }
  const BlockPattern& pattern() const { return *pattern_; }
  const std::shared_ptr<const BlockPattern>& shared_pattern() const { return pattern_; }
  void set_zero(int threads);  // does nothing to an empty matrix
  Eigen::Map<Block> upper_block(int upper) { return Eigen::Map<Block>(at(upper)); }
  Eigen::Map<const Block> upper_block(int upper) const {
    return Eigen::Map<const Block>(at(upper));
  }
  Eigen::Map<const Block> diagonal_block(int row) const {
    return upper_block(pattern_->upper_diagonal(row));
  }
  // Returns the block at a slot of a row, on either side of the diagonal.
  Block block(int row, int slot) const {
    const auto stored = upper_block(pattern_->upper(row, slot));
    return slot < pattern_->diagonal_slot(row) ? Block(stored.transpose()) : Block(stored);
  }

  // lower_product() and upper_product() multiply the blocks at slots [first, last) of a row by the
  // entries of `in` for their columns, and return the sum. The slots are all below the diagonal, or
  // all on it and above. With `backward`, upper_product() adds from the last slot to the first.
  //
  // A block below the diagonal is the transpose of its mirror image. lower_product() therefore
  // multiplies the stored columns by x elementwise and adds the three components of each sum at the
  // end. Each of the three sums is initialised by its own Four::Zero(). If they were copies of one
  // vector, g++ 12 would copy it through memory, which takes a quarter of a product's time.
  Vec3 lower_product(int row, int first, int last, const Vec3* in) const {
    Four sum0 = Four::Zero(), sum1 = Four::Zero(), sum2 = Four::Zero();
    for (int slot = first; slot < last; ++slot) {
      const int upper = pattern_->mirror(row, slot);
      // Below the diagonal, the column is never the last particle. Reading four numbers is
      // therefore safe.
      const Four x = Eigen::Map<const Four>(in[pattern_->column(slot)].data());
      sum0 += four(upper, 0) * x;
      sum1 += four(upper, 1) * x;
      sum2 += four(upper, 2) * x;
    }
    return {sum0[0] + sum0[1] + sum0[2], sum1[0] + sum1[1] + sum1[2], sum2[0] + sum2[1] + sum2[2]};
  }
  template <bool backward = false>
  Vec3 upper_product(int row, int first, int last, const Vec3* in) const {
    Four sum0 = Four::Zero(), sum1 = Four::Zero(), sum2 = Four::Zero();
    const int to_upper = pattern_->upper_diagonal(row) - pattern_->diagonal_slot(row);
    for (int i = first; i < last; ++i) {
      const int slot = backward ? first + last - 1 - i : i;
      const Vec3& x = in[pattern_->column(slot)];
      sum0 += four(slot + to_upper, 0) * x[0];
      sum1 += four(slot + to_upper, 1) * x[1];
      sum2 += four(slot + to_upper, 2) * x[2];
    }
    sum0 += sum1 + sum2;
    return sum0.head<3>();
  }
  Vec3 row_product(int row, const Vec3* in) const {
    const int diagonal = pattern_->diagonal_slot(row);
    return lower_product(row, pattern_->row_begin(row), diagonal, in) +
           upper_product(row, diagonal, pattern_->row_end(row), in);
  }
  // Computes out = this * in. Precondition: `in` and `out` have one entry per row. O(blocks).
  void multiply(std::span<const Vec3> in, std::span<Vec3> out, int threads) const;

  // Prefetches the upper blocks of rows [first, last). This helps if rows are not visited in
  // ascending order, because the processor cannot predict such accesses. Row numbers outside the
  // matrix are ignored.
  void prefetch_rows(int first, int last) const {
    first = std::max(first, 0);
    last = std::min(last, pattern_->rows());
    if (first >= last) return;
    const float* const end = at(pattern_->upper_end(last - 1));
    constexpr int numbers_per_line = 64 / sizeof(float);
    for (const float* line = at(pattern_->upper_diagonal(first)); line < end;
         line += numbers_per_line)
      __builtin_prefetch(line);
  }

 private:
  // A column of a block is read as four numbers, of which the last is ignored.
  using Four = Eigen::Array4d;
  static constexpr std::size_t padding = 1;  // numbers at the end, read with the last column

  Four four(int upper, int column) const {
    return Eigen::Map<const Eigen::Array<float, 4, 1>>(at(upper) + 3 * column).cast<double>();
  }

  float* at(int upper) { return values_.data() + 9 * static_cast<std::size_t>(upper); }
  const float* at(int upper) const { return values_.data() + 9 * static_cast<std::size_t>(upper); }

  std::shared_ptr<const BlockPattern> pattern_;
  std::vector<float> values_;  // 9 per upper block, column-major
};

}  // namespace weft::sim
