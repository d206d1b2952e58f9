// Direct solution of the system of velocity_system.h.
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

  // Solves A velocity = right_side; both have one entry per particle. Uses the K and D of the last
  // assembly and the contacts of the last evaluation. Returns false if A is not positive definite
  // or the solution is not finite. Costs one factorisation.
  bool solve(double gamma, std::span<const Vec3> right_side, std::span<Vec3> velocity);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::sim
