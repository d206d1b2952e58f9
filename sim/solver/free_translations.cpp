#include "sim/solver/free_translations.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/contact/contact.h"

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

// Returns for each group the number of those that are in contact with each other, from 0, or `held`
// if one of them touches what is not free. Sets *count to the number of all.
std::vector<int> FreeTranslations::join_by_contact(int* count) const {
  std::vector<int> parent(group_count_);
  std::iota(parent.begin(), parent.end(), 0);
  std::vector<char> is_held(group_count_, 0);
  const auto root = [&](int group) {
    while (parent[group] != group) group = parent[group] = parent[parent[group]];
    return group;
  };
  const auto join = [&](const Contact::Coupling& coupling) {
    // Weights that do not sum to zero are those of a spin, which resists the friction of the pair.
    double sum = 0;
    for (const double weight : coupling.weights) sum += weight;
    bool holds = std::abs(sum) > 1e-9;
    int first = held;
    for (const int particle : coupling.particles) {
      const int group = particle < static_cast<int>(group_.size()) ? group_[particle] : held;
      if (group == held) {
        holds = true;
        continue;
      }
      const int own = root(group);
      if (first == held) first = own;
      is_held[first] |= is_held[own];
      parent[own] = first;
    }
    if (holds && first != held) is_held[first] = 1;
  };
  if (matrix_.has_contact()) matrix_.dynamics().contact()->visit_definite_couplings(0, join);
  std::vector<int> number(group_count_, held);
  *count = 0;
  for (int group = 0; group < group_count_; ++group) {
    if (root(group) == group && is_held[group] == 0) number[group] = (*count)++;
  }
  std::vector<int> joined(group_count_);
  for (int group = 0; group < group_count_; ++group) joined[group] = number[root(group)];
  return joined;
}

bool FreeTranslations::correct(std::span<const Vec3> residual, std::span<Vec3> correction,
                               std::span<Vec3> product) {
  int count = 0;
  const std::vector<int> joined = join_by_contact(&count);
  if (count == 0) return false;
  const auto for_free = [&](const auto& visit) {
    for (std::size_t i = 0; i < group_.size(); ++i) {
      const int group = group_[i] == held ? held : joined[group_[i]];
      if (group != held) visit(i, group);
    }
  };
  std::vector<Mat3> inertia(count, Mat3::Zero());
  std::ranges::fill(correction, Vec3::Zero());
  for (int axis = 0; axis < 3; ++axis) {
    for_free([&](std::size_t i, int /*group*/) { correction[i] = Vec3::Unit(axis); });
    products_[axis].resize(product.size());
    matrix_.multiply(correction, products_[axis]);
    for_free([&](std::size_t i, int group) { inertia[group].col(axis) += products_[axis][i]; });
  }
  std::vector<Vec3> velocity(count, Vec3::Zero());
  for_free([&](std::size_t i, int group) { velocity[group] += residual[i]; });
  for (int group = 0; group < count; ++group)
    velocity[group] = inertia[group].ldlt().solve(velocity[group]);
  for_free([&](std::size_t i, int group) { correction[i] = velocity[group]; });
  std::ranges::fill(product, Vec3::Zero());
  for_free([&](std::size_t i, int group) {
    for (int axis = 0; axis < 3; ++axis) product[i] += velocity[group][axis] * products_[axis][i];
  });
  return true;
}

}  // namespace weft::sim
