// The Newton system of an implicit step, reduced to the velocities and solved iteratively.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "sim/base/state_archive.h"
#include "sim/motion/dynamics.h"
#include "sim/solver/block_jacobi.h"
#include "sim/solver/direct_solver.h"
#include "sim/solver/multigrid.h"
#include "sim/solver/velocity_matrix.h"

namespace weft::sim {

// For the Newton correction of y - gamma f(y) = const, (I - gamma J)(dx, dv) = (b_x, b_v), the
// first rows give dx = b_x + gamma dv, and the second
//   A dv = M b_v - gamma K b_x,   A = M + gamma D + gamma^2 K.
// This is solved by preconditioned conjugate gradients. Multigrid is the preconditioner where gamma
// times the highest frequency makes it worth its set-up (or time.preconditioner says so).
// Block-Jacobi is used elsewhere, and wherever multigrid meets a matrix that is not positive
// definite.
//
// Systems of as long a gamma are factorised (direct_solver.h) once iterations cost more than that,
// unless time.preconditioner names a preconditioner. Iterations are tried again
// after eight such systems, then after twice as many each time that they take too long again.
//
// The coarse matrices are reused until the extra iterations they cause cost as much as new ones.
// Iterations are compared digit for digit with those of the first solve with these matrices. Where
// the matrices wear out within a solve, the next assemblies of K get new ones at once. Counts
// decide, not times.
class VelocitySystem {
 public:
  explicit VelocitySystem(Dynamics& dynamics);

  // Forms A for this gamma from the K and D last assembled by the dynamics.
  void set_up(double gamma);

  struct Outcome {
    bool converged = false;
    bool indefinite = false;  // A has a direction of negative curvature: the step is too large
    int iterations = 0;
    double residual = 0;     // in the norm of the tolerance
    bool multigrid = false;  // what the last iteration was preconditioned with
    int multigrid_set_ups = 0;
  };
  // When a solution is good enough.
  struct Goal {
    // Upper bound of the weighted residual's 2-norm (velocity rows, divided by mass). No particle
    // may exceed ten times the mean that this bound implies.
    double residual = std::numeric_limits<double>::infinity();
    // Upper bound of the error e of dv, as conjugate gradients estimate it: sqrt(e . A e) as a
    // fraction of sqrt(dv . M dv) or, with Scale::matrix, of sqrt(dv . A dv). The true error may be
    // three times as large (tests/sim/multigrid_test.cpp). 1: the residual alone counts.
    double error = 1;
    enum class Scale : std::uint8_t { mass, matrix } scale = Scale::mass;
  };
  // Solves for the correction (x, v) of right-hand side b, both 6 * particles doubles, as are the
  // weights, whose velocity half is used.
  Outcome solve(double gamma, std::span<const double> b, std::span<const double> weight,
                const Goal& goal, std::span<double> correction);

  // Writes or reads all that the bits of later solutions depend on. Coarse matrices are not written
  // but formed anew, from K and D assembled where they were then: the dynamics' matrices are others
  // afterwards.
  void transfer(StateArchive& archive);

  // sqrt of the largest eigenvalue of M^-1 K on the free particles (1/s), from below.
  double highest_frequency();

 private:
  bool factorise(double gamma, std::span<const double> b, std::span<double> correction,
                 Outcome& outcome);
  void form_right_side(const StateView& right);
  StateView with_free_positions(const StateView& right);
  void form_residual(std::span<const Vec3> dv);
  void iterate(std::span<const Vec3> weight, const Goal& goal, std::span<Vec3> dv,
               Outcome& outcome);
  bool is_reached(const Goal& goal, double residual) const;
  bool turn(bool starts_anew, double& rho, double& curvature);
  double precondition();  // z = P r; returns r.z
  double advance(double alpha, std::span<const Vec3> weight, Vec3* dv);

  bool wants_multigrid();
  void prepare(Outcome& outcome);
  bool set_up_multigrid(Outcome& outcome);
  void use_block_jacobi();
  bool renew(Outcome& outcome);
  double excess(const Outcome& outcome) const;
  void note_iterations(const Outcome& outcome);

  Dynamics& dynamics_;
  VelocityMatrix matrix_;
  BlockJacobi block_jacobi_;
  std::unique_ptr<Multigrid> multigrid_;                              // made when first wanted
  std::unique_ptr<DirectSolver> direct_;                              // made when first wanted
  double factorised_from_ = std::numeric_limits<double>::infinity();  // gamma, s
  // Factorised systems before iterations are tried again, and how many there are of these left.
  int factorisation_patience_ = 0, factorisations_left_ = 0;
  double hard_gamma_ = 0;  // s, of the last system that took too many iterations
  Preconditioner* preconditioner_ = &block_jacobi_;
  bool is_exact_ = false;             // products with A are in double
  bool has_single_products_ = false;  // behind the residual, since it was last formed from A itself
  std::vector<double> gains_;         // of the iterations of this solve
  double dv_square_ = 0;              // dv . M dv
  std::vector<Vec3> right_side_, residual_, direction_, product_, preconditioned_;
  std::vector<Vec3> free_position_;  // of b, zero where particles are pinned; where pins move

  // State of the multigrid's coarse matrices.
  bool is_set_up_ = false;
  double iterations_a_digit_ = 0;     // of the first solve with them; 0 before
  double excess_iterations_ = 0;      // beyond that since
  Linearisation set_up_place_;        // of the dynamics then
  double set_up_gamma_ = 0;           // s
  std::int64_t set_up_assembly_ = 0;  // of K; those before `renewed_until_` are not waited with
  std::int64_t renewed_until_ = 0;
  int start_iterations_ = 0;  // when the present solve began to use them
  double start_residual_ = 0;
  double frequency_ = -1;  // 1/s
  std::int64_t frequency_assembly_ = 0;
};

}  // namespace weft::sim
