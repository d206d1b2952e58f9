#include "sim/solver/free_translations.h"

#include <algorithm>
#include <cmath>

#include "sim/contact/contact.h"

namespace weft::sim {

FreeTranslations::FreeTranslations(const VelocityMatrix& matrix)
    : matrix_(matrix), held_(matrix.dynamics().particle_count()), group_(held_) {
  bodies_.clear(held_ + 1);
  const BlockPattern& pattern = *matrix.pattern();
  for (int row = 0; row < held_; ++row) {
    if (matrix.scene().pinned[row] != 0) bodies_.connect(row, held_);
    for (int slot = pattern.row_begin(row); slot < pattern.row_end(row); ++slot)
      bodies_.connect(row, pattern.column(slot));
  }
}

// Numbers the groups of the present contacts, and returns how many there are.
int FreeTranslations::find_groups() {
  Islands islands = bodies_;
  const auto join = [&](const Contact::Coupling& coupling) {
    // Weights that do not sum to zero are those of a spin, which resists the friction of the pair.
    double sum = 0;
    for (const double weight : coupling.weights) sum += weight;
    const int other = std::abs(sum) > 1e-9 ? held_ : coupling.particles.front();
    // Particles of obstacles have the numbers from `held_` on.
    for (const int particle : coupling.particles)
      islands.connect(std::min(particle, held_), std::min(other, held_));
  };
  if (matrix_.has_contact()) matrix_.dynamics().contact()->visit_definite_couplings(0, join);
  const int held = islands.island_of(held_);
  int count = 0;
  for (int i = 0; i < held_; ++i) {
    const int first = islands.island_of(i);
    group_[i] = first == held ? -1 : first == i ? count++ : group_[first];
  }
  return count;
}

bool FreeTranslations::correct(std::span<const Vec3> residual, std::span<Vec3> correction,
                               std::span<Vec3> product) {
  const int count = find_groups();
  if (count == 0) return false;
  const auto for_free = [&](const auto& visit) {
    for (int i = 0; i < held_; ++i) {
      if (group_[i] >= 0) visit(i, group_[i]);
    }
  };
  std::vector<Mat3> inertia(count, Mat3::Zero());
  std::ranges::fill(correction, Vec3::Zero());
  for (int axis = 0; axis < 3; ++axis) {
    for_free([&](int i, int /*group*/) { correction[i] = Vec3::Unit(axis); });
    products_[axis].resize(product.size());
    matrix_.multiply(correction, products_[axis]);
    for_free([&](int i, int group) { inertia[group].col(axis) += products_[axis][i]; });
  }
  std::vector<Vec3> velocity(count, Vec3::Zero());
  for_free([&](int i, int group) { velocity[group] += residual[i]; });
  for (int group = 0; group < count; ++group)
    velocity[group] = inertia[group].ldlt().solve(velocity[group]);
  for_free([&](int i, int group) { correction[i] = velocity[group]; });
  std::ranges::fill(product, Vec3::Zero());
  for_free([&](int i, int group) {
    for (int axis = 0; axis < 3; ++axis) product[i] += velocity[group][axis] * products_[axis][i];
  });
  return true;
}

}  // namespace weft::sim
