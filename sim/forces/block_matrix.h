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

// Which pairs of particles interact. Rows are sorted; the diagonal is always present. Slots number
// the blocks row by row; those on the diagonal and above it, the upper ones, have a numbering of
// their own.
class BlockPattern {
 public:
  // `neighbours[i]` lists the particles coupled to i, in any order, repetitions allowed; whoever
  // is on the list of another has that one on its own.
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

  int upper_count() const { return block_count() - static_cast<int>(mirror_.size()); }
  int upper_diagonal(int row) const { return upper_start_[row]; }
  // The upper block that `slot` of `row` holds or, below the diagonal, mirrors.
  int upper(int row, int slot) const {
    const int lower_before = diagonal_slot_[row] - upper_start_[row];  // with those of this row
    return slot >= diagonal_slot_[row] ? slot - lower_before
                                       : mirror_[lower_before - (diagonal_slot_[row] - slot)];
  }
  // The slot of the block that one below the diagonal, at `slot` of `row`, mirrors.
  int mirror_slot(int row, int slot) const {
    const int other = column_[slot];
    return diagonal_slot_[other] + upper(row, slot) - upper_start_[other];
  }

 private:
  void find_mirrors();

  std::vector<int> row_start_, column_, diagonal_slot_;
  std::vector<int> upper_start_;  // by row: its diagonal, among upper blocks
  std::vector<int> mirror_;       // by block below the diagonal: its mirror image above
};

// A symmetric matrix on a pattern shared with others: the upper blocks, in double.
class BlockMatrix {
 public:
  BlockMatrix() = default;  // empty
  bool is_empty() const { return pattern_ == nullptr; }
  explicit BlockMatrix(std::shared_ptr<const BlockPattern> pattern);

  const BlockPattern& pattern() const { return *pattern_; }
  const std::shared_ptr<const BlockPattern>& shared_pattern() const { return pattern_; }
  void set_zero();
  void scale(double factor);
  Eigen::Map<Mat3> upper_block(int upper) { return Eigen::Map<Mat3>(at(upper)); }
  Eigen::Map<const Mat3> upper_block(int upper) const { return Eigen::Map<const Mat3>(at(upper)); }
  // Block at a slot of a row, on either side of the diagonal.
  Mat3 block(int row, int slot) const {
    const auto stored = upper_block(pattern_->upper(row, slot));
    return slot < pattern_->diagonal_slot(row) ? Mat3(stored.transpose()) : Mat3(stored);
  }

  Vec3 row_product(int row, const Vec3* in) const {
    return row_product_of(*pattern_, row, in, [this](int upper, int column) -> Four {
      return Column(at(upper) + 3 * column);
    });
  }
  // That of factor * this + other_factor * other, of one pattern, in one pass.
  Vec3 row_product(int row, const Vec3* in, double factor, const BlockMatrix& other,
                   double other_factor) const {
    return row_product_of(*pattern_, row, in, [&](int upper, int column) -> Four {
      return factor * Column(at(upper) + 3 * column) +
             other_factor * Column(other.at(upper) + 3 * column);
    });
  }

  // out = this * in. Sizes: rows() each. O(blocks).
  void multiply(std::span<const Vec3> in, std::span<Vec3> out, int threads) const;

 private:
  // Columns of blocks are taken four numbers at a time, of which the last is ignored.
  using Four = Eigen::Array4d;
  using Column = Eigen::Map<const Four>;
  static constexpr std::size_t padding = 1;  // so that the last column can be read as four

