#include "sim/solver/block_jacobi.h"

#include <Eigen/LU>

#include "sim/base/parallel.h"

namespace weft::sim {

bool invert_definite(const Mat3& block, Mat3& inverse) {
  const double minor = block(0, 0) * block(1, 1) - block(0, 1) * block(1, 0);
  if (!(block(0, 0) > 0 && minor > 0 && block.determinant() > 0)) return false;
  inverse = block.inverse();
  return true;
}

bool BlockJacobi::update(const VelocityMatrix& matrix) {
  const BlockPattern& pattern = *matrix.pattern();
  inverse_.resize(pattern.rows());
  for (int i = 0; i < pattern.rows(); ++i) inverse_[i] = matrix.block(i, pattern.diagonal_slot(i));
  if (matrix.has_contact()) matrix.dynamics().contact()->add_diagonal(matrix.gamma(), inverse_);
  for (int i = 0; i < pattern.rows(); ++i) {
    const Mat3 block = inverse_[i];
    if (matrix.scene().pinned[i] != 0) {
      inverse_[i].setZero();
    } else if (!invert_definite(block, inverse_[i])) {
      inverse_[i] = Mat3::Identity() / matrix.scene().mass[i];
    }
  }
  return true;
}

void BlockJacobi::apply(const VelocityMatrix& matrix, std::span<const Vec3> r, std::span<Vec3> z) {
  parallel_chunks(static_cast<int>(r.size()), matrix.threads(), [&](int first, int last) {
    for (int i = first; i < last; ++i) z[i] = inverse_[i] * r[i];
  });
}

}  // namespace weft::sim
