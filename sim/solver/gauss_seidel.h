// Block Gauss-Seidel sweeps that run on several threads and give the same bits on any number.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sim/matrix/block_matrix.h"

namespace weft::sim {

// The order in which sweeps visit the rows of matrices of one pattern. Rows are cut into chunks of
// consecutive rows, and chunks of one colour are not coupled to each other. Sweeps go colour after
// colour, and within a chunk row after row; chunks of one colour run side by side. The order
// depends on the pattern alone.
//
// A = L + D + U is split by that order: L couples a row to those visited earlier, U to later ones.
// D is given by its inverse blocks; the matrix's own diagonal is not read. A block of zeros keeps
// its row of x at zero.
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
  // Computes the residual r = b - A x from the part that the last sweep did not solve. After a
  // forward sweep r = -U x; after a backward one that changed x by d, r = -L d. Reads half of the
  // matrix.
  enum class Half : std::uint8_t { lower, upper };
  void find_residual(Half half, const SingleBlockMatrix& matrix, std::span<const Vec3> x,
                     std::span<Vec3> r, int threads) const;

 private:
  template <class Body>
  void run_chunks(const std::vector<int>& chunks, int threads, const Body& body) const;

  int rows_ = 0, rows_per_chunk_ = 0;
  std::vector<std::vector<int>> colours_;  // chunks of each
  std::vector<int> colour_of_chunk_;
};

}  // namespace weft::sim
