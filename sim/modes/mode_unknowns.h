// The unknowns of modes: what pins and sliding supports leave free.
#pragma once

#include <Eigen/SparseCore>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/solver/free_unknowns.h"

namespace weft::sim {

// Unknowns of an eigenvalue problem. Without sliding supports, they are the coordinates of the free
// particles. Sliding supports, which are stiff springs in motion, hold exactly here: displacements
// are u = T z, where the columns of T span the displacements that lengthen no such spring, and T is
// orthonormal. Rounding errors of stiff springs would exceed the stiffness of thin shells. Matrices
// hold the lower half of a symmetric matrix.
class ModeUnknowns {
 public:
  using Matrix = Eigen::SparseMatrix<double>;
  using Vector = Eigen::VectorXd;

  explicit ModeUnknowns(const Scene& scene);

  Eigen::Index count() const { return basis_ ? basis_->cols() : free_.count(); }
  // Returns the number of dynamic particles.
  int particle_count() const { return free_.particle_count(); }
  // Returns a particle that the unknown moves, the one that it moves farthest.
  int particle(Eigen::Index unknown) const;

  // Returns T^T f, from one vector f per dynamic particle. For displacements that the supports
  // allow, these are the unknowns.
  Vector gather(std::span<const Vec3> of_particles) const;
  // Writes T z to one vector per dynamic particle. Held particles get zero.
  void scatter(const Vector& values, std::span<Vec3> of_particles) const;

  // Evaluates the forces of a state, and returns T^T K T with the exact tangent stiffness K.
  // Contacts are springs along their normals, without damping and friction. Returns nothing, and
  // sets `fault` to the reason, if the forces cannot be evaluated.
  std::optional<Matrix> stiffness(Dynamics& dynamics, double time, std::span<const double> state,
                                  std::string& fault) const;
  // Returns T^T M T (kg), from the mass matrix M of the particles (sim/motion/mass_matrix.h).
  Matrix mass(const Matrix& of_particles) const;

 private:
  Matrix restricted(const Matrix& of_free) const;

  FreeUnknowns free_;
  std::optional<Matrix> basis_;  // T; empty without supports
};

}  // namespace weft::sim
