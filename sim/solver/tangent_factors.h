// Factors of the tangent stiffness of an equilibrium, which may be indefinite.
#pragma once

#include <cstdint>
#include <span>

#include "sim/motion/dynamics.h"
#include "sim/solver/free_unknowns.h"
#include "sim/solver/symmetric_factors.h"

namespace weft::sim {

// Factorises K = -dF/dx on the free particles (symmetric_factors.h).
class TangentFactors {
 public:
  explicit TangentFactors(Dynamics& dynamics) : dynamics_(dynamics), unknowns_(dynamics.scene()) {}
  TangentFactors(const TangentFactors&) = delete;
  TangentFactors& operator=(const TangentFactors&) = delete;

  // Factorises FreeUnknowns::stiffness() of the matrices last assembled and the contacts last
  // evaluated, with gamma = 1 s. Returns false if SymmetricFactors::factorise() does, as for a
  // singular K.
  bool factorise();
  // Returns the number of negative eigenvalues of K. Precondition: factorise() returned true.
  int negative_directions() const { return factors_.negative_pivots(); }
  // Solves K displacement = force. Both have one entry per dynamic particle; displacements of held
  // particles become zero, and forces on them are not read. Returns false if the displacement is
  // not finite or does not satisfy the equation. K is then singular up to rounding. Precondition:
  // factorise() returned true.
  bool solve(std::span<const Vec3> force, std::span<Vec3> displacement) const;
  // Returns the particle of SymmetricFactors::weakest(), also after factorise() has returned false.
  // Returns -1 if no particle is free.
  int weakest_particle() const;
  std::int64_t factorisations() const { return count_; }

 private:
  Dynamics& dynamics_;
  FreeUnknowns unknowns_;
  SymmetricFactors::Matrix stiffness_;  // lower half of the K last factorised
  SymmetricFactors factors_;
  std::int64_t count_ = 0;
};

}  // namespace weft::sim
