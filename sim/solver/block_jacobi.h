// Block-Jacobi preconditioner: the inverses of the diagonal 3x3 blocks of A, contact included.
#pragma once

#include <vector>

#include "sim/solver/preconditioner.h"

namespace weft::sim {

class BlockJacobi : public Preconditioner {
 public:
  // Inverts the diagonal blocks of free particles and returns true. A block that is not positive
  // definite, as may happen under compression, is replaced by the particle's mass. O(particles +
  // contact pairs).
  bool update(const VelocityMatrix& matrix) override;
  void apply(const VelocityMatrix& matrix, std::span<const Vec3> r, std::span<Vec3> z) override;

 private:
  std::vector<Mat3> inverse_;
};

}  // namespace weft::sim
