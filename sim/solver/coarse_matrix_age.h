// The age of the multigrid's coarse matrices, measured in the extra iterations that it causes.
#pragma once

#include "sim/base/state_archive.h"

namespace weft::sim {

// The first solve with new coarse matrices sets the iterations per digit of residual reduction.
// Later solves add their iterations in excess of that rate. The matrices are worn out once the
// excess costs as much as a rebuild. Counts decide instead of times, so that every run decides
// alike (docs/decisions/0016).
class CoarseMatrixAge {
 public:
  // Starts a new age: the coarse matrices have just been formed.
  void reset() { iterations_per_digit_ = excess_iterations_ = 0; }
  // Notes that the present solve starts to use the matrices after `iterations` iterations, at this
  // residual.
  void start(int iterations, double residual);
  // True if the extra iterations of finished solves cost more than new matrices.
  bool is_worn_out() const { return excess_iterations_ > rebuild_cost; }
  // True if the extra iterations of finished solves and of the present one, up to this iteration
  // and residual, cost more than new matrices.
  bool is_worn_out_by(int iterations, double residual) const;
  // Adds the iterations of a solve that ends with this count and residual.
  void finish(int iterations, double residual);

  void transfer(StateArchive& archive) { archive(iterations_per_digit_, excess_iterations_); }

 private:
  static constexpr double rebuild_cost = 2;  // in iterations

  double excess_of(int iterations, double residual) const;

  double iterations_per_digit_ = 0;  // in the first solve with them; 0 before
  double excess_iterations_ = 0;     // in later solves
  int start_iterations_ = 0;         // of the present solve, when it began to use them
  double start_residual_ = 0;
};

}  // namespace weft::sim
