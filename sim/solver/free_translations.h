// Translations of connected particles, by which a solution of the Newton system takes the momentum
// that forces give.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "sim/base/islands.h"
#include "sim/solver/velocity_matrix.h"

namespace weft::sim {

// Forces within a body do not change its momentum, so that translations are the soft directions of
// A = M + gamma D + gamma^2 K. An error of a solution in these directions moves the whole body.
//
// A group consists of the particles that the pattern of A connects. Groups in contact with each
// other exchange momentum, and are moved together. A group with a pinned particle, or in contact
// with an obstacle or a held group, is held, and left alone.
class FreeTranslations {
 public:
  // O(blocks). The matrix must outlive the object.
  explicit FreeTranslations(const VelocityMatrix& matrix);

  // Finds the correction that moves each group as a whole and leaves a residual that sums to zero
  // in it, and its product with A: the error is then the least in the norm of A. Both are zero for
  // held groups. All spans have one entry per particle; `residual` is zero
  // for pinned particles. Returns false if all groups are held. Cost: three products with A.
  bool correct(std::span<const Vec3> residual, std::span<Vec3> correction, std::span<Vec3> product);

 private:
  int find_groups();

  const VelocityMatrix& matrix_;
  int held_;        // number of particles, and the element of `bodies_` that stands for pins
  Islands bodies_;  // of particles, by the pattern of A
  std::vector<int> group_;                     // of each particle; -1: held
  std::array<std::vector<Vec3>, 3> products_;  // of A with translations along the axes
};

}  // namespace weft::sim
