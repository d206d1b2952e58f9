// The unknowns of the free particles, and sparse matrices on them.
#pragma once

#include <Eigen/SparseCore>
#include <span>
#include <vector>

#include "sim/motion/dynamics.h"

namespace weft::sim {

// The three coordinates of each free particle of a scene, numbered consecutively in the order of
// particles. Matrices hold the lower halves of symmetric matrices.
class FreeUnknowns {
 public:
  using Matrix = Eigen::SparseMatrix<double>;
  using Vector = Eigen::VectorXd;

  explicit FreeUnknowns(const Scene& scene);

  Eigen::Index count() const { return static_cast<Eigen::Index>(3 * particles_.size()); }
  int particle_count() const { return static_cast<int>(number_.size()); }  // of dynamic particles
  // Returns the particle to which an unknown belongs.
  int particle(Eigen::Index unknown) const { return particles_[unknown / 3]; }

  // Returns the entries of the free particles, from one vector per dynamic particle.
  Vector gather(std::span<const Vec3> of_particles) const;
  // Writes the values of the unknowns to one vector per dynamic particle, which is zero for held
  // ones.
  void scatter(const Vector& values, std::span<Vec3> of_particles) const;

  // Returns the stiffness K last assembled by the dynamics, plus K + D / gamma (gamma in s) of the
  // contacts last evaluated.
  Matrix stiffness(Dynamics& dynamics, double gamma) const;
  // Returns the mass matrix (kg) of the unknowns, from that of the particles
  // (sim/motion/mass_matrix.h).
  Matrix mass(const Matrix& of_particles) const;

 private:
  using Entries = std::vector<Eigen::Triplet<double>>;
  void add_block(int row, int column, const Mat3& block, Entries& entries) const;
  Matrix matrix_of(const Entries& entries) const;

  std::vector<int> particles_, number_;  // free particles; number of each particle, or -1
};

}  // namespace weft::sim
