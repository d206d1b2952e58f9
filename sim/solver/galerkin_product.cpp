#include "sim/solver/galerkin_product.h"

#include <algorithm>
#include <array>

#include "sim/parallel.h"

namespace weft::sim {

namespace {

// A block as its columns, each a vector of four, the last of which is ignored.
struct Columns {
  std::array<Eigen::Array4d, 3> column;

  // `block` may be read up to its tenth number.
  static Columns of(const float* block) {
    Columns result;
    for (int c = 0; c < 3; ++c)
      result.column[c] = Eigen::Map<const Eigen::Array4f>(block + 3 * c).cast<double>();
    return result;
  }
  static Columns zero() {
    return {{{Eigen::Array4d::Zero(), Eigen::Array4d::Zero(), Eigen::Array4d::Zero()}}};
  }
  Mat3 block() const {
    Mat3 result;
    for (int c = 0; c < 3; ++c) result.col(c) = column[c].head<3>().matrix();
    return result;
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
  parallel_chunks(coarse_rows.rows(), threads, [&](int first, int last) {
    // The sums of a row from its diagonal on, of blocks above and of mirror images of those below,
    // and by coarse column where they are; kept from chunk to chunk.
    thread_local std::vector<Columns> sums[2];
    thread_local std::vector<int> place;
    place.resize(std::max(place.size(), static_cast<std::size_t>(coarse_rows.rows())));
    for (int row = first; row < last; ++row) {
      const int begin = coarse_rows.diagonal_slot(row), end = coarse_rows.row_end(row);
      for (auto& sum : sums) sum.assign(end - begin, Columns::zero());
      for (int slot = begin; slot < end; ++slot) place[coarse_rows.column(slot)] = slot - begin;
      for (int c = prolongation.child_start[row]; c < prolongation.child_start[row + 1]; ++c) {
        const int child = prolongation.child[c], diagonal = rows.diagonal_slot(child);
        for (int slot = rows.row_begin(child); slot < rows.row_end(child); ++slot) {
          const int column = rows.column(slot);
          // Of the parents, which ascend, those before the row take this from elsewhere.
          const int parents_end = prolongation.row_start[column + 1];
          int k = prolongation.row_start[column];
          while (k < parents_end && prolongation.column[k] < row) ++k;
          if (k == parents_end) continue;
          auto& sum = sums[slot < diagonal];
          const Columns block = Columns::of(fine.upper_block(rows.upper(child, slot)).data());
          for (; k < parents_end; ++k) {
            sum[place[prolongation.column[k]]].add(
                prolongation.child_weight[c] * prolongation.weight[k], block);
          }
        }
      }
      for (int i = 0; i < end - begin; ++i) {
        coarse.upper_block(coarse_rows.upper(row, begin + i)) =
            (sums[0][i].block() + sums[1][i].block().transpose()).cast<float>();
      }
    }
  });
}

}  // namespace weft::sim
