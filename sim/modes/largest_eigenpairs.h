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
// descending order of magnitude. Finds all pairs if there are fewer. Vectors are orthonormal: v_i .
// F v_j = delta_ij. A is symmetric and F positive definite; only their lower halves are read.
// Precondition: `factors` are the factors of F.
//
// With F = R R^T, the eigenvalues are those of R^-1 A R^-T, and implicitly restarted Lanczos finds
// the largest of them (Spectra; Lehoucq and Sorensen 1996). Lanczos may miss copies of a multiple
// eigenvalue. By Sylvester's law of inertia, F t - A has as many negative pivots as there are
// values above t. This number shows whether pairs are missing. If so, another search follows,
// orthogonal to the pairs found.
//
// Returns an empty list if A is zero. Returns nothing if Lanczos does not converge or pairs are
// still missing after ten searches. The result is deterministic, because the start vector is fixed.
// Cost: usually one search. A search costs at least two factorisations and about ten solves per
// pair. Problems with at most 2 * count + 20 unknowns are solved densely instead.
std::optional<std::vector<Eigenpair>> largest_eigenpairs(const Eigen::SparseMatrix<double>& a,
                                                         const Eigen::SparseMatrix<double>& f,
                                                         const SymmetricFactors& factors,
                                                         int count);

}  // namespace weft::sim
