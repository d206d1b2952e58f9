#include "sim/solver/coarse_matrix_age.h"

#include <algorithm>
#include <cmath>

namespace weft::sim {

void CoarseMatrixAge::start(int iterations, double residual) {
  start_iterations_ = iterations;
  start_residual_ = residual;
}

// Returns the number of iterations since start() in excess of the first solve's iterations per
// digit, or 0 if that rate is unknown.
double CoarseMatrixAge::excess_of(int iterations, double residual) const {
  if (iterations_per_digit_ == 0) return 0;
  const double digits = std::log10(start_residual_ / residual);
  return iterations - start_iterations_ - iterations_per_digit_ * std::max(digits, 0.0);
}

bool CoarseMatrixAge::is_worn_out_by(int iterations, double residual) const {
  return excess_iterations_ + excess_of(iterations, residual) > rebuild_cost;
}

void CoarseMatrixAge::finish(int iterations, double residual) {
  const int taken = iterations - start_iterations_;
  if (taken == 0) return;
  if (iterations_per_digit_ == 0) {
    const double digits = std::log10(start_residual_ / residual);
    iterations_per_digit_ = taken / std::max(digits, 0.5);
  } else {
    excess_iterations_ += std::max(0.0, excess_of(iterations, residual));
  }
}

}  // namespace weft::sim
