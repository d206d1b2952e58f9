// The shapes and errors of modes of vibration and buckling.
#pragma once

#include <Eigen/SparseCore>
#include <span>
#include <vector>

#include "sim/matrix/tiled_matrix.h"
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

// Bounds the energy that rounded positions give to shapes. Positions are rounded to eps |x|, with
// the machine epsilon eps. This strains the edge between the particles i and j by eps |x| / |x_i -
// x_j|, and the tension of this strain is a stiffness in all directions: that fraction of the
// stiffness K_ij of the edge. Slack and flat cloth has no other stiffness across its plane.
class PositionRounding {
 public:
  // Reads the blocks of K, one row per dynamic particle, and the positions (m).
  PositionRounding(const BlockMatrix& stiffness, std::span<const Vec3> position);
  // Returns a bound of |shape . dK shape| (J) for the error dK of K, from one displacement (m) per
  // dynamic particle. The bound holds whatever the order of magnitude of the shape.
  double energy(std::span<const Vec3> shape) const;

 private:
  struct Edge {
    int one = 0, other = 0;
    double stiffness = 0;  // bound of the stiffness (N/m) of the tension
  };
  std::vector<Edge> edges_;
};

}  // namespace weft::sim
