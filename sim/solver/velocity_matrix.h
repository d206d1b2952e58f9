// The Newton matrix of an implicit step, reduced to the velocities.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sim/matrix/tiled_matrix.h"
#include "sim/motion/dynamics.h"

namespace weft::sim {

// The matrix A = M + gamma D + gamma^2 K, symmetric, with K = -dF/dx and D = -dF/dv. Products leave
// out the rows and columns of pinned particles. Contact contributes through the pairs of the last
// force evaluation, all other forces through the stored K and D.
class VelocityMatrix {
 public:
  explicit VelocityMatrix(const Dynamics& dynamics);

  // Forms A for this gamma (s) from the K and D that the dynamics assembled last. If the dynamics
  // store no D, nothing is stored here, and products read K. Otherwise, A without contact is
  // stored, in single precision where that is enough (docs/decisions/0092). O(blocks), about the
  // cost of three products.
  void form(double gamma);
  bool is_single() const { return is_single_; }
  double gamma() const { return gamma_; }
  // Returns the number of calls of form() so far.
  std::int64_t version() const { return version_; }
  const Dynamics& dynamics() const { return dynamics_; }
  const Scene& scene() const { return dynamics_.scene(); }
  int threads() const { return dynamics_.threads(); }

  const std::shared_ptr<const BlockPattern>& pattern() const {
    return dynamics_.stiffness().shared_pattern();
  }
  // Copies A without contact, including rows and columns of pinned particles, into a matrix whose
  // pattern contains this one. O(blocks).
  void copy_to(SingleBlockMatrix& matrix) const;
  // Returns a block of A without contact.
  Mat3 block(int row, int slot) const;
  bool has_contact() const {
    return dynamics_.contact() != nullptr && dynamics_.contact()->pairs_in_reach() > 0;
  }
  // Adds the product of the contact part of A with `in` to `out`.
  void add_contact_product(std::span<const Vec3> in, std::span<Vec3> out) const;
  // Sets the entries of pinned particles to zero.
  void clear_pinned(std::span<Vec3> velocity) const;
  // Computes out = A in, with zeros for pinned particles. Precondition: `in` is zero for them.
  void multiply(std::span<const Vec3> in, std::span<Vec3> out) const;

 private:
  template <class Matrix>
  void form_in(Matrix& matrix, double gamma);
  template <class Matrix>
  void add_mass(int row, Matrix& matrix) const;
  template <class Matrix>
  void copy_between(const Matrix& from, SingleBlockMatrix& to) const;
  bool is_far_above_rounding(double gamma) const;

  const Dynamics& dynamics_;
  const bool may_be_single_;
  // A without contact; unused without D. Only the one that is_single_ tells is up to date.
  TiledMatrix<double> damped_;
  TiledMatrix<float> damped_single_;
  bool is_single_ = false;
  std::vector<int> pinned_;
  double gamma_ = 0;
  std::int64_t version_ = 0;
};

}  // namespace weft::sim
