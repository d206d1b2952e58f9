// Block Gauss-Seidel sweeps that run on several threads and give the same bits on any number.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sim/forces/block_matrix.h"

namespace weft::sim {

// The order in which sweeps visit the rows of matrices of one pattern: cut into chunks of
// consecutive rows, chunks of one colour coupled to none of their own, colour after colour; within
// a chunk row after row. It depends on the pattern alone. Chunks of one colour run side by side.
//
// Split A = L + D + U by that order: L couples a row to those visited earlier, U to later ones, and
// D is given by its inverse blocks, and what the matrix has on its diagonal is not read. A block of
// zeros keeps its row of x at zero.
class GaussSeidel {
 public:
  explicit GaussSeidel(const BlockPattern& pattern);

  // x = (L + D)^-1 b. Reads about half of the matrix.
  void solve_forward(const SingleBlockMatrix& matrix, std::span<const Mat3> inverse_diagonal,
                     std::span<const Vec3> b, std::span<Vec3> x, int threads) const;
  // x = (U + D)^-1 (b - L x), in the reverse order; `change` is what that changes x by. Reads the
  // matrix once.
  void sweep_backward(const SingleBlockMatrix& matrix, std::span<const Mat3> inverse_diagonal,
                      std::span<const Vec3> b, std::span<Vec3> x, std::span<Vec3> change,
                      int threads) const;
  // What is left of b: r = -U x after a forward sweep, r = -L d after a backward one that changed x
  // by d. Reads half of the matrix.
  enum class Half : std::uint8_t { lower, upper };
  void remaining(Half half, const SingleBlockMatrix& matrix, std::span<const Vec3> x,
                 std::span<Vec3> r, int threads) const;

 private:
  template <class Body>
  void run_chunks(const std::vector<int>& chunks, int threads, const Body& body) const;

  int rows_ = 0, rows_a_chunk_ = 0;
  std::vector<std::vector<int>> colours_;  // chunks of each
  std::vector<int> colour_of_chunk_;
};

}  // namespace weft::sim
