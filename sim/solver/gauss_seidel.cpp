#include "sim/solver/gauss_seidel.h"

#include <algorithm>

#include "bsi/detail/team.h"

namespace weft::sim {

namespace {

// Number of rows by which a backward sweep prefetches ahead. The processor itself predicts neither
// rows in reverse order nor upper halves of rows.
constexpr int prefetched_rows = 6;

// Smallest number of rows per chunk, and largest number of chunks. Large chunks are better:
// couplings between chunks cost more, and sweeps across chunks smooth less. Still, 32 chunks keep
// many threads busy.
constexpr int least_rows_per_chunk = 512;
constexpr int most_chunks = 32;

}  // namespace

GaussSeidel::GaussSeidel(const BlockPattern& pattern)
    : rows_(pattern.rows()),
      rows_per_chunk_(std::max(least_rows_per_chunk, (rows_ + most_chunks - 1) / most_chunks)) {
  for (int c = 0; c * rows_per_chunk_ < rows_; ++c) {
    std::vector<char> used(colours_.size() + 1, 0);
    const int last = std::min(rows_, (c + 1) * rows_per_chunk_);
    // Only couplings to earlier chunks are visited: couplings are symmetric, and the later of two
    // coupled chunks visits their couplings.
    for (int row = c * rows_per_chunk_; row < last; ++row) {
      for (int slot = pattern.row_begin(row); slot < pattern.row_end(row); ++slot) {
        const int other = pattern.column(slot) / rows_per_chunk_;
        if (other >= c) break;
        used[colour_of_chunk_[other]] = 1;
      }
    }
    const std::size_t colour = std::find(used.begin(), used.end(), 0) - used.begin();
    if (colour == colours_.size()) colours_.emplace_back();
    colours_[colour].push_back(c);
    colour_of_chunk_.push_back(static_cast<int>(colour));
  }
}

template <class Body>
void GaussSeidel::run_chunks(const std::vector<int>& chunks, int threads, const Body& body) const {
  bsi::parallel_for(static_cast<int>(chunks.size()), threads, [&](int c) {
    const int first = chunks[c] * rows_per_chunk_;
    body(first, std::min(rows_, first + rows_per_chunk_));
  });
}

void GaussSeidel::solve_forward(const SingleBlockMatrix& matrix,
                                std::span<const Mat3> inverse_diagonal, std::span<const Vec3> b,
                                std::span<Vec3> x, int threads) const {
  const BlockPattern& pattern = matrix.pattern();
  // Rows not yet visited contribute zero. Within the chunk their couplings are skipped. In chunks
  // of later colours, x is still zero.
  std::fill(x.begin(), x.end(), Vec3::Zero());
  for (const auto& chunks : colours_) {
    run_chunks(chunks, threads, [&](int first, int last) {
      for (int row = first; row < last; ++row) {
        int outside = pattern.row_end(row);
        while (pattern.column(outside - 1) >= last) --outside;
        Vec3 sum =
            matrix.lower_product(row, pattern.row_begin(row), pattern.diagonal_slot(row), x.data());
        if (outside != pattern.row_end(row))
          sum += matrix.upper_product(row, outside, pattern.row_end(row), x.data());
        x[row] = inverse_diagonal[row] * (b[row] - sum);
      }
    });
  }
}

void GaussSeidel::sweep_backward(const SingleBlockMatrix& matrix,
                                 std::span<const Mat3> inverse_diagonal, std::span<const Vec3> b,
                                 std::span<Vec3> x, std::span<Vec3> change, int threads) const {
  const BlockPattern& pattern = matrix.pattern();
  for (auto chunks = colours_.rbegin(); chunks != colours_.rend(); ++chunks) {
    run_chunks(*chunks, threads, [&](int first, int last) {
      for (int row = last - 1; row >= first; --row) {
        matrix.prefetch_rows(row - prefetched_rows, row - prefetched_rows + 1);
        // The upper product adds backward, because the x of the row visited just before becomes
        // available last.
        const int diagonal = pattern.diagonal_slot(row);
        const Vec3 rest =
            b[row] - matrix.lower_product(row, pattern.row_begin(row), diagonal, x.data());
        const Vec3 swept =
            inverse_diagonal[row] *
            (rest - matrix.upper_product<true>(row, diagonal + 1, pattern.row_end(row), x.data()));
        change[row] = swept - x[row];
        x[row] = swept;
      }
    });
  }
}

void GaussSeidel::find_residual(Half half, const SingleBlockMatrix& matrix, std::span<const Vec3> x,
                                std::span<Vec3> r, int threads) const {
  const BlockPattern& pattern = matrix.pattern();
  for (int colour = 0; colour < static_cast<int>(colours_.size()); ++colour) {
    run_chunks(colours_[colour], threads, [&](int first, int last) {
      for (int row = first; row < last; ++row) {
        const int diagonal = pattern.diagonal_slot(row);
        int begin = pattern.row_begin(row), end = pattern.row_end(row);
        Vec3 sum = Vec3::Zero();
        const auto counts = [&](int slot) {
          const int other = colour_of_chunk_[pattern.column(slot) / rows_per_chunk_];
          return half == Half::upper ? other > colour : other < colour;
        };
        for (; pattern.column(begin) < first; ++begin) {
          if (counts(begin)) sum += matrix.lower_product(row, begin, begin + 1, x.data());
        }
        while (pattern.column(end - 1) >= last) {
          --end;
          if (counts(end)) sum += matrix.upper_product(row, end, end + 1, x.data());
        }
        sum += half == Half::upper ? matrix.upper_product(row, diagonal + 1, end, x.data())
                                   : matrix.lower_product(row, begin, diagonal, x.data());
        r[row] = -sum;
      }
    });
  }
}

}  // namespace weft::sim
