// Block Gauss-Seidel sweeps on several threads, with the same bits on any number of them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sim/matrix/block_matrix.h"

namespace weft::sim {

// The order in which sweeps visit the rows of matrices of one pattern. Chunks of consecutive rows
// are coloured: chunks of one colour are not coupled and run in parallel. Sweeps visit colour after
// colour, and row after row within a chunk. The order depends on the pattern alone.
//
// A = L + D + U is split by that order: L couples a row to rows visited earlier, U to later ones. D
// is given by its inverse blocks; the matrix's own diagonal is not read. A zero inverse block keeps
// its row of x at zero.
class GaussSeidel {
 public:
  explicit GaussSeidel(const BlockPattern& pattern);

  // x = (L + D)^-1 b. Reads about half of the matrix.
  void solve_forward(const SingleBlockMatrix& matrix, std::span<const Mat3> inverse_diagonal,
                     std::span<const Vec3> b, std::span<Vec3> x, int threads) const;
  // x = (U + D)^-1 (b - L x), in the reverse order. `change` receives the change of x. Reads the
  // matrix once.
  void sweep_backward(const SingleBlockMatrix& matrix, std::span<const Mat3> inverse_diagonal,
                      std::span<const Vec3> b, std::span<Vec3> x, std::span<Vec3> change,
                      int threads) const;
  // Computes the residual r = b - A x after a sweep. After a forward sweep that gave x, r = -U x
  // (`upper`). After a backward sweep that changed x by d, r = -L d (`lower`; pass d as `x`). Reads
  // half of the matrix.
  enum class Half : std::uint8_t { lower, upper };
  void find_residual(Half half, const SingleBlockMatrix& matrix, std::span<const Vec3> x,
                     std::span<Vec3> r, int threads) const;

 private:
  template <class Body>
  void run_chunks(const std::vector<int>& chunks, int threads, const Body& body) const;

  int rows_ = 0, rows_per_chunk_ = 0;
  std::vector<std::vector<int>> colours_;  // the chunks of each colour
  std::vector<int> colour_of_chunk_;
};

}  // namespace weft::sim
