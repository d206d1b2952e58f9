// Dense matrix algebra for tests, compiled once. A file in which Eigen itself decomposes or
// multiplies large matrices takes ten seconds longer to compile, and a minute under the sanitizers.
#pragma once

#include <Eigen/Core>
#include <functional>

namespace weft {

// Returns the eigenvalues of a symmetric matrix in ascending order.
Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& symmetric);

// Returns the numbers k of the equation a x = k b x in ascending order, for symmetric matrices of
// which b is positive definite.
Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

// Returns transpose(a) * middle * a.
Eigen::MatrixXd congruent(const Eigen::MatrixXd& middle, const Eigen::MatrixXd& a);

// Returns the solution of a system with a symmetric, positive definite matrix; empty if it is not
// definite.
Eigen::VectorXd solve_definite(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right);

// Returns |a - b| / |b| over all components (Frobenius).
double relative_error(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

// Returns d function / d x by fourth-order central differences, with matrices flattened by columns:
// one column of the result per component of x. The error is of order step^4 + 1e-16 / step.
using FlatFunction = std::function<Eigen::MatrixXd(const Eigen::VectorXd&)>;
Eigen::MatrixXd flat_finite_difference(const FlatFunction& function, const Eigen::VectorXd& x,
                                       double step);

}  // namespace weft
