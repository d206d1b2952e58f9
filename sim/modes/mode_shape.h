// What all modes have in common: their shapes and the accuracy of their equations.
#pragma once

#include <Eigen/SparseCore>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/solver/free_unknowns.h"

namespace weft::sim {

// Evaluates the forces of a state, and returns the exact tangent stiffness of the free unknowns.
// Contacts are springs along their normals, without damping and friction. Returns nothing, and the
// reason in `fault`, if the forces do not exist.
std::optional<Eigen::SparseMatrix<double>> stiffness_at(Dynamics& dynamics,
                                                        const FreeUnknowns& unknowns, double time,
                                                        std::span<const double> state,
                                                        std::string& fault);

// Returns an eigenvector as displacements by dynamic particle, in multiples of the largest one. The
// largest coordinate is positive.
std::vector<Vec3> shape_of(const FreeUnknowns& unknowns, const Eigen::VectorXd& vector);

// Returns |A v - value B v| / ||A| |v||, the relative error of an eigenpair's equation against the
// largest sum that its left side could be rounded in. Of both matrices the lower halves are read.
double equation_error(const Eigen::SparseMatrix<double>& a, const Eigen::SparseMatrix<double>& b,
                      double value, const Eigen::VectorXd& vector);

// Returns |v|^T |A| |v|: v^T A v is known to this times the rounding of numbers.
double rounding_scale(const Eigen::SparseMatrix<double>& a, const Eigen::VectorXd& vector);

}  // namespace weft::sim
