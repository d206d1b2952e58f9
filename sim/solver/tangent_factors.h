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

  // Factorises the K last assembled and that of the contacts last evaluated. Returns false if K is
  // singular to working precision. Costs one factorisation.
  bool factorise();
  // Number of negative eigenvalues of K. Precondition, here and below: factorise() returned true.
  int negative_directions() const { return factors_.negative_pivots(); }
  // Solves K displacement = force. Both have one entry per dynamic particle; displacements of held
  // particles become zero, and forces on them are not read. Returns false if the displacement is
  // not finite or does not fulfil the equation: K is then singular but for rounding.
  bool solve(std::span<const Vec3> force, std::span<Vec3> displacement) const;
  // The particle whose pivot is the smallest against its own diagonal entry, also after factorise()
  // returned false: it moves in the direction in which K is weakest. -1 if nothing is free.
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
