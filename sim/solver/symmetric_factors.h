// Factors of a sparse symmetric matrix, which may be indefinite.
#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

namespace weft::sim {

// Factorises A = P^T L D L^T P without pivoting. By Sylvester's law of inertia, A has as many
// negative eigenvalues as D has negative entries. The fill-reducing order P is computed anew only
// if the sparsity pattern changes.
class SymmetricFactors {
 public:
  using Matrix = Eigen::SparseMatrix<double>;
  using Vector = Eigen::VectorXd;

  // Factorises a matrix, of which only the lower half is read. Returns false if a pivot is zero to
  // working precision, as it is for a singular matrix.
  bool factorise(const Matrix& lower);
  // Returns the number of negative entries of D. Precondition: factorise() returned true.
  int negative_pivots() const { return negative_; }
  // Returns A^-1 right. Precondition: factorise() returned true.
  Vector solve(const Vector& right) const;
  // solve_root() returns R^-1 x, and solve_transposed_root() returns R^-T x, for A = R R^T with R =
  // P^T L D^1/2. Precondition: factorise() returned true, and D has no negative entries.
  Vector solve_root(const Vector& x) const;
  Vector solve_transposed_root(const Vector& x) const;

  // Returns the unknown whose pivot is smallest relative to its diagonal entry, also after
  // factorise() has returned false. If there are no pivots, returns the unknown with the smallest
  // diagonal entry. Returns -1 if there are no unknowns.
  int weakest() const { return weakest_; }
  // Returns the smallest pivot, as a fraction of its diagonal entry: 0 if there are no pivots.
  double smallest_pivot() const { return smallest_pivot_; }

 private:
  bool has_new_pattern(const Matrix& matrix) const;
  bool judge_pivots(const Matrix& matrix);

  Eigen::SimplicialLDLT<Matrix> factors_;
  std::vector<int> analysed_start_, analysed_row_;
  Vector root_;  // square root of D; valid if D has no negative entries
  int negative_ = 0, weakest_ = -1;
  double smallest_pivot_ = 0;
};

}  // namespace weft::sim
