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
    const int number = static_cast<int>(mass_.size());
    mark_group(*matrix.pattern(), matrix.scene().pinned, static_cast<int>(i), number, group_);
    if (group_[i] == number) mass_.push_back(0);
  }
  for (std::size_t i = 0; i < group_.size(); ++i) {
    if (group_[i] != held) mass_[group_[i]] += matrix.scene().mass[i];
  }
}

bool FreeTranslations::correct(std::span<const Vec3> residual, std::span<Vec3> correction,
                               std::span<Vec3> product) {
  if (mass_.empty()) return false;
  velocity_.assign(mass_.size(), Vec3::Zero());
  work_.assign(mass_.size(), 0);
  curvature_.assign(mass_.size(), 0);
  const auto for_free = [&](const auto& visit) {
    for (std::size_t i = 0; i < group_.size(); ++i) {
      if (group_[i] != held) visit(i, group_[i]);
    }
  };
  for_free([&](std::size_t i, int group) { velocity_[group] += residual[i] / mass_[group]; });
  std::ranges::fill(correction, Vec3::Zero());
  for_free([&](std::size_t i, int group) { correction[i] = velocity_[group]; });
  matrix_.multiply(correction, product);
  for_free([&](std::size_t i, int group) {
    work_[group] += correction[i].dot(residual[i]);
    curvature_[group] += correction[i].dot(product[i]);
  });
  for_free([&](std::size_t i, int group) {
    const double factor = curvature_[group] > 0 ? work_[group] / curvature_[group] : 0;
    correction[i] *= factor;
    product[i] *= factor;
  });
  return true;
}

}  // namespace weft::sim
