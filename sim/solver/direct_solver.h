// The Newton matrix of velocity_system.h, factorised.
#pragma once

#include <memory>
#include <span>

#include "sim/motion/dynamics.h"

namespace weft::sim {

// A = M + gamma D + gamma^2 K with contact and with prescribed particles held, by a sparse LDL^T.
// For what conjugate gradients cannot do: long pseudo-steps, where A is hardly more than a
// stiffness of many orders of magnitude.
class DirectSolver {
 public:
  explicit DirectSolver(Dynamics& dynamics);
  ~DirectSolver();
  DirectSolver(const DirectSolver&) = delete;
  DirectSolver& operator=(const DirectSolver&) = delete;

  // Solves (I - gamma J) correction = b, both 6 * particles doubles, with the K and D last
  // assembled and the contacts last evaluated. False where A is not positive definite. Cost: a
  // factorisation.
  bool solve(double gamma, std::span<const double> b, std::span<double> correction);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::sim
