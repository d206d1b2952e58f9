#include "sim/solver/galerkin_product.h"

#include <algorithm>

#include "sim/parallel.h"

namespace weft::sim {

namespace {

// Sums blocks by column: `place[column]` says where in the list, or -1.
struct RowSum {
  std::vector<int> place;
  std::vector<int> columns;
  std::vector<std::array<double, 9>> blocks;

  explicit RowSum(int column_count) : place(column_count, -1) {}
  template <class Scalar>
  void add(int column, double weight, const Scalar* block) {
    if (place[column] < 0) {
      place[column] = static_cast<int>(columns.size());
      columns.push_back(column);
      blocks.emplace_back();
    }
    double* sum = blocks[place[column]].data();
    for (int k = 0; k < 9; ++k) sum[k] += weight * static_cast<double>(block[k]);
  }
  void clear() {
    for (int column : columns) place[column] = -1;
    columns.clear();
    blocks.clear();
  }
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

template <class FineScalar, class CoarseScalar>
void galerkin_product(const BlockMatrixOf<FineScalar>& fine, const Prolongation& prolongation,
                      BlockMatrixOf<CoarseScalar>& coarse, int threads) {
  const BlockPattern& rows = fine.pattern();
  const BlockPattern& coarse_rows = coarse.pattern();
  const FineScalar* values = fine.values().data();
  parallel_chunks(coarse_rows.rows(), threads, [&](int first, int last) {
    // First P^T A for a row, over fine columns, then times P.
    RowSum left(rows.rows()), sum(coarse_rows.rows());
    for (int row = first; row < last; ++row) {
      for (int c = prolongation.child_start[row]; c < prolongation.child_start[row + 1]; ++c) {
        const int child = prolongation.child[c];
        for (int slot = rows.row_begin(child); slot < rows.row_end(child); ++slot) {
          left.add(rows.column(slot), prolongation.child_weight[c],
                   values + 9 * static_cast<std::size_t>(slot));
        }
      }
      for (std::size_t i = 0; i < left.columns.size(); ++i) {
        const int column = left.columns[i];
        for (int k = prolongation.row_start[column]; k < prolongation.row_start[column + 1]; ++k)
          sum.add(prolongation.column[k], prolongation.weight[k], left.blocks[i].data());
      }
      for (int slot = coarse_rows.row_begin(row); slot < coarse_rows.row_end(row); ++slot) {
        const auto& block = sum.blocks[sum.place[coarse_rows.column(slot)]];
        coarse.block(slot) = Eigen::Map<const Mat3>(block.data()).template cast<CoarseScalar>();
      }
      left.clear();
      sum.clear();
    }
  });
}

template void galerkin_product(const BlockMatrixOf<double>&, const Prolongation&,
                               BlockMatrixOf<double>&, int);
template void galerkin_product(const BlockMatrixOf<double>&, const Prolongation&,
                               BlockMatrixOf<float>&, int);
template void galerkin_product(const BlockMatrixOf<float>&, const Prolongation&,
                               BlockMatrixOf<float>&, int);

}  // namespace weft::sim
