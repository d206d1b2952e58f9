// Symmetric matrices of 3x3 blocks that are assembled and multiplied several rows at a time.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "bsi/detail/aligned_vector.h"
#include "sim/matrix/block_layout.h"
#include "sim/matrix/block_matrix.h"

namespace weft::sim {

// A symmetric matrix on a shared pattern, in float or double. It stores only the upper blocks, by
// diagonal (BlockLayout).
template <class Number>
class TiledMatrix {
 public:
  using Block = Eigen::Matrix<Number, 3, 3>;
  using Strides = Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>;
  using BlockMap = Eigen::Map<Block, Eigen::Unaligned, Strides>;
  using ConstBlockMap = Eigen::Map<const Block, Eigen::Unaligned, Strides>;

  TiledMatrix() = default;
  // The matrix is zero.
  explicit TiledMatrix(std::shared_ptr<const BlockPattern> pattern);

  bool is_empty() const { return pattern_ == nullptr; }
  const BlockPattern& pattern() const { return *pattern_; }
  const std::shared_ptr<const BlockPattern>& shared_pattern() const { return pattern_; }
  void set_zero(int threads);  // does nothing to an empty matrix
  void scale(Number factor) {
    for (Number& value : values_) value *= factor;
  }
  // Sets this matrix to a * one + b * other. Precondition: all three have the same pattern.
  // O(blocks).
  void set_to_sum(double a, const TiledMatrix<double>& one, double b,
                  const TiledMatrix<double>& other, int threads);

  // The entries, in the order of the layout.
  Number* values() { return values_.data(); }
  const Number* values() const { return values_.data(); }
  // Return the block whose first entry has the place `first`.
  BlockMap block_at(int first) {
    const int stride = layout().stride_at(first);
    return BlockMap(values() + first, Strides(3 * stride, stride));
  }
  ConstBlockMap block_at(int first) const {
    const int stride = layout().stride_at(first);
    return ConstBlockMap(values() + first, Strides(3 * stride, stride));
  }
  BlockMap upper_block(int upper) { return block_at(layout().first(upper)); }
  ConstBlockMap upper_block(int upper) const { return block_at(layout().first(upper)); }
  ConstBlockMap diagonal_block(int row) const { return upper_block(pattern_->upper_diagonal(row)); }
  // Returns the block at a slot of a row, on either side of the diagonal.
  Block block(int row, int slot) const {
    const auto stored = upper_block(pattern_->upper(row, slot));
    return slot < pattern_->diagonal_slot(row) ? Block(stored.transpose()) : Block(stored);
  }

  // Computes out = this * in. Sums are of this matrix' type of numbers, but for loose blocks
  // (BlockLayout) and the last rows. Precondition: `in` and `out` have one entry per row.
  // O(blocks).
  void multiply(std::span<const Vec3> in, std::span<Vec3> out, int threads) const;

 private:
  template <class Other>
  friend class TiledMatrix;

  const BlockLayout& layout() const { return *layout_; }
  Vec3 row_product(int row, std::span<const Vec3> in) const;
  void multiply_group(int index, std::span<Vec3> out) const;
  void add_loose_product(int row, std::span<const Vec3> in, Vec3& out) const;

  std::shared_ptr<const BlockPattern> pattern_;
  const BlockLayout* layout_ = nullptr;  // of the pattern
  bsi::AlignedVector<Number> values_;
  // Scratch of multiply(): the components of `in`, with zeros before and after them.
  mutable std::array<std::vector<Number>, 3> in_;
};

using BlockMatrix = TiledMatrix<double>;

}  // namespace weft::sim
