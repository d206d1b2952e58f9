#include "tests/dense_algebra.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace weft {

Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric, Eigen::EigenvaluesOnly)
      .eigenvalues();
}

Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(a, b, Eigen::EigenvaluesOnly)
      .eigenvalues();
}

Eigen::MatrixXd congruent(const Eigen::MatrixXd& middle, const Eigen::MatrixXd& a) {
  return a.transpose() * middle * a;
}

Eigen::VectorXd solve_definite(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right) {
  const Eigen::LLT<Eigen::MatrixXd> factors(matrix);
  if (factors.info() != Eigen::Success) return {};
  return factors.solve(right);
}

double relative_error(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return (a - b).norm() / b.norm();
}

Eigen::MatrixXd flat_finite_difference(const FlatFunction& function, const Eigen::VectorXd& x,
                                       double step) {
  const auto flat = [&](Eigen::Index component, double shift) -> Eigen::VectorXd {
    Eigen::VectorXd moved = x;
    moved[component] += shift;
    return function(moved).reshaped();
  };
  Eigen::MatrixXd result(flat(0, 0).size(), x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    result.col(i) =
        (8 * (flat(i, step) - flat(i, -step)) - flat(i, 2 * step) + flat(i, -2 * step)) /
        (12 * step);
  }
  return result;
}

}  // namespace weft
