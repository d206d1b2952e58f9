#include "sim/solver/free_translations.h"

#include <algorithm>

namespace weft::sim {

namespace {

constexpr int unknown = -2, held = -1;

// Numbers the particles that are connected with `first`, or marks them as held.
void mark_group(const BlockPattern& pattern, std::span<const char> pinned, int first, int number,
                std::vector<int>& group) {
  std::vector<int> members{first};
  group[first] = number;
  bool is_held = false;
  for (std::size_t next = 0; next < members.size(); ++next) {
    const int row = members[next];
    is_held |= pinned[row] != 0;
    for (int slot = pattern.row_begin(row); slot < pattern.row_end(row); ++slot) {
      const int column = pattern.column(slot);
      if (group[column] != unknown) continue;
      group[column] = number;
      members.push_back(column);
    }
  }
  if (!is_held) return;
  for (const int member : members) group[member] = held;
}

}  // namespace

FreeTranslations::FreeTranslations(const VelocityMatrix& matrix)
    : matrix_(matrix), group_(matrix.dynamics().particle_count(), unknown) {
  for (std::size_t i = 0; i < group_.size(); ++i) {
    if (group_[i] != unknown) continue;
    mark_group(*matrix.pattern(), matrix.scene().pinned, static_cast<int>(i), group_count_, group_);
    if (group_[i] == group_count_) ++group_count_;
  }
}

bool FreeTranslations::correct(std::span<const Vec3> residual, std::span<Vec3> correction,
                               std::span<Vec3> product) {
  if (group_count_ == 0) return false;
  const auto for_free = [&](const auto& visit) {
    for (std::size_t i = 0; i < group_.size(); ++i) {
      if (group_[i] != held) visit(i, group_[i]);
    }
  };
  std::vector<Mat3> inertia(group_count_, Mat3::Zero());
  std::ranges::fill(correction, Vec3::Zero());
  for (int axis = 0; axis < 3; ++axis) {
    for_free([&](std::size_t i, int /*group*/) { correction[i] = Vec3::Unit(axis); });
    products_[axis].resize(product.size());
    matrix_.multiply(correction, products_[axis]);
    for_free([&](std::size_t i, int group) { inertia[group].col(axis) += products_[axis][i]; });
  }
  std::vector<Vec3> velocity(group_count_, Vec3::Zero());
  for_free([&](std::size_t i, int group) { velocity[group] += residual[i]; });
  for (int group = 0; group < group_count_; ++group)
    velocity[group] = inertia[group].ldlt().solve(velocity[group]);
  for_free([&](std::size_t i, int group) { correction[i] = velocity[group]; });
  std::ranges::fill(product, Vec3::Zero());
  for_free([&](std::size_t i, int group) {
    for (int axis = 0; axis < 3; ++axis) product[i] += velocity[group][axis] * products_[axis][i];
  });
  return true;
}

}  // namespace weft::sim
