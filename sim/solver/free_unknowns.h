// The unknowns of the free particles, and sparse matrices on them.
#pragma once

#include <Eigen/SparseCore>
#include <span>
#include <vector>

#include "sim/motion/dynamics.h"

namespace weft::sim {

// Unknowns: the three coordinates of each free particle of a scene, numbered in the order of
// particles. A Matrix holds the lower half of a symmetric matrix.
class FreeUnknowns {
 public:
  using Matrix = Eigen::SparseMatrix<double>;
  using Vector = Eigen::VectorXd;

  explicit FreeUnknowns(const Scene& scene);

  Eigen::Index count() const { return static_cast<Eigen::Index>(3 * particles_.size()); }
  // Returns the number of dynamic particles.
  int particle_count() const { return static_cast<int>(number_.size()); }
  // Returns the particle to which an unknown belongs.
  int particle(Eigen::Index unknown) const { return particles_[unknown / 3]; }

  // Returns the entries of the free particles, from one vector per dynamic particle.
  Vector gather(std::span<const Vec3> of_particles) const;
  // Writes the values of the unknowns to one vector per dynamic particle. Held particles get zero.
  void scatter(const Vector& values, std::span<Vec3> of_particles) const;

  // Returns the stiffness K last assembled by the dynamics, plus K + D / gamma (gamma in s) of the
  // contacts last evaluated.
  Matrix stiffness(Dynamics& dynamics, double gamma) const;
  // Returns the mass matrix (kg) of the unknowns, from the mass matrix of the particles
  // (sim/motion/mass_matrix.h).
  Matrix mass(const Matrix& of_particles) const;

 private:
  using Entries = std::vector<Eigen::Triplet<double>>;
  void add_block(int row, int column, const Mat3& block, Entries& entries) const;
  Matrix matrix_of(const Entries& entries) const;

  std::vector<int> particles_, number_;  // free particles; index of each particle among them, or -1
};

}  // namespace weft::sim
