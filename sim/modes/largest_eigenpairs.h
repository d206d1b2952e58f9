// Eigenpairs of sparse symmetric matrices.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <optional>
#include <vector>

#include "sim/solver/symmetric_factors.h"

namespace weft::sim {

struct Eigenpair {
  double value = 0;
  Eigen::VectorXd vector;
};

// Finds the `count` eigenpairs of A v = value F v whose values have the largest magnitudes, in
// descending order of magnitude; all pairs if there are fewer. Vectors are orthonormal: v_i . F v_j
// = delta_ij. A is symmetric and F positive definite; only their lower halves are read.
// Precondition: `factors` are those of F.
//
// With F = R R^T, the eigenvalues are those of R^-1 A R^-T, and implicitly restarted Lanczos finds
// its largest ones (Spectra; Lehoucq and Sorensen 1996). Lanczos may miss copies of a multiple
// eigenvalue. Sylvester's law of inertia tells how many values exceed the last one found: F t - A
// has as many negative pivots as there are values above t. If pairs are missing, another search
// follows, orthogonal to the pairs found.
//
// Returns an empty list if A is zero, and nothing if Lanczos does not converge. Deterministic,
// because it starts from a fixed vector. Cost: at least two factorisations per search, usually of a
// single one, and about ten solves per pair.
std::optional<std::vector<Eigenpair>> largest_eigenpairs(const Eigen::SparseMatrix<double>& a,
                                                         const Eigen::SparseMatrix<double>& f,
                                                         const SymmetricFactors& factors,
                                                         int count);

}  // namespace weft::sim
