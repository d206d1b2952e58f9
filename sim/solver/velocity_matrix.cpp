#include "sim/solver/velocity_matrix.h"

#include "sim/parallel.h"

namespace weft::sim {

VelocityMatrix::VelocityMatrix(const Dynamics& dynamics)
    : dynamics_(dynamics), blocks_(dynamics.stiffness()) {
  for (int i = 0; i < dynamics.particle_count(); ++i) {
    if (dynamics.scene().pinned[i] != 0) pinned_.push_back(i);
  }
}

void VelocityMatrix::form(double gamma) {
  gamma_ = gamma;
  ++version_;
  const double square = gamma * gamma;
  const double* stiffness = dynamics_.stiffness().values().data();
  const double* damping = dynamics_.damping().values().data();
  double* values = blocks_.values().data();
  const BlockPattern& pattern = blocks_.pattern();
  const bool damped = dynamics_.has_damping();
  parallel_chunks(pattern.rows(), dynamics_.threads(), [&](int first_row, int last_row) {
    const std::size_t first = 9 * static_cast<std::size_t>(pattern.row_begin(first_row));
    const std::size_t last = 9 * static_cast<std::size_t>(pattern.row_end(last_row - 1));
    if (damped) {
      for (std::size_t i = first; i < last; ++i)
        values[i] = square * stiffness[i] + gamma * damping[i];
    } else {
      for (std::size_t i = first; i < last; ++i) values[i] = square * stiffness[i];
    }
    for (int row = first_row; row < last_row; ++row) {
      blocks_.block(pattern.diagonal_slot(row)).diagonal().array() += dynamics_.scene().mass[row];
    }
  });
}

void VelocityMatrix::add_contact_product(std::span<const Vec3> in, std::span<Vec3> out) const {
  if (dynamics_.contact() != nullptr) dynamics_.contact()->add_product(gamma_, in, out);
}

void VelocityMatrix::multiply(std::span<const Vec3> in, std::span<Vec3> out) const {
  blocks_.multiply(in, out, dynamics_.threads());
  add_contact_product(in, out);
  // Few: the list costs less than a pass over all.
  for (int i : pinned_) out[i].setZero();
}

}  // namespace weft::sim
