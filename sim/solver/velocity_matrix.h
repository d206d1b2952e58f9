// The Newton matrix of an implicit step, reduced to the velocities.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sim/motion/dynamics.h"

namespace weft::sim {

// A = M + gamma D + gamma^2 K, symmetric, with K = -dF/dx and D = -dF/dv, over the free particles:
// what belongs to pinned ones is left out of every product. Contact enters through its pairs, as
// they were at the last force evaluation; the rest through K and D as they are stored.
class VelocityMatrix {
 public:
  explicit VelocityMatrix(const Dynamics& dynamics);

  // Uses this gamma and the K and D last assembled by the dynamics from now on. Without D, products
  // read K and nothing is formed. With D, K and D are joined once, O(blocks), which costs less than
  // a product.
  void form(double gamma);
  double gamma() const { return gamma_; }
  // Number of times the matrix was formed: another number means another matrix.
  std::int64_t version() const { return version_; }
  const Dynamics& dynamics() const { return dynamics_; }
  const Scene& scene() const { return dynamics_.scene(); }
  int threads() const { return dynamics_.threads(); }

  const std::shared_ptr<const BlockPattern>& pattern() const {
    return dynamics_.stiffness().shared_pattern();
  }
  // A without contact, rows and columns of pinned particles included, into a matrix whose pattern
  // has at least its blocks. O(blocks).
  void copy_to(SingleBlockMatrix& matrix) const;
  // One of its blocks.
  Mat3 block(int row, int slot) const;
  bool has_contact() const {
    return dynamics_.contact() != nullptr && dynamics_.contact()->pairs_in_reach() > 0;
  }
  // out += contact part * in.
  void add_contact_product(std::span<const Vec3> in, std::span<Vec3> out) const;
  // Zero for pinned particles.
  void clear_pinned(std::span<Vec3> velocity) const;
  // out = A in, zero for pinned particles, for which `in` must be zero.
  void multiply(std::span<const Vec3> in, std::span<Vec3> out) const;

 private:
  const Dynamics& dynamics_;
  BlockMatrix damped_;  // A without contact, where there is D
  std::vector<int> pinned_;
  double gamma_ = 0;
  std::int64_t version_ = 0;
};

}  // namespace weft::sim
