#include "sim/solver/galerkin_product.h"

#include <algorithm>

#include "sim/parallel.h"

namespace weft::sim {

namespace {

// A block as its columns, each a vector of four, the last of which is ignored.
struct Columns {
  Eigen::Array4d column[3];

  // `block` may be read up to its tenth number.
  static Columns of(const float* block) {
    Columns result;
    for (int c = 0; c < 3; ++c)
      result.column[c] = Eigen::Map<const Eigen::Array4f>(block + 3 * c).cast<double>();
    return result;
  }
};

// A row of blocks that are found by column: `place[column]` says where in the list, or -1.
class RowSum {
 public:
  struct Entry {
    Columns block;
    int column = 0;
  };

  void prepare(int column_count) {
    if (place_.size() < static_cast<std::size_t>(column_count)) place_.resize(column_count, -1);
  }
  void add(int column, double weight, const Columns& block) {
    if (place_[column] < 0) {
      place_[column] = count_++;
      if (entries_.size() < static_cast<std::size_t>(count_)) entries_.emplace_back();
      Entry& entry = entries_[count_ - 1];
      entry.column = column;
      for (int c = 0; c < 3; ++c) entry.block.column[c] = weight * block.column[c];
      return;
    }
    Columns& sum = entries_[place_[column]].block;
    for (int c = 0; c < 3; ++c) sum.column[c] += weight * block.column[c];
  }
  std::span<const Entry> entries() const { return std::span(entries_).first(count_); }
  const Columns& block_of_column(int column) const { return entries_[place_[column]].block; }
  void clear() {
    for (const Entry& entry : entries()) place_[entry.column] = -1;
    count_ = 0;
  }

 private:
  std::vector<int> place_;
  std::vector<Entry> entries_;
  int count_ = 0;
};

}  // namespace

std::shared_ptr<const BlockPattern> galerkin_pattern(const BlockPattern& fine,
                                                     const Prolongation& prolongation) {
  std::vector<std::vector<int>> neighbours(prolongation.coarse_count());
  std::vector<int> last_row(prolongation.coarse_count(), -1);
  for (int row = 0; row < prolongation.coarse_count(); ++row) {
    for (int c = prolongation.child_start[row]; c < prolongation.child_start[row + 1]; ++c) {
      const int child = prolongation.child[c];
      for (int slot = fine.row_begin(child); slot < fine.row_end(child); ++slot) {
        const int column = fine.column(slot);
        for (int k = prolongation.row_start[column]; k < prolongation.row_start[column + 1]; ++k) {
          const int parent = prolongation.column[k];
          if (last_row[parent] == row) continue;
          last_row[parent] = row;
          neighbours[row].push_back(parent);
        }
      }
    }
  }
  return std::make_shared<const BlockPattern>(neighbours);
}

void galerkin_product(const SingleBlockMatrix& fine, const Prolongation& prolongation,
                      SingleBlockMatrix& coarse, int threads) {
  const BlockPattern& rows = fine.pattern();
  const BlockPattern& coarse_rows = coarse.pattern();
  const float* values = fine.values().data();
  parallel_chunks(coarse_rows.rows(), threads, [&](int first, int last) {
    // First P^T A for a row, over fine columns, then times P. Kept from chunk to chunk, as their
    // places are as many as there are columns.
    thread_local RowSum left, sum;
    left.prepare(rows.rows());
    sum.prepare(coarse_rows.rows());
    for (int row = first; row < last; ++row) {
      for (int c = prolongation.child_start[row]; c < prolongation.child_start[row + 1]; ++c) {
        const int child = prolongation.child[c];
        for (int slot = rows.row_begin(child); slot < rows.row_end(child); ++slot) {
          left.add(rows.column(slot), prolongation.child_weight[c],
                   Columns::of(values + 9 * static_cast<std::size_t>(slot)));
        }
      }
      for (const RowSum::Entry& entry : left.entries()) {
        const int column = entry.column;
        for (int k = prolongation.row_start[column]; k < prolongation.row_start[column + 1]; ++k)
          sum.add(prolongation.column[k], prolongation.weight[k], entry.block);
      }
      for (int slot = coarse_rows.row_begin(row); slot < coarse_rows.row_end(row); ++slot) {
        const Columns& block = sum.block_of_column(coarse_rows.column(slot));
        for (int c = 0; c < 3; ++c)
          coarse.block(slot).col(c) = block.column[c].head<3>().matrix().cast<float>();
      }
      left.clear();
      sum.clear();
    }
  });
}

}  // namespace weft::sim
