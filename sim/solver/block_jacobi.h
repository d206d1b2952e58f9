// Block-Jacobi preconditioner: the inverses of the diagonal 3x3 blocks of A, contact included.
#pragma once

#include <array>
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
  double apply(const VelocityMatrix& matrix, std::span<const Vec3> r, std::span<Vec3> z) override;

 private:
  static constexpr int entries = 6;  // of a symmetric block: xx, yy, zz, xy, xz, yz

  void invert_all(const VelocityMatrix& matrix);
  void invert(const VelocityMatrix& matrix, const Mat3& block, int particle);
  void invert_touched(const VelocityMatrix& matrix);

  std::array<std::vector<double>, entries> inverse_;  // by entry and particle
  // The diagonal blocks of A. Between calls, both are the same.
  std::vector<Mat3> without_contact_, with_contact_;
  std::vector<int> touched_;    // particles whose inverses are those with contact, once each
  std::vector<char> is_found_;  // scratch, by particle: zero between calls
  std::int64_t version_ = -1;   // of the matrix that without_contact_ holds blocks of
};

}  // namespace weft::sim
