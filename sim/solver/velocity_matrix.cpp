#include "sim/solver/velocity_matrix.h"

#include "sim/base/parallel.h"

namespace weft::sim {

VelocityMatrix::VelocityMatrix(const Dynamics& dynamics) : dynamics_(dynamics) {
  for (int i = 0; i < dynamics.particle_count(); ++i) {
    if (dynamics.scene().pinned[i] != 0) pinned_.push_back(i);
  }
}

void VelocityMatrix::form(double gamma) {
  gamma_ = gamma;
  ++version_;
  if (!dynamics_.has_damping()) return;
  if (damped_.is_empty()) damped_ = BlockMatrix(pattern());
  parallel_chunks(pattern()->rows(), threads(), [&](int first, int last) {
    damped_.set_rows(first, last, gamma * gamma, dynamics_.stiffness(), gamma, dynamics_.damping());
    for (int row = first; row < last; ++row) add_mass(row, damped_);
  });
}

void VelocityMatrix::add_mass(int row, BlockMatrix& matrix) const {
  const MassOperator& mass = dynamics_.mass();
  const int diagonal = pattern()->diagonal_slot(row);
  const int end = mass.is_diagonal() ? diagonal + 1 : pattern()->row_end(row);
  for (int slot = diagonal; slot < end; ++slot)
    matrix.upper_block(pattern()->upper(row, slot)).diagonal().array() += mass.at(row, slot);
}

Mat3 VelocityMatrix::block(int row, int slot) const {
  if (dynamics_.has_damping()) return damped_.block(row, slot);
  Mat3 result = gamma_ * gamma_ * dynamics_.stiffness().block(row, slot);
  result.diagonal().array() += dynamics_.mass().at(row, slot);
  return result;
}

void VelocityMatrix::copy_to(SingleBlockMatrix& matrix) const {
  using Nine = Eigen::Array<double, 9, 1>;
  using Numbers = Eigen::Map<const Nine>;
  const BlockPattern& here = *pattern();
  const BlockPattern& there = matrix.pattern();
  const bool is_damped = dynamics_.has_damping();
  const BlockMatrix& stored = is_damped ? damped_ : dynamics_.stiffness();
  const double factor = is_damped ? 1 : gamma_ * gamma_;
  const MassOperator& mass = dynamics_.mass();
  const bool is_lumped = mass.is_diagonal();
  if (there.block_count() != here.block_count()) matrix.set_zero();
  parallel_chunks(here.rows(), dynamics_.threads(), [&](int first, int last) {
    for (int row = first; row < last; ++row) {
      const int diagonal = here.diagonal_slot(row);
      int target = there.diagonal_slot(row), upper = here.upper(row, diagonal);
      for (int slot = diagonal; slot < here.row_end(row); ++slot, ++target, ++upper) {
        while (there.column(target) != here.column(slot)) ++target;
        Nine sum = factor * Numbers(stored.upper_block(upper).data());
        if (!is_damped && (slot == diagonal || !is_lumped))
          for (int i : {0, 4, 8}) sum[i] += mass.at(row, slot);
        Eigen::Map<Eigen::Array<float, 9, 1>>(matrix.upper_block(there.upper(row, target)).data()) =
            sum.cast<float>();
      }
    }
  });
}

// Loops over the list of pinned particles. They are usually few, so a pass over all particles would
// cost more.
void VelocityMatrix::clear_pinned(std::span<Vec3> velocity) const {
  for (int i : pinned_) velocity[i].setZero();
}

void VelocityMatrix::add_contact_product(std::span<const Vec3> in, std::span<Vec3> out) const {
  if (dynamics_.contact() != nullptr) dynamics_.contact()->add_product(gamma_, in, out);
}

void VelocityMatrix::multiply(std::span<const Vec3> in, std::span<Vec3> out) const {
  if (dynamics_.has_damping()) {
    damped_.multiply(in, out, threads());
  } else {
    const BlockMatrix& stiffness = dynamics_.stiffness();
    const MassOperator& mass = dynamics_.mass();
    const double square = gamma_ * gamma_;
    parallel_chunks(static_cast<int>(in.size()), threads(), [&](int first, int last) {
      for (int i = first; i < last; ++i)
        out[i] = mass.row_product(i, in.data()) + square * stiffness.row_product(i, in.data());
    });
  }
  add_contact_product(in, out);
  clear_pinned(out);
}

}  // namespace weft::sim
