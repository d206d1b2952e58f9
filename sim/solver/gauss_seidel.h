// Block Gauss-Seidel sweeps that run on several threads and give the same bits on any number.
#pragma once

#include <span>
#include <vector>

#include "sim/forces/block_matrix.h"

namespace weft::sim {

// The order in which sweeps visit the rows of matrices of one pattern: cut into chunks of
// consecutive rows, chunks of one colour coupled to none of their own, colour after colour; within
// a chunk row after row. It depends on the pattern alone. Chunks of one colour run side by side.
//
// Split A = L + D + U by that order: L couples a row to those visited earlier, U to later ones, and
// the sweeps are with D given by its inverse blocks. A larger D (for couplings that are not in A)
// is allowed; a block of zeros keeps its row of x at zero.
class GaussSeidel {
 public:
  explicit GaussSeidel(const BlockPattern& pattern);

  // x = (L + D)^-1 b. Reads about half of the matrix.
  void solve_forward(const SingleBlockMatrix& matrix, std::span<const Mat3> inverse_diagonal,
                     std::span<const Vec3> b, std::span<Vec3> x, int threads) const;
  // r = -U x: what the sweep above leaves of b where D is A's own. Reads the other half.
  void remaining(const SingleBlockMatrix& matrix, std::span<const Vec3> x, std::span<Vec3> r,
                 int threads) const;
  // x = x + (U + D)^-1 (b - A x), in the reverse order. Reads the matrix once.
  void sweep_backward(const SingleBlockMatrix& matrix, std::span<const Mat3> inverse_diagonal,
                      std::span<const Vec3> b, std::span<Vec3> x, int threads) const;

 private:
  static constexpr int rows_a_chunk = 512;

  template <class Body>
  void run_chunks(const std::vector<int>& chunks, int threads, const Body& body) const;

  int rows_ = 0;
  std::vector<std::vector<int>> colours_;  // chunks of each
  std::vector<int> colour_of_chunk_;
};

}  // namespace weft::sim
