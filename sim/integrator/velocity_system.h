// The Newton matrix of an implicit step, reduced to the velocities and solved iteratively.
#pragma once

#include <span>
#include <vector>

#include "sim/integrator/dynamics.h"

namespace weft::sim {

// For the Newton correction of y - gamma f(y) = const, (I - gamma J)(dx, dv) = (b_x, b_v), the
// first rows give dx = b_x + gamma dv, and the second
//   A dv = M b_v - gamma K b_x,   A = M + gamma D + gamma^2 K,
// symmetric, with K = -dF/dx and D = -dF/dv. Solved by conjugate gradients preconditioned with the
// inverses of A's diagonal 3x3 blocks. Contact enters A through its pairs, as they were at the last
// force evaluation; the rest through block matrices.
class VelocitySystem {
 public:
  explicit VelocitySystem(Dynamics& dynamics);

  // Forms A for this gamma from the K and D last assembled by the dynamics.
  void set_up(double gamma);

  struct Outcome {
    bool converged = false;
    bool indefinite = false;  // A direction of negative curvature was met: the step is too large
    int iterations = 0;
    double residual = 0;  // in the norm of the tolerance
  };
  // Solves for the correction (x, v) of right-hand side b, both 6 * particles doubles. Stops when
  // the residual of the velocity rows, divided by the mass and multiplied by `weight` (6 *
  // particles; the velocity half is used), has a 2-norm of at most `tolerance`, and
  // no particle's exceeds ten times what would be the mean then. With `relative`, also at most that
  // fraction of what it is for a correction of the velocities of zero.
  Outcome solve(double gamma, std::span<const double> b, std::span<const double> weight,
                double tolerance, std::span<double> correction, double relative = 1);

 private:
  void multiply(std::span<const Vec3> in, std::span<Vec3> out) const;
  void invert_diagonal();
  double precondition();  // z = P r; returns r.z
  double weighted_residual(std::span<const Vec3> weight) const;

  Dynamics& dynamics_;
  BlockMatrix matrix_;  // A without contact
  double gamma_ = 0;
  std::vector<Mat3> inverse_diagonal_;
  std::vector<Vec3> residual_, direction_, product_, preconditioned_;
};

}  // namespace weft::sim
