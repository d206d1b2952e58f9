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
  static Columns zero() {
    return {{Eigen::Array4d::Zero(), Eigen::Array4d::Zero(), Eigen::Array4d::Zero()}};
  }
  void add(double weight, const Columns& other) {
    for (int c = 0; c < 3; ++c) column[c] += weight * other.column[c];
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

void galerkin_product(const SingleBlockMatrix& fine, const Prolongation& prolongation,
                      SingleBlockMatrix& coarse, int threads) {
  const BlockPattern& rows = fine.pattern();
  const BlockPattern& coarse_rows = coarse.pattern();
  const float* values = fine.values().data();
  parallel_chunks(coarse_rows.rows(), threads, [&](int first, int last) {
    // The sums of a row from its diagonal on, and by coarse column where they are; kept from chunk
    // to chunk.
    thread_local std::vector<Columns> sums;
    thread_local std::vector<int> place;
    place.resize(std::max(place.size(), static_cast<std::size_t>(coarse_rows.rows())));
    for (int row = first; row < last; ++row) {
      const int begin = coarse_rows.diagonal_slot(row), end = coarse_rows.row_end(row);
      sums.assign(end - begin, Columns::zero());
      for (int slot = begin; slot < end; ++slot) place[coarse_rows.column(slot)] = slot - begin;
      for (int c = prolongation.child_start[row]; c < prolongation.child_start[row + 1]; ++c) {
        const int child = prolongation.child[c];
        for (int slot = rows.row_begin(child); slot < rows.row_end(child); ++slot) {
          const Columns block = Columns::of(values + 9 * static_cast<std::size_t>(slot));
          const int column = rows.column(slot);
          for (int k = prolongation.row_start[column]; k < prolongation.row_start[column + 1];
               ++k) {
            const int parent = prolongation.column[k];
            if (parent >= row)
              sums[place[parent]].add(prolongation.child_weight[c] * prolongation.weight[k], block);
          }
        }
      }
      for (int slot = begin; slot < end; ++slot) {
        for (int c = 0; c < 3; ++c)
          coarse.block(slot).col(c) = sums[slot - begin].column[c].head<3>().matrix().cast<float>();
      }
    }
  });
  coarse.mirror_upper(threads);
}

}  // namespace weft::sim
