#include "sim/solver/velocity_matrix.h"

#include <algorithm>

#include "sim/base/parallel.h"
#include "sim/case/time_methods.h"

namespace weft::sim {

namespace {

// Largest ratio of a particle's stiffness and damping in A to its mass at which A is kept in single
// precision. Rounding then changes A by at most 4e-3 of the mass, and hardly more than 1e-4 in
// practice, which is little beside the tolerance of a linear solve.
constexpr double most_over_mass = 1e4;

// True if each Newton iteration goes on until its residual, which does not depend on A, is small.
bool corrects_errors_of_matrix(const TimeCase& time) {
  return time.newton == 0 && !traits_of(time.method).finds_equilibria();
}

}  // namespace

VelocityMatrix::VelocityMatrix(const Dynamics& dynamics)
    : dynamics_(dynamics),
      may_be_single_(dynamics.mass().is_diagonal() &&
                     corrects_errors_of_matrix(dynamics.scene().source.time)) {
  for (int i = 0; i < dynamics.particle_count(); ++i) {
    if (dynamics.scene().pinned[i] != 0) pinned_.push_back(i);
  }
}

void VelocityMatrix::form(double gamma) {
  gamma_ = gamma;
  ++version_;
  if (!dynamics_.has_damping()) return;
  is_single_ = may_be_single_ && is_far_above_rounding(gamma);
  if (is_single_) {
    form_in(damped_single_, gamma);
  } else {
    form_in(damped_, gamma);
  }
}

template <class Matrix>
void VelocityMatrix::form_in(Matrix& matrix, double gamma) {
  if (matrix.is_empty()) matrix = Matrix(pattern());
  matrix.set_to_sum(gamma * gamma, dynamics_.stiffness(), gamma, dynamics_.damping(), threads());
  parallel_chunks(pattern()->rows(), threads(), [&](int first, int last) {
    for (int row = first; row < last; ++row) add_mass(row, matrix);
  });
}

// True if rounding to single precision changes A by little beside the mass.
bool VelocityMatrix::is_far_above_rounding(double gamma) const {
  const auto is_far = [&](int first, int last, char& all) {
    all = 1;
    for (int row = first; row < last; ++row) {
      const double over_mass =
          gamma * gamma * dynamics_.stiffness().diagonal_block(row).diagonal().maxCoeff() +
          gamma * dynamics_.damping().diagonal_block(row).diagonal().maxCoeff();
      if (!(over_mass <= most_over_mass * scene().mass[row])) all = 0;
    }
  };
  const auto parts = parallel_parts<char>(pattern()->rows(), threads(), is_far);
  return std::ranges::find(parts, 0) == parts.end();
}

template <class Matrix>
void VelocityMatrix::add_mass(int row, Matrix& matrix) const {
  using Number = typename Matrix::Block::Scalar;
  const MassOperator& mass = dynamics_.mass();
  const int diagonal = pattern()->diagonal_slot(row);
  const int end = mass.is_diagonal() ? diagonal + 1 : pattern()->row_end(row);
  for (int slot = diagonal; slot < end; ++slot)
    matrix.upper_block(pattern()->upper(row, slot)).diagonal().array() +=
        static_cast<Number>(mass.at(row, slot));
}

Mat3 VelocityMatrix::block(int row, int slot) const {
  if (is_single_) return damped_single_.block(row, slot).cast<double>();
  if (dynamics_.has_damping()) return damped_.block(row, slot);
  Mat3 result = gamma_ * gamma_ * dynamics_.stiffness().block(row, slot);
  result.diagonal().array() += dynamics_.mass().at(row, slot);
  return result;
}

void VelocityMatrix::copy_to(SingleBlockMatrix& matrix) const {
  if (is_single_) {
    copy_between(damped_single_, matrix);
  } else {
    copy_between(dynamics_.has_damping() ? damped_ : dynamics_.stiffness(), matrix);
  }
}

// Copies A, or makes it from K without damping.
template <class Matrix>
void VelocityMatrix::copy_between(const Matrix& from, SingleBlockMatrix& to) const {
  const BlockPattern& here = *pattern();
  const BlockPattern& there = to.pattern();
  const bool is_damped = dynamics_.has_damping();
  const double factor = is_damped ? 1 : gamma_ * gamma_;
  const MassOperator& mass = dynamics_.mass();
  const bool is_lumped = mass.is_diagonal();
  if (there.block_count() != here.block_count()) to.set_zero(threads());
  parallel_chunks(here.rows(), threads(), [&](int first, int last) {
    for (int row = first; row < last; ++row) {
      const int diagonal = here.diagonal_slot(row);
      int target = there.diagonal_slot(row), upper = here.upper(row, diagonal);
      for (int slot = diagonal; slot < here.row_end(row); ++slot, ++target, ++upper) {
        while (there.column(target) != here.column(slot)) ++target;
        Mat3 sum = factor * from.upper_block(upper).template cast<double>();
        if (!is_damped && (slot == diagonal || !is_lumped))
          sum.diagonal().array() += mass.at(row, slot);
        to.upper_block(there.upper(row, target)) = sum.cast<float>();
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
  if (is_single_) {
    damped_single_.multiply(in, out, threads());
  } else if (dynamics_.has_damping()) {
    damped_.multiply(in, out, threads());
  } else {
    dynamics_.stiffness().multiply(in, out, threads());
    const MassOperator& mass = dynamics_.mass();
    const double square = gamma_ * gamma_;
    parallel_chunks(static_cast<int>(in.size()), threads(), [&](int first, int last) {
      for (int i = first; i < last; ++i) out[i] = mass.row_product(i, in.data()) + square * out[i];
    });
  }
  add_contact_product(in, out);
  clear_pinned(out);
}

}  // namespace weft::sim
