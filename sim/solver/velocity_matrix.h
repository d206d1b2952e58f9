// The Newton matrix of an implicit step, reduced to the velocities.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sim/integrator/dynamics.h"

namespace weft::sim {

// A = M + gamma D + gamma^2 K, symmetric, with K = -dF/dx and D = -dF/dv, over the free particles:
// what belongs to pinned ones is left out of every product. Contact enters through its pairs, as
// they were at the last force evaluation; the rest through a block matrix.
class VelocityMatrix {
 public:
  explicit VelocityMatrix(const Dynamics& dynamics);

  // Takes the K and D last assembled by the dynamics. O(blocks).
  void form(double gamma);
  double gamma() const { return gamma_; }
  // How often it was formed: another number, another matrix.
  std::int64_t version() const { return version_; }
  const Dynamics& dynamics() const { return dynamics_; }
  const Scene& scene() const { return dynamics_.scene(); }
  int threads() const { return dynamics_.threads(); }

  // A without contact, rows and columns of pinned particles included.
  const BlockMatrix& blocks() const { return blocks_; }
  bool has_contact() const {
    return dynamics_.contact() != nullptr && dynamics_.contact()->pairs_in_reach() > 0;
  }
  // out += contact part * in.
  void add_contact_product(std::span<const Vec3> in, std::span<Vec3> out) const;
  // out = A in, zero for pinned particles, for which `in` must be zero.
  void multiply(std::span<const Vec3> in, std::span<Vec3> out) const;

 private:
  const Dynamics& dynamics_;
  BlockMatrix blocks_;
  std::vector<int> pinned_;
  double gamma_ = 0;
  std::int64_t version_ = 0;
};

}  // namespace weft::sim
