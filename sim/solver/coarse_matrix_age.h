// The age of multigrid's coarse matrices, measured by the extra iterations that old matrices cause.
#pragma once

#include "sim/base/state_archive.h"

namespace weft::sim {

// The first solve that takes iterations with new coarse matrices sets the rate, the iterations per
// digit of residual reduction. Later solves add their iterations in excess of that rate. The
// matrices are worn out once these extra iterations cost more than a rebuild. Iterations are
// counted instead of timed, so the decision is the same in every run (docs/decisions/0016).
class CoarseMatrixAge {
 public:
  // Resets the age to zero. To be called when the coarse matrices have just been formed.
  void reset() { iterations_per_digit_ = excess_iterations_ = 0; }
  // Records the iterations and the residual that the present solve has reached when it begins to
  // use the matrices.
  void start(int iterations, double residual);
  // True if the extra iterations of finished solves cost more than a rebuild.
  bool is_worn_out() const { return excess_iterations_ > rebuild_cost; }
  // True if the extra iterations of finished solves and of the present one cost more than a
  // rebuild. The arguments are the present solve's iterations and residual so far.
  bool is_worn_out_by(int iterations, double residual) const;
  // Records a finished solve: sets the rate, or adds the extra iterations. Does nothing if the
  // solve took no iteration since start(). The arguments are its total iterations and its final
  // residual.
  void finish(int iterations, double residual);

  void transfer(StateArchive& archive) { archive(iterations_per_digit_, excess_iterations_); }

 private:
  static constexpr double rebuild_cost = 2;  // cost of a rebuild, in iterations

  double excess_of(int iterations, double residual) const;

  double iterations_per_digit_ = 0;  // rate of the first solve with the matrices; 0: unknown
  double excess_iterations_ = 0;     // extra iterations of later solves
  int start_iterations_ = 0;         // iterations of the present solve at start()
  double start_residual_ = 0;
};

}  // namespace weft::sim
