// Direct solution of the Newton system of velocity_system.h.
#pragma once

#include <memory>
#include <span>

#include "sim/motion/dynamics.h"

namespace weft::sim {

// Factorises A = M + gamma D + gamma^2 K, contact included, as a sparse LDL^T. Pinned particles
// keep only their mass. Intended for systems that conjugate gradients cannot solve, for example in
// long pseudo-steps. There A is nearly a pure stiffness matrix, whose entries span many orders of
// magnitude.
class DirectSolver {
 public:
  explicit DirectSolver(Dynamics& dynamics);
  ~DirectSolver();
  DirectSolver(const DirectSolver&) = delete;
  DirectSolver& operator=(const DirectSolver&) = delete;

  // Solves (I - gamma J) correction = b; both have 6 * particles doubles. Uses the K and D of the
  // last assembly and the contacts of the last evaluation. Returns false if A is not positive
  // definite or the solution is not finite. Costs one factorisation.
  bool solve(double gamma, std::span<const double> b, std::span<double> correction);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::sim
