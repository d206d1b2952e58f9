#include "sim/solver/block_jacobi.h"

#include <algorithm>

#include "materials/lanes.h"
#include "sim/base/parallel.h"

namespace weft::sim {

using materials::Lanes;

// Decomposes the block as L D L^T. Cofactors and a determinant would lose all digits beside a stiff
// contact pair: their errors grow with the square of the ratio of stiffness to mass.
bool invert_definite(const Mat3& block, Mat3& inverse) {
  const double d0 = block(0, 0);
  const double l1 = block(0, 1) / d0, l2 = block(0, 2) / d0;  // first column of L
  const double d1 = block(1, 1) - l1 * block(0, 1);
  const double rest = block(1, 2) - l1 * block(0, 2), l3 = rest / d1;
  const double d2 = block(2, 2) - l2 * block(0, 2) - l3 * rest;
  if (!(d0 > 0 && d1 > 0 && d2 > 0)) return false;
  const double m = l1 * l3 - l2;  // L^-1 has the rows (1, 0, 0), (-l1, 1, 0), (m, -l3, 1)
  const double xx = 1 / d0 + l1 * l1 / d1 + m * m / d2, xy = -l1 / d1 - l3 * m / d2;
  const double yy = 1 / d1 + l3 * l3 / d2, xz = m / d2, yz = -l3 / d2;
  inverse << xx, xy, xz, xy, yy, yz, xz, yz, 1 / d2;
  return true;
}

void BlockJacobi::invert(const VelocityMatrix& matrix, const Mat3& block, int particle) {
  Mat3 inverse;
  if (matrix.scene().pinned[particle] != 0) {
    inverse.setZero();
  } else if (!invert_definite(block, inverse)) {
    inverse = Mat3::Identity() / matrix.scene().mass[particle];
  }
  for (int i = 0; i < 3; ++i) inverse_[i][particle] = inverse(i, i);
  inverse_[3][particle] = inverse(0, 1);
  inverse_[4][particle] = inverse(0, 2);
  inverse_[5][particle] = inverse(1, 2);
}

void BlockJacobi::invert_all(const VelocityMatrix& matrix) {
  const BlockPattern& pattern = *matrix.pattern();
  const int count = pattern.rows();
  version_ = matrix.version();
  without_contact_.resize(count);
  for (std::vector<double>& each : inverse_) each.resize(count);
  is_found_.resize(count, 0);
  touched_.clear();
  parallel_chunks(count, matrix.threads(), [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      without_contact_[i] = matrix.block(i, pattern.diagonal_slot(i));
      invert(matrix, without_contact_[i], i);
    }
  });
  with_contact_ = without_contact_;
}

// Inverts the blocks of the particles in contact, and those that had contact before.
void BlockJacobi::invert_touched(const VelocityMatrix& matrix) {
  const std::vector<int> before = std::move(touched_);
  touched_.clear();
  if (matrix.has_contact()) {
    const Contact& contact = *matrix.dynamics().contact();
    for (const int i : contact.add_diagonal(matrix.gamma(), with_contact_)) {
      if (is_found_[i] == 0) touched_.push_back(i);
      is_found_[i] = 1;
    }
  }
  for (const int i : before)
    if (is_found_[i] == 0) invert(matrix, without_contact_[i], i);
  parallel_chunks(static_cast<int>(touched_.size()), matrix.threads(), [&](int first, int last) {
    for (int k = first; k < last; ++k) {
      const int i = touched_[k];
      invert(matrix, with_contact_[i], i);
      with_contact_[i] = without_contact_[i];
      is_found_[i] = 0;
    }
  });
}

bool BlockJacobi::update(const VelocityMatrix& matrix) {
  if (matrix.version() != version_) invert_all(matrix);
  invert_touched(matrix);
  return true;
}

double BlockJacobi::apply(const VelocityMatrix& matrix, std::span<const Vec3> r,
                          std::span<Vec3> z) {
  const auto product = [&](const auto& x, const auto& at) {
    return std::array{at(0) * x[0] + at(3) * x[1] + at(4) * x[2],
                      at(3) * x[0] + at(1) * x[1] + at(5) * x[2],
                      at(4) * x[0] + at(5) * x[1] + at(2) * x[2]};
  };
  return parallel_sum(static_cast<int>(r.size()), matrix.threads(), [&](int first, int last) {
    Lanes sums = 0;
    int i = first;
    for (; i + materials::lane_count <= last; i += materials::lane_count) {
      const auto x = materials::load_vectors(r[i].data());
      const auto found =
          product(x, [&](int entry) { return materials::lanes_at(&inverse_[entry][i]); });
      for (int axis = 0; axis < 3; ++axis) sums += x[axis] * found[axis];
      std::fill(z.begin() + i, z.begin() + i + materials::lane_count, Vec3::Zero());
      materials::add_vectors(found, z[i].data());
    }
    double sum = materials::sum_of_lanes(sums);
    for (; i < last; ++i) {
      const auto found = product(r[i], [&](int entry) { return inverse_[entry][i]; });
      z[i] = Vec3(found[0], found[1], found[2]);
      sum += r[i].dot(z[i]);
    }
    return sum;
  });
}

}  // namespace weft::sim
