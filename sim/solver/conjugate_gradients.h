// Preconditioned conjugate gradients for the Newton system of the velocities.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "sim/solver/preconditioner_selection.h"
#include "sim/solver/velocity_matrix.h"

namespace weft::sim {

// Without contact, products with A are single precision at first, if the preconditioner has them.
// At convergence, or negative curvature (perhaps from rounding), the residual is formed in double.
// Products in double follow if it exceeds the goal or, with an error goal, twice the earlier
// residual.
class ConjugateGradients {
 public:
  struct Outcome {
    bool converged = false;
    bool indefinite = false;  // A has a direction of negative curvature: the step is too large
    int iterations = 0;
    double residual = 0;     // in the norm of the tolerance
    bool multigrid = false;  // preconditions the last iteration
    int multigrid_set_ups = 0;
  };
  // The conditions under which a solution is good enough.
  struct Goal {
    // Upper bound of the weighted residual's 2-norm (velocity rows, divided by mass). No particle
    // may exceed ten times the mean that this bound implies.
    double residual = std::numeric_limits<double>::infinity();
    // Upper bound of the error e of dv as a fraction of dv: sqrt(e . A e) / sqrt(dv . M dv) or,
    // with Scale::matrix, sqrt(e . A e) / sqrt(dv . A dv). e is estimated from the iterations; the
    // true error may be three times as large (tests/sim/multigrid_test.cpp). 1: only the residual
    // counts.
    double error = 1;
    enum class Scale : std::uint8_t { mass, matrix } scale = Scale::mass;
  };

  // Both arguments must outlive the object.
  ConjugateGradients(const VelocityMatrix& matrix, PreconditionerSelection& preconditioner);

  // Solves A dv = `right_side` from dv = 0; both are zero for pinned particles. All spans have one
  // entry per particle. Precondition: the preconditioner is prepared for this A.
  Outcome solve(std::span<const Vec3> right_side, std::span<const Vec3> weight, const Goal& goal,
                std::span<Vec3> dv);

 private:
  // The arguments of solve().
  struct Solve {
    std::span<const Vec3> right_side, weight;
    const Goal& goal;
    std::span<Vec3> dv;
  };

  void iterate(const Solve& solve, Outcome& outcome);
  bool is_reached(const Goal& goal, double residual) const;
  bool find_direction(bool begins_anew);
  double precondition();
  double advance(double alpha, const Solve& solve);
  void form_residual(const Solve& solve);

  const VelocityMatrix& matrix_;
  PreconditionerSelection& preconditioner_;
  std::vector<Vec3> residual_, preconditioned_;
  std::vector<Vec3> direction_, product_;  // p and A p
  double rho_ = 1, curvature_ = 0;         // r . P r and p . A p
  bool is_exact_ = false;                  // products with A are in double
  bool has_single_products_ = false;       // since the residual was last formed from A
  double start_residual_ = 0;  // of the solve, or when coarse matrices were last formed in it
  std::vector<double> gains_;  // by iteration of this solve
  double dv_square_ = 0;       // dv . M dv
};

}  // namespace weft::sim
