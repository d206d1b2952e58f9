// Sparse matrices of 3x3 blocks over particles, with a fixed pattern.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <span>
#include <vector>

namespace weft::sim {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

// Which pairs of particles interact. Rows are sorted; the diagonal is always present.
class BlockPattern {
 public:
  // `neighbours[i]` lists the particles coupled to i, in any order, repetitions allowed.
  explicit BlockPattern(const std::vector<std::vector<int>>& neighbours);

  int rows() const { return static_cast<int>(row_start_.size()) - 1; }
  int block_count() const { return row_start_.back(); }
  int row_begin(int row) const { return row_start_[row]; }
  int row_end(int row) const { return row_start_[row + 1]; }
  int column(int slot) const { return column_[slot]; }
  int diagonal_slot(int row) const { return diagonal_slot_[row]; }
  // Slot of block (row, column). Precondition: it is in the pattern.
  int slot(int row, int column) const;

 private:
  std::vector<int> row_start_, column_, diagonal_slot_;
};

// Values of a symmetric matrix on a pattern shared with others; both halves are stored.
class BlockMatrix {
 public:
  BlockMatrix() = default;
  explicit BlockMatrix(std::shared_ptr<const BlockPattern> pattern);

  const BlockPattern& pattern() const { return *pattern_; }
  void set_zero();
  Eigen::Map<Mat3> block(int slot) { return Eigen::Map<Mat3>(values_.data() + 9 * slot); }
  Eigen::Map<const Mat3> block(int slot) const {
    return Eigen::Map<const Mat3>(values_.data() + 9 * slot);
  }
  std::span<double> values() { return values_; }
  std::span<const double> values() const { return values_; }

  // out = this * in. Sizes: rows() each. O(blocks).
  void multiply(std::span<const Vec3> in, std::span<Vec3> out, int threads) const;

 private:
  std::shared_ptr<const BlockPattern> pattern_;
  std::vector<double> values_;  // 9 a slot, column-major
};

}  // namespace weft::sim
