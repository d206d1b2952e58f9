#include "sim/solver/free_unknowns.h"

namespace weft::sim {

FreeUnknowns::FreeUnknowns(const Scene& scene) : number_(scene.dynamic_particles, -1) {
  for (int i = 0; i < scene.dynamic_particles; ++i) {
    if (scene.pinned[i] != 0) continue;
    number_[i] = static_cast<int>(particles_.size());
    particles_.push_back(i);
  }
}

FreeUnknowns::Vector FreeUnknowns::gather(std::span<const Vec3> of_particles) const {
  Vector values(count());
  for (std::size_t i = 0; i < particles_.size(); ++i)
    values.segment<3>(static_cast<Eigen::Index>(3 * i)) = of_particles[particles_[i]];
  return values;
}

void FreeUnknowns::scatter(const Vector& values, std::span<Vec3> of_particles) const {
  std::ranges::fill(of_particles, Vec3(Vec3::Zero()));
  for (std::size_t i = 0; i < particles_.size(); ++i)
    of_particles[particles_[i]] = values.segment<3>(static_cast<Eigen::Index>(3 * i));
}

void FreeUnknowns::add_block(int row, int column, const Mat3& block, Entries& entries) const {
  const int first = number_[row], second = number_[column];
  if (first < 0 || second < 0) return;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      if (3 * first + i >= 3 * second + j)
        entries.emplace_back(3 * first + i, 3 * second + j, block(i, j));
    }
  }
}

FreeUnknowns::Matrix FreeUnknowns::matrix_of(const Entries& entries) const {
  Matrix matrix(count(), count());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

FreeUnknowns::Matrix FreeUnknowns::stiffness(Dynamics& dynamics, double gamma) const {
  Entries entries;
  const BlockMatrix& stiffness = dynamics.stiffness();
  const BlockPattern& pattern = stiffness.pattern();
  for (int i = 0; i < pattern.rows(); ++i) {
    for (int slot = pattern.row_begin(i); slot <= pattern.diagonal_slot(i); ++slot)
      add_block(i, pattern.column(slot), stiffness.block(i, slot), entries);
  }
  if (dynamics.contact() != nullptr) {
    const double factor = 1 / (gamma * gamma);  // visit_blocks() gives gamma^2 K + gamma D
    dynamics.contact()->visit_blocks(
        gamma, [&](int i, int j, const Mat3& block) { add_block(i, j, factor * block, entries); });
  }
  return matrix_of(entries);
}

FreeUnknowns::Matrix FreeUnknowns::mass(const Matrix& of_particles) const {
  Entries entries;
  for (Eigen::Index column = 0; column < of_particles.outerSize(); ++column) {
    for (Matrix::InnerIterator each(of_particles, column); each; ++each) {
      const int first = number_[each.row()], second = number_[column];
      if (first < second || second < 0) continue;
      for (int axis = 0; axis < 3; ++axis)
        entries.emplace_back(3 * first + axis, 3 * second + axis, each.value());
    }
  }
  return matrix_of(entries);
}

}  // namespace weft::sim
