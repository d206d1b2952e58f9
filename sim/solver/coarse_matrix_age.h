// The age of the multigrid's coarse matrices, in iterations that it costs.
#pragma once

#include "sim/base/state_archive.h"

namespace weft::sim {

// Iterations are compared, digit for digit, with those of the first solve with the same coarse
// matrices. The iterations in excess of these add up over later solves; the matrices are worn out
// once they cost as much as new ones. Counts decide, not times (docs/decisions/0016).
class CoarseMatrixAge {
 public:
  // Notes that the coarse matrices are new.
  void reset() { iterations_per_digit_ = excess_iterations_ = 0; }
  // Notes that a solve starts to use them, after this many iterations and with this residual.
  void start(int iterations, double residual);
  // True if the extra iterations have come to cost as much as new matrices.
  bool is_worn_out() const { return excess_iterations_ > rebuild_cost; }
  // The equivalent with those of the solve in hand, which has come to these values.
  bool is_worn_out_by(int iterations, double residual) const;
  // Adds the iterations of a solve that ends with these values.
  void finish(int iterations, double residual);

  void transfer(StateArchive& archive) { archive(iterations_per_digit_, excess_iterations_); }

 private:
  static constexpr double rebuild_cost = 2;  // of the coarse matrices, in iterations

  double excess_of(int iterations, double residual) const;

  double iterations_per_digit_ = 0;  // of the first solve with them; 0 before
  double excess_iterations_ = 0;     // of later solves
  int start_iterations_ = 0;         // of the solve in hand, when it began to use them
  double start_residual_ = 0;
};

}  // namespace weft::sim
