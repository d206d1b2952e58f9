// The Newton system of an implicit step, reduced to the velocities and solved iteratively.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "sim/base/state_archive.h"
#include "sim/motion/dynamics.h"
#include "sim/solver/conjugate_gradients.h"
#include "sim/solver/direct_solver.h"
#include "sim/solver/hard_systems.h"
#include "sim/solver/preconditioner_selection.h"
#include "sim/solver/velocity_matrix.h"

namespace weft::sim {

// The Newton correction of y - gamma f(y) = const solves (I - gamma J)(dx, dv) = (b_x, b_v). The
// first block row gives dx = b_x + gamma dv. The second one becomes
//   A dv = M b_v - gamma K b_x,   A = M + gamma D + gamma^2 K.
// Conjugate gradients solve this system (conjugate_gradients.h), preconditioned by multigrid or
// block-Jacobi (preconditioner_selection.h). If time.preconditioner is automatic, systems that take
// too many iterations are factorised (hard_systems.h, direct_solver.h).
class VelocitySystem {
 public:
  using Outcome = ConjugateGradients::Outcome;
  using Goal = ConjugateGradients::Goal;

  explicit VelocitySystem(Dynamics& dynamics);

  // Forms A for this gamma (s) from the K and D that the dynamics assembled last.
  void set_up(double gamma);

  // Solves for the correction (dx, dv) of the right-hand side b = (b_x, b_v). All spans have 6 *
  // particles doubles. Only the velocity half of the weights is used. With Goal::from_guess, dv
  // begins as given, and dx does not count.
  Outcome solve(double gamma, std::span<const double> b, std::span<const double> weight,
                const Goal& goal, std::span<double> correction);

  // Solves as solve() does, by a sparse factorisation. Returns false if A is not positive definite
  // or the solution is not finite; the correction is then undefined.
  bool solve_directly(double gamma, std::span<const double> b, std::span<const double> weight,
                      std::span<double> correction);

  // Writes the diagonal blocks of A, contact included, one per particle. Precondition: set_up() has
  // been called for the present matrices.
  void find_diagonal(std::span<Mat3> diagonal) const;

  // Sets a function that may end a solve before it converges (ConjugateGradients::set_stop()).
  void set_stop(std::function<bool()> stop) { conjugate_gradients_.set_stop(std::move(stop)); }

  // Writes or reads the state that determines the bits of later solutions. Reading assembles K and
  // D at the state of the last set-up of coarse matrices, which overwrites the matrices of the
  // dynamics.
  void transfer(StateArchive& archive);

  // Returns the square root of the largest eigenvalue of M^-1 K on the free particles (1/s),
  // estimated from below.
  double highest_frequency() { return preconditioner_.highest_frequency(); }

 private:
  void factorise(double gamma, std::span<const double> b, std::span<const double> weight,
                 std::span<double> correction, Outcome& outcome);
  void form_right_side(const StateView& right, std::span<const Vec3> weight);
  bool has_negligible_positions(const StateView& right, std::span<const Vec3> weight) const;
  StateView with_free_positions(const StateView& right);
  std::span<const Vec3> with_free_velocities(std::span<const Vec3> velocity);
  void complete_correction(const StateView& right, std::span<double> correction) const;

  Dynamics& dynamics_;
  VelocityMatrix matrix_;
  PreconditionerSelection preconditioner_;
  ConjugateGradients conjugate_gradients_;
  HardSystems factorisation_;
  std::unique_ptr<DirectSolver> direct_;  // made at first use
  std::vector<Vec3> right_side_;          // M b_v - gamma K b_x
  std::vector<Vec3> free_position_;       // b_x, zero for pinned particles; used if pins move
  std::vector<Vec3> free_velocity_;  // b_v, zero for pinned particles; used if M is not diagonal
};

}  // namespace weft::sim
