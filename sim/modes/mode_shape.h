// The stiffness for modes of vibration and buckling, and the shapes and errors of modes.
#pragma once

#include <Eigen/SparseCore>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/solver/free_unknowns.h"

namespace weft::sim {

// Evaluates the forces of a state, and returns the exact tangent stiffness of the free unknowns.
// Contacts are springs along their normals, without damping and friction. Returns nothing, and sets
// `fault` to the reason, if the forces cannot be evaluated.
std::optional<Eigen::SparseMatrix<double>> stiffness_at(Dynamics& dynamics,
                                                        const FreeUnknowns& unknowns, double time,
                                                        std::span<const double> state,
                                                        std::string& fault);

// Returns an eigenvector as one displacement per dynamic particle. The largest displacement has the
// length 1. The coordinate of the largest magnitude is positive.
std::vector<Vec3> shape_of(const FreeUnknowns& unknowns, const Eigen::VectorXd& vector);

// Returns the norm of A v - value B v divided by the norm of |A| |v|, with absolute values of
// entries. This is the residual of an eigenpair relative to the scale at which A v is rounded. Only
// the lower halves of both matrices are read.
double equation_error(const Eigen::SparseMatrix<double>& a, const Eigen::SparseMatrix<double>& b,
                      double value, const Eigen::VectorXd& vector);

// Returns |v|^T |A| |v|. The rounding error of v^T A v is at most a small multiple of this number
// times the machine epsilon. Only the lower half of A is read.
double rounding_scale(const Eigen::SparseMatrix<double>& a, const Eigen::VectorXd& vector);

}  // namespace weft::sim
