// Block Gauss-Seidel sweeps on several threads. The bits do not depend on the number of threads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sim/matrix/block_matrix.h"

namespace weft::sim {

// Sweeps over matrices of one pattern. Chunks of consecutive rows are coloured: chunks of one
// colour are not coupled and run in parallel. A forward sweep visits colour after colour, and the
// rows of a chunk in ascending order. A backward sweep reverses this order. The order depends on
// the pattern alone.
//
// The sweeps split A = L + D + U. L couples a row to rows that a forward sweep visits earlier, U to
// rows that it visits later. D is given by its inverse blocks, and the diagonal of the matrix is
// not read. A zero inverse block keeps x of its row at zero.
class GaussSeidel {
 public:
  explicit GaussSeidel(const BlockPattern& pattern);

  // Computes x = (L + D)^-1 b. Reads about half of the matrix.
  void solve_forward(const SingleBlockMatrix& matrix, std::span<const Mat3> inverse_diagonal,
                     std::span<const Vec3> b, std::span<Vec3> x, int threads) const;
  // Computes x = (U + D)^-1 (b - L x), in a backward sweep. `change` receives the change of x.
  // Reads the matrix once.
  void sweep_backward(const SingleBlockMatrix& matrix, std::span<const Mat3> inverse_diagonal,
                      std::span<const Vec3> b, std::span<Vec3> x, std::span<Vec3> change,
                      int threads) const;
  // The part of A that enters a residual: L is `lower`, U is `upper`.
  enum class Half : std::uint8_t { lower, upper };
  // Computes the residual r = b - A x after a sweep. After solve_forward(), r = -U x: pass `upper`
  // and x. After sweep_backward(), r = -L d: pass `lower`, and the change d of that sweep as `x`.
  // In rows with a zero inverse block, the result is not the residual.
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
