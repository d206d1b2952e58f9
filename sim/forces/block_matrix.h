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
  // The same, or -1 where it is not.
  int find_slot(int row, int column) const;

 private:
  std::vector<int> row_start_, column_, diagonal_slot_;
};

// Values of a symmetric matrix on a pattern shared with others; both halves are stored. In double,
// or in float to halve the traffic where a preconditioner needs no more.
template <class Scalar>
class BlockMatrixOf {
 public:
  using Block = Eigen::Matrix<Scalar, 3, 3>;

  BlockMatrixOf() = default;
  explicit BlockMatrixOf(std::shared_ptr<const BlockPattern> pattern);

  const BlockPattern& pattern() const { return *pattern_; }
  const std::shared_ptr<const BlockPattern>& shared_pattern() const { return pattern_; }
  void set_zero();
  Eigen::Map<Block> block(int slot) { return Eigen::Map<Block>(at(slot)); }
  Eigen::Map<const Block> block(int slot) const { return Eigen::Map<const Block>(at(slot)); }
  std::span<Scalar> values() { return std::span(values_).first(values_.size() - padding); }
  std::span<const Scalar> values() const {
    return std::span(values_).first(values_.size() - padding);
  }

  // Sum of the blocks of slots [first, last), of one row, times what `in` has for their columns;
  // from the last slot to the first where `backward`.
  template <bool backward = false>
  Vec3 partial_row_product(int first, int last, const Vec3* in) const {
    // A column of a block is a vector of four, the last of which is ignored.
    Eigen::Array4d sum0 = Eigen::Array4d::Zero(), sum1 = sum0, sum2 = sum0;
    for (int i = first; i < last; ++i) {
      const int slot = backward ? first + last - 1 - i : i;
      const Scalar* value = at(slot);
      const Vec3& x = in[pattern_->column(slot)];
      sum0 += four(value) * x[0];
      sum1 += four(value + 3) * x[1];
      sum2 += four(value + 6) * x[2];
    }
    sum0 += sum1 + sum2;
    return sum0.template head<3>();
  }
  // Asks for the blocks of slots [first, last) ahead of time, where rows are not read one after
  // the other from first to last and the processor does not foresee it. Slots beyond the ends are
  // allowed.
  void prefetch(int first, int last) const {
    const auto* const begin = reinterpret_cast<const char*>(values_.data());
    const std::ptrdiff_t bytes_a_block = 9 * sizeof(Scalar);
    for (std::ptrdiff_t at = first * bytes_a_block; at < last * bytes_a_block; at += 64)
      __builtin_prefetch(begin + at);
  }
  Vec3 row_product(int row, const Vec3* in) const {
    return partial_row_product(pattern_->row_begin(row), pattern_->row_end(row), in);
  }

  // out = this * in. Sizes: rows() each. O(blocks).
  void multiply(std::span<const Vec3> in, std::span<Vec3> out, int threads) const;

 private:
  static constexpr std::size_t padding = 1;  // so that the last column can be read as four

  Scalar* at(int slot) { return values_.data() + 9 * static_cast<std::size_t>(slot); }
  const Scalar* at(int slot) const { return values_.data() + 9 * static_cast<std::size_t>(slot); }
  static Eigen::Array4d four(const Scalar* value) {
    return Eigen::Map<const Eigen::Array<Scalar, 4, 1>>(value).template cast<double>();
  }

  std::shared_ptr<const BlockPattern> pattern_;
  std::vector<Scalar> values_ = std::vector<Scalar>(padding);  // 9 a slot, column-major
};
using BlockMatrix = BlockMatrixOf<double>;
using SingleBlockMatrix = BlockMatrixOf<float>;

}  // namespace weft::sim