  // `block_column` gives column 0, 1 or 2 of an upper block. Below the diagonal columns are rows:
  // products first, and one sum over the three at the end.
  template <class BlockColumn>
  static Vec3 row_product_of(const BlockPattern& pattern, int row, const Vec3* in,
                             const BlockColumn& block_column) {
    Four below0 = Four::Zero(), below1 = below0, below2 = below0;
    const int diagonal = pattern.diagonal_slot(row);
    for (int slot = pattern.row_begin(row); slot < diagonal; ++slot) {
      const int upper = pattern.upper(row, slot);
      const Four x = Column(in[pattern.column(slot)].data());  // not the last particle
      below0 += block_column(upper, 0) * x;
      below1 += block_column(upper, 1) * x;
      below2 += block_column(upper, 2) * x;
    }
    Four sum0 = Four::Zero(), sum1 = sum0, sum2 = sum0;
    int upper = pattern.upper(row, diagonal);
    for (int slot = diagonal; slot < pattern.row_end(row); ++slot, ++upper) {
      const Vec3& x = in[pattern.column(slot)];
      sum0 += block_column(upper, 0) * x[0];
      sum1 += block_column(upper, 1) * x[1];
      sum2 += block_column(upper, 2) * x[2];
    }
    sum0 += sum1 + sum2;
    return {sum0[0] + (below0[0] + below0[1] + below0[2]),
            sum0[1] + (below1[0] + below1[1] + below1[2]),
            sum0[2] + (below2[0] + below2[1] + below2[2])};
  }

  double* at(int upper) { return values_.data() + 9 * static_cast<std::size_t>(upper); }
  const double* at(int upper) const { return values_.data() + 9 * static_cast<std::size_t>(upper); }

  std::shared_ptr<const BlockPattern> pattern_;
  std::vector<double> values_;  // 9 an upper block, column-major
};

// The same with both halves, in float: what a preconditioner sweeps through.
class SingleBlockMatrix {
 public:
  using Block = Eigen::Matrix3f;

  explicit SingleBlockMatrix(std::shared_ptr<const BlockPattern> pattern);

  const BlockPattern& pattern() const { return *pattern_; }
  void set_zero();
  Eigen::Map<Block> block(int slot) { return Eigen::Map<Block>(at(slot)); }
  Eigen::Map<const Block> block(int slot) const { return Eigen::Map<const Block>(at(slot)); }
  // Makes the blocks below the diagonal the mirror images of those above it.
  void mirror_upper(int threads);
  // 9 a slot, column-major; the last may be read one further.
  std::span<const float> values() const {
    return std::span(values_).first(values_.size() - padding);
  }

  // Sum of the blocks of slots [first, last), of one row, times what `in` has for their columns;
  // from the last slot to the first where `backward`. Sums are in double.
  template <bool backward = false>
  Vec3 partial_row_product(int first, int last, const Vec3* in) const {
    // A column of a block is a vector of four, the last of which is ignored.
    Eigen::Array4d sum0 = Eigen::Array4d::Zero(), sum1 = sum0, sum2 = sum0;
    for (int i = first; i < last; ++i) {
      const int slot = backward ? first + last - 1 - i : i;
      const float* value = at(slot);
      const Vec3& x = in[pattern_->column(slot)];
      sum0 += four(value) * x[0];
      sum1 += four(value + 3) * x[1];
      sum2 += four(value + 6) * x[2];
    }
    sum0 += sum1 + sum2;
    return sum0.head<3>();
  }
  // Asks for the blocks of slots [first, last) ahead of time, where rows are not read one after
  // the other from first to last and the processor does not foresee it. Slots beyond the ends are
  // allowed.
  void prefetch(int first, int last) const {
    const auto* const begin = reinterpret_cast<const char*>(values_.data());
    constexpr std::ptrdiff_t bytes_a_block = 9 * sizeof(float);
    for (std::ptrdiff_t at = first * bytes_a_block; at < last * bytes_a_block; at += 64)
      __builtin_prefetch(begin + at);
  }

 private:
  static constexpr std::size_t padding = 1;  // so that the last column can be read as four

  float* at(int slot) { return values_.data() + 9 * static_cast<std::size_t>(slot); }
  const float* at(int slot) const { return values_.data() + 9 * static_cast<std::size_t>(slot); }
  static Eigen::Array4d four(const float* value) {
    return Eigen::Map<const Eigen::Array4f>(value).cast<double>();
  }

  std::shared_ptr<const BlockPattern> pattern_;
  std::vector<float> values_;
};

}  // namespace weft::sim
