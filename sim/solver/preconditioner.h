// The interface of preconditioners for conjugate gradients.
#pragma once

#include <span>

#include "sim/solver/velocity_matrix.h"

namespace weft::sim {

// A symmetric, positive definite approximation of the inverse of A, on the free particles.
class Preconditioner {
 public:
  virtual ~Preconditioner() = default;
  // Adapts the preconditioner to the present A as far as that is cheap. Returns false if A does not
  // allow it, because A is not positive definite. apply() must then not be called.
  [[nodiscard]] virtual bool update(const VelocityMatrix& matrix) = 0;
  // Computes z = P r, and returns r . z. Entries of pinned particles are zero.
  virtual double apply(const VelocityMatrix& matrix, std::span<const Vec3> r,
                       std::span<Vec3> z) = 0;
  // Returns the residual r - A z of the last apply(), with A in single precision and without
  // contact. Returns nothing if the preconditioner cannot provide it at much less than the cost of
  // a product with A.
  virtual std::span<const Vec3> residual() const { return {}; }
};

// Inverts a symmetric block, of which it reads the upper half. Returns false, and leaves `inverse`
// unchanged, if the block is not positive definite.
[[nodiscard]] bool invert_definite(const Mat3& block, Mat3& inverse);

}  // namespace weft::sim
