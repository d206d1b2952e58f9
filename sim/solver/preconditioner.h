// The interface of the preconditioners of conjugate gradients.
#pragma once

#include <span>

#include "sim/solver/velocity_matrix.h"

namespace weft::sim {

// A symmetric, positive definite approximation of the inverse of A, on the free particles.
class Preconditioner {
 public:
  virtual ~Preconditioner() = default;
  // Takes over the present A as far as that is cheap; called before every solve. Returns false if A
  // does not allow it.
  [[nodiscard]] virtual bool update(const VelocityMatrix& matrix) = 0;
  // z = P r. Pinned particles get zero.
  virtual void apply(const VelocityMatrix& matrix, std::span<const Vec3> r, std::span<Vec3> z) = 0;
  // Returns the residual r - A z of the last apply(), with A in single precision and without
  // contact. Empty unless it costs much less than a product with A.
  virtual std::span<const Vec3> residual() const { return {}; }
};

// Inverts a symmetric block. Returns false, without an inverse, if it is not positive definite.
[[nodiscard]] bool invert_definite(const Mat3& block, Mat3& inverse);

}  // namespace weft::sim
