// Direct solution of the Newton system of velocity_system.h.
#pragma once

#include <memory>
#include <span>

#include "sim/motion/dynamics.h"

namespace weft::sim {

// Factorises A = M + gamma D + gamma^2 K, contact included, as a sparse LDL^T; pinned particles
// keep only their mass. Serves systems that conjugate gradients cannot solve, such as long
// pseudo-steps: there A is nearly a pure stiffness whose entries span many orders of magnitude.
class DirectSolver {
 public:
  explicit DirectSolver(Dynamics& dynamics);
  ~DirectSolver();
  DirectSolver(const DirectSolver&) = delete;
  DirectSolver& operator=(const DirectSolver&) = delete;

  // Solves (I - gamma J) correction = b, both 6 * particles doubles, with the K and D last
  // assembled and the contacts last evaluated. Returns false if A is not positive definite. Costs
  // one factorisation.
  bool solve(double gamma, std::span<const double> b, std::span<double> correction);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::sim
