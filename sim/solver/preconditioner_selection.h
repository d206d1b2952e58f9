// The choice between multigrid and block-Jacobi, and between old and new coarse matrices.
#pragma once

#include <cstdint>
#include <memory>

#include "sim/base/state_archive.h"
#include "sim/solver/block_jacobi.h"
#include "sim/solver/coarse_matrix_age.h"
#include "sim/solver/frequency_estimate.h"
#include "sim/solver/hard_systems.h"
#include "sim/solver/multigrid.h"
#include "sim/solver/velocity_matrix.h"

namespace weft::sim {

// Multigrid or block-Jacobi is chosen if time.preconditioner names it. Otherwise, multigrid is
// chosen if gamma times the highest frequency makes its set-up worthwhile, else block-Jacobi.
// Block-Jacobi also replaces multigrid if the matrix proves not to be positive definite. Multigrid
// replaces block-Jacobi within a solve that takes too many iterations, and in the systems that
// follow (hard_systems.h).
//
// The coarse matrices are reused until they are worn out (coarse_matrix_age.h), or until contact
// comes of which they know nothing. If they wear out within a solve, they are rebuilt at once.
// During the next nine assemblies, they are rebuilt for every new K.
class PreconditionerSelection {
 public:
  // `matrix` must outlive the object.
  PreconditionerSelection(Dynamics& dynamics, VelocityMatrix& matrix);

  // Chooses the preconditioner of the next solve and brings it up to date.
  void prepare();
  Preconditioner& chosen() const { return *chosen_; }
  bool is_multigrid() const { return chosen_ != &block_jacobi_; }
  // Returns the number of times that coarse matrices were formed since the last prepare() began.
  int multigrid_set_ups() const { return set_ups_; }

  // To be called at the start of a solve, with its residual.
  void start_solve(double residual) { age_.start(0, residual); }
  // To be called at the end of a solve, with its iterations and its final residual.
  void finish_solve(int iterations, double residual);
  // Rebuilds the coarse matrices if they have worn out within the present solve. The solve
  // continues with the new matrices or, if they are not positive definite, with block-Jacobi. Takes
  // multigrid if the solve has taken too many iterations with block-Jacobi. Returns true if the
  // preconditioner has changed.
  bool rebuild_if_worn_out(int iterations, double residual);
  // Uses block-Jacobi for the rest of the solve; the next solve with multigrid rebuilds the coarse
  // matrices.
  void give_up_multigrid();

  // Returns the square root of the largest eigenvalue of M^-1 K on the free particles (1/s),
  // estimated from below.
  double highest_frequency() { return frequency_.highest(); }

  // Writes or reads the state that determines the bits of later solutions. Coarse matrices are not
  // written. Reading forms them again: from the finest one if it has contact, whose pairs depend on
  // more than the state. Otherwise it assembles K and D at the state of their set-up, which
  // overwrites the matrices of the dynamics.
  void transfer(StateArchive& archive);

 private:
  bool wants_multigrid();
  void make_multigrid();
  bool must_rebuild() const;
  bool rebuild_coarse_matrices();
  void use_block_jacobi();
  std::int64_t assembly() const;

  Dynamics& dynamics_;
  VelocityMatrix& matrix_;
  FrequencyEstimate frequency_;
  BlockJacobi block_jacobi_;
  HardSystems for_block_jacobi_;          // systems that take multigrid, though gamma is short
  bool may_leave_block_jacobi_ = false;   // in the present solve
  std::unique_ptr<Multigrid> multigrid_;  // made at first use
  Preconditioner* chosen_ = &block_jacobi_;

  // True if the coarse matrices have been formed and are positive definite.
  bool is_set_up_ = false;
  CoarseMatrixAge age_;
  Linearisation set_up_place_;        // linearisation behind the coarse matrices
  double set_up_gamma_ = 0;           // gamma of the coarse matrices (s)
  std::int64_t set_up_assembly_ = 0;  // count of assemblies at the set-up of the coarse matrices
  std::int64_t rebuilt_until_ = 0;    // count of assemblies below which each new K causes a rebuild
  int set_ups_ = 0;
};

}  // namespace weft::sim
