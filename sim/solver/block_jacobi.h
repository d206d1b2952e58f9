// Block-Jacobi preconditioner: the inverses of the diagonal 3x3 blocks of A, contact included.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/solver/preconditioner.h"

namespace weft::sim {

class BlockJacobi : public Preconditioner {
 public:
  // Inverts the diagonal blocks of free particles and returns true. A block that is not positive
  // definite, as may happen under compression, is replaced by the particle's mass. O(particles +
  // contact pairs). While A without contact stays the same, only blocks with contact are inverted.
  bool update(const VelocityMatrix& matrix) override;
  void apply(const VelocityMatrix& matrix, std::span<const Vec3> r, std::span<Vec3> z) override;

 private:
  void invert(const VelocityMatrix& matrix, const Mat3& block, int particle);

  std::vector<Mat3> inverse_;
  std::vector<Mat3> without_contact_, with_contact_;  // the diagonal blocks of A
  std::vector<char> has_contact_;                     // by particle: inverse_ is that with contact
  std::int64_t version_ = -1;  // of the matrix that without_contact_ holds blocks of
};

}  // namespace weft::sim
