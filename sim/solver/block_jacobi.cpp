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

void BlockJacobi::invert(const VelocityMatrix& matrix, const Mat3& block, int particle) {
  Mat3& inverse = inverse_[particle];
  if (matrix.scene().pinned[particle] != 0) {
    inverse.setZero();
  } else if (!invert_definite(block, inverse)) {
    inverse = Mat3::Identity() / matrix.scene().mass[particle];
  }
}

bool BlockJacobi::update(const VelocityMatrix& matrix) {
  const BlockPattern& pattern = *matrix.pattern();
  const int count = pattern.rows();
  if (matrix.version() != version_) {
    version_ = matrix.version();
    without_contact_.resize(count);
    inverse_.resize(count);
    has_contact_.assign(count, 0);
    parallel_chunks(count, matrix.threads(), [&](int first, int last) {
      for (int i = first; i < last; ++i) {
        without_contact_[i] = matrix.block(i, pattern.diagonal_slot(i));
        invert(matrix, without_contact_[i], i);
      }
    });
  }
  const bool has_contact = matrix.has_contact();
  if (has_contact) {
    with_contact_ = without_contact_;
    matrix.dynamics().contact()->add_diagonal(matrix.gamma(), with_contact_);
  }
  const std::vector<Mat3>& blocks = has_contact ? with_contact_ : without_contact_;
  parallel_chunks(count, matrix.threads(), [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      const bool touches = has_contact && blocks[i] != without_contact_[i];
      if (touches || has_contact_[i] != 0) invert(matrix, blocks[i], i);
      has_contact_[i] = touches ? 1 : 0;
    }
  });
  return true;
}

void BlockJacobi::apply(const VelocityMatrix& matrix, std::span<const Vec3> r, std::span<Vec3> z) {
  parallel_chunks(static_cast<int>(r.size()), matrix.threads(), [&](int first, int last) {
    for (int i = first; i < last; ++i) z[i] = inverse_[i] * r[i];
  });
}

}  // namespace weft::sim
