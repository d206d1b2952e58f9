// The shapes and errors of modes of vibration and buckling.
#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "sim/modes/mode_unknowns.h"

namespace weft::sim {

// Returns an eigenvector as one displacement per dynamic particle. The largest displacement has the
// length 1. The coordinate of the largest magnitude is positive.
std::vector<Vec3> shape_of(const ModeUnknowns& unknowns, const Eigen::VectorXd& vector);

// Returns the norm of A v - value B v divided by the norm of |A| |v|, with absolute values of
// entries. This is the residual of an eigenpair relative to the scale at which A v is rounded. Only
// the lower halves of both matrices are read.
double equation_error(const Eigen::SparseMatrix<double>& a, const Eigen::SparseMatrix<double>& b,
                      double value, const Eigen::VectorXd& vector);

// Returns |v|^T |A| |v|. The rounding error of v^T A v is at most a small multiple of this number
// times the machine epsilon. Only the lower half of A is read.
double rounding_scale(const Eigen::SparseMatrix<double>& a, const Eigen::VectorXd& vector);

}  // namespace weft::sim
