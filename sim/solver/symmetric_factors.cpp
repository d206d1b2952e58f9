#include "sim/solver/symmetric_factors.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace weft::sim {

namespace {

// Smallest pivot, as a fraction of its diagonal entry, that is distinguished from rounding.
constexpr double least_pivot = 1e-15;

}  // namespace

bool SymmetricFactors::has_new_pattern(const Matrix& matrix) const {
  const auto columns = static_cast<std::size_t>(matrix.outerSize()) + 1;
  const auto rows = static_cast<std::size_t>(matrix.nonZeros());
  return analysed_start_.size() != columns || analysed_row_.size() != rows ||
         !std::equal(analysed_start_.begin(), analysed_start_.end(), matrix.outerIndexPtr()) ||
         !std::equal(analysed_row_.begin(), analysed_row_.end(), matrix.innerIndexPtr());
}

// Counts the negative pivots and finds the weakest pivot. Returns false if the weakest pivot is no
// larger than rounding errors.
bool SymmetricFactors::judge_pivots(const Matrix& matrix) {
  const auto& order = factors_.permutationP().indices();
  const auto pivots = factors_.vectorD();
  const Vector diagonal = matrix.diagonal();
  double least = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < diagonal.size(); ++i) {
    const double pivot = pivots[order.size() == 0 ? i : order[i]];
    if (pivot < 0) ++negative_;
    const double share = std::abs(pivot / diagonal[i]);
    // A ratio that is not a number is not skipped: it counts as 0.
    if (share >= least) continue;
    least = std::isfinite(share) ? share : 0;
    weakest_ = static_cast<int>(i);
  }
  smallest_pivot_ = least;
  return least > least_pivot;
}

bool SymmetricFactors::factorise(const Matrix& lower) {
  negative_ = 0;
  weakest_ = -1;
  smallest_pivot_ = 0;
  if (has_new_pattern(lower)) {
    factors_.analyzePattern(lower);
    const int* const start = lower.outerIndexPtr();
    const int* const row = lower.innerIndexPtr();
    analysed_start_.assign(start, start + lower.outerSize() + 1);
    analysed_row_.assign(row, row + lower.nonZeros());
  }
  if (lower.rows() == 0) return true;
  factors_.factorize(lower);
  if (factors_.info() != Eigen::Success) {
    // There are no pivots: the smallest diagonal entry is the best available estimate.
    Eigen::Index softest = 0;
    Vector(lower.diagonal()).cwiseAbs().minCoeff(&softest);
    weakest_ = static_cast<int>(softest);
    return false;
  }
  if (!judge_pivots(lower)) return false;
  if (negative_ == 0) root_ = factors_.vectorD().cwiseSqrt();
  return true;
}

SymmetricFactors::Vector SymmetricFactors::solve(const Vector& right) const {
  return factors_.solve(right);
}

SymmetricFactors::Vector SymmetricFactors::solve_root(const Vector& x) const {
  Vector result = factors_.permutationP().size() == 0 ? x : Vector(factors_.permutationP() * x);
  factors_.matrixL().solveInPlace(result);
  return result.cwiseQuotient(root_);
}

SymmetricFactors::Vector SymmetricFactors::solve_transposed_root(const Vector& x) const {
  Vector result = x.cwiseQuotient(root_);
  factors_.matrixU().solveInPlace(result);
  return factors_.permutationPinv().size() == 0 ? result
                                                : Vector(factors_.permutationPinv() * result);
}

}  // namespace weft::sim
