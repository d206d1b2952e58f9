#include "sim/modes/largest_eigenpairs.h"

#include <Spectra/SymEigsSolver.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace weft::sim {

namespace {

using Matrix = Eigen::SparseMatrix<double>;
using Vector = Eigen::VectorXd;

// Relative residual allowed for an eigenpair, and largest number of restarts of Lanczos.
constexpr double tolerance = 1e-11;
constexpr int most_restarts = 300;
// Number of vectors that Lanczos keeps in addition to two per wanted pair. A problem with no more
// unknowns than vectors is solved densely.
constexpr int more_vectors = 20;
// Relative difference of magnitudes below which eigenvalues count as equal.
constexpr double separation = 1e-7;
// Largest number of searches. Each search after the first looks for pairs that earlier searches
// missed.
constexpr int most_searches = 10;

// The symmetric operator R^-1 A R^-T, projected orthogonally to known eigenvectors. It is scaled to
// about unit norm, as Spectra's convergence test requires.
class Operator {
 public:
  using Scalar = double;

  Operator(const Matrix& a, const SymmetricFactors& factors) : a_(a), factors_(factors) {
    Vector x = Vector::LinSpaced(a.rows(), 0.5, 1.5);
    for (int i = 0; i < 3; ++i) {
      x.normalize();
      Vector y(x.size());
      perform_op(x.data(), y.data());
      x = y;
    }
    norm_ = x.norm();
    if (norm_ > 0) scale_ = 1 / norm_;
  }

  Eigen::Index rows() const { return a_.rows(); }
  Eigen::Index cols() const { return a_.cols(); }
  double scale() const { return scale_; }
  bool is_zero() const { return norm_ == 0; }

  void perform_op(const double* in, double* out) const {
    Vector x = Eigen::Map<const Vector>(in, rows());
    remove_known(x);
    const Vector product = a_.selfadjointView<Eigen::Lower>() * factors_.solve_transposed_root(x);
    x = scale_ * factors_.solve_root(product);
    remove_known(x);
    Eigen::Map<Vector>(out, rows()) = x;
  }
  void set_known(const std::vector<Eigenpair>& pairs) { known_ = &pairs; }

 private:
  void remove_known(Vector& x) const {
    if (known_ == nullptr) return;
    for (const Eigenpair& each : *known_) x -= each.vector.dot(x) * each.vector;
  }

  const Matrix& a_;
  const SymmetricFactors& factors_;
  const std::vector<Eigenpair>* known_ = nullptr;
  double norm_ = 0;  // norm of the operator, estimated from below
  double scale_ = 1;
};

double magnitude_of(const Eigenpair& pair) { return std::abs(pair.value); }

// Returns all pairs, by a dense solver.
std::vector<Eigenpair> dense_pairs(const Operator& of) {
  Eigen::MatrixXd matrix(of.rows(), of.cols());
  for (Eigen::Index i = 0; i < of.cols(); ++i) {
    const Vector unit = Vector::Unit(of.cols(), i);
    of.perform_op(unit.data(), matrix.col(i).data());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
  std::vector<Eigenpair> pairs;
  for (Eigen::Index i = 0; i < of.cols(); ++i)
    pairs.push_back({solver.eigenvalues()[i] / of.scale(), solver.eigenvectors().col(i)});
  return pairs;
}

// Appends `count` pairs orthogonal to `pairs`. Returns false if Lanczos does not converge.
bool add_pairs(Operator& of, int count, std::vector<Eigenpair>& pairs) try {
  of.set_known(pairs);
  const Eigen::Index vectors = 2 * count + more_vectors;
  Spectra::SymEigsSolver<Operator> solver(of, count, std::min(vectors, of.rows()));
  solver.init();
  solver.compute(Spectra::SortRule::LargestMagn, most_restarts, tolerance);
  if (solver.info() != Spectra::CompInfo::Successful) return false;
  const Vector values = solver.eigenvalues();
  const Eigen::MatrixXd found = solver.eigenvectors();
  for (Eigen::Index i = 0; i < values.size(); ++i)
    pairs.push_back({values[i] / of.scale(), found.col(i)});
  return true;
} catch (const std::runtime_error&) {
  return false;  // Spectra throws if an inner eigenvalue iteration fails
}

// Returns the number of eigenvalues whose magnitude is larger than `least` > 0.
int count_larger(const Matrix& a, const Matrix& f, double least) {
  int sum = 0;
  SymmetricFactors factors;
  for (const double sign : {-1.0, 1.0}) {
    for (const double moved : {1.0, 1 + 0.1 * separation, 1 - 0.1 * separation}) {
      if (!factors.factorise(moved * least * f + sign * a)) continue;
      sum += factors.negative_pivots();
      break;
    }
  }
  return sum;
}

}  // namespace

std::optional<std::vector<Eigenpair>> largest_eigenpairs(const Matrix& a, const Matrix& f,
                                                         const SymmetricFactors& factors,
                                                         int count) {
  Operator of(a, factors);
  std::vector<Eigenpair> pairs;
  if (of.is_zero()) return pairs;
  count = std::min(count, static_cast<int>(a.rows()));
  if (a.rows() <= 2 * count + more_vectors) {
    pairs = dense_pairs(of);
    std::ranges::stable_sort(pairs, std::ranges::greater{}, magnitude_of);
  } else {
    int missing = count;
    for (int search = 0; missing > 0 && search < most_searches; ++search) {
      if (!add_pairs(of, missing, pairs)) return std::nullopt;
      std::ranges::stable_sort(pairs, std::ranges::greater{}, magnitude_of);
      const double least = (1 + separation) * magnitude_of(pairs[count - 1]);
      const auto larger = std::ranges::count_if(
          pairs, [&](const Eigenpair& each) { return magnitude_of(each) > least; });
      missing = least > 0 ? count_larger(a, f, least) - static_cast<int>(larger) : 0;
    }
    if (missing > 0) return std::nullopt;
  }
  pairs.resize(count);
  for (Eigenpair& each : pairs) each.vector = factors.solve_transposed_root(each.vector);
  return pairs;
}

}  // namespace weft::sim
