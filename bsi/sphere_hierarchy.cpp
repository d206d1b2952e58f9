#include "bsi/sphere_hierarchy.h"

#include <algorithm>
#include <cassert>

namespace weft::bsi {

namespace {

// Bits of each coordinate in a Morton code.
constexpr int code_bits = 21;

// Spreads the lowest 21 bits of a number such that two zeros precede each bit.
std::uint64_t spread(std::uint64_t bits) {
  bits &= 0x1fffff;
  bits = (bits | bits << 32) & 0x1f00000000ffff;
  bits = (bits | bits << 16) & 0x1f0000ff0000ff;
  bits = (bits | bits << 8) & 0x100f00f00f00f00f;
  bits = (bits | bits << 4) & 0x10c30c30c30c30c3;
  bits = (bits | bits << 2) & 0x1249249249249249;
  return bits;
}

struct CodedSphere {
  std::uint64_t code;
  int index;
  auto operator<=>(const CodedSphere&) const = default;  // NOLINT(modernize-use-nullptr)
};

}  // namespace

void SphereHierarchy::rebuild(std::span<const Vec3> centres, std::span<const double> radii) {
  assert(centres.size() == radii.size());
  sort(centres, radii);
  bound();
}

void SphereHierarchy::sort(std::span<const Vec3> centres, std::span<const double> radii) {
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
  if (!centres.empty()) low = high = centres[0];
  for (const Vec3& centre : centres) {
    low = low.cwiseMin(centre);
    high = high.cwiseMax(centre);
  }
  const double size = (high - low).maxCoeff();
  const double scale = size > 0 ? ((1 << code_bits) - 1) / size : 0;
  std::vector<CodedSphere> order;
  order.reserve(centres.size());
  for (std::size_t i = 0; i < centres.size(); ++i) {
    const Vec3 cell = scale * (centres[i] - low);
    std::uint64_t code = 0;
    for (int k = 0; k < 3; ++k) code |= spread(static_cast<std::uint64_t>(cell[k])) << k;
    order.push_back({code, static_cast<int>(i)});
  }
  std::ranges::sort(order);
  spheres_.clear();
  for (const CodedSphere& each : order)
    spheres_.push_back({centres[each.index], radii[each.index], each.index});
}

void SphereHierarchy::bound() {
  levels_.clear();
  std::vector<Block>& leaves = levels_.emplace_back();
  for (std::size_t first = 0; first < spheres_.size(); first += leaf_size) {
    Block block{spheres_[first].centre, spheres_[first].centre};
    const std::size_t end = std::min(spheres_.size(), first + leaf_size);
    for (std::size_t i = first; i < end; ++i) {
      const Vec3 extent = Vec3::Constant(spheres_[i].radius);
      block.low = block.low.cwiseMin(spheres_[i].centre - extent);
      block.high = block.high.cwiseMax(spheres_[i].centre + extent);
    }
    leaves.push_back(block);
  }
  while (levels_.back().size() > 1) {
    const std::vector<Block>& below = levels_.back();
    std::vector<Block> level;
    for (std::size_t first = 0; first < below.size(); first += children) {
      Block block = below[first];
      const std::size_t end = std::min(below.size(), first + children);
      for (std::size_t i = first + 1; i < end; ++i) {
        block.low = block.low.cwiseMin(below[i].low);
        block.high = block.high.cwiseMax(below[i].high);
      }
      level.push_back(block);
    }
    levels_.push_back(std::move(level));
  }
}

// A traversal of the hierarchy against itself.
class SphereHierarchy::Traversal {
 public:
  Traversal(const SphereHierarchy& hierarchy, double margin)
      : hierarchy_(hierarchy), margin_(margin) {}

  // Visits the pairs of spheres in two blocks of one level, first <= second.
  void visit(std::size_t level, std::size_t first, std::size_t second) {
    ++tests_;
    const std::vector<Block>& blocks = hierarchy_.levels_[level];
    if (first != second && !are_near(blocks[first], blocks[second])) return;
    if (level == 0) return compare(first, second);
    const std::size_t below = hierarchy_.levels_[level - 1].size();
    const auto end = [&](std::size_t block) { return std::min(below, children * (block + 1)); };
    for (std::size_t i = children * first; i < end(first); ++i) {
      const std::size_t start = first == second ? i : children * second;
      for (std::size_t j = start; j < end(second); ++j) visit(level - 1, i, j);
    }
  }
  std::vector<LeafPair> pairs() {
    std::ranges::sort(pairs_);
    return std::move(pairs_);
  }
  std::int64_t tests() const { return tests_; }

 private:
  bool are_near(const Block& a, const Block& b) const {
    return ((a.low - b.high).array() <= margin_).all() &&
           ((b.low - a.high).array() <= margin_).all();
  }
  void compare(std::size_t first, std::size_t second) {
    const std::vector<Placed>& spheres = hierarchy_.spheres_;
    const auto end = [&](std::size_t block) {
      return std::min(spheres.size(), leaf_size * (block + 1));
    };
    for (std::size_t i = leaf_size * first; i < end(first); ++i) {
      const std::size_t start = first == second ? i + 1 : leaf_size * second;
      for (std::size_t j = start; j < end(second); ++j) {
        ++tests_;
        const double reach = spheres[i].radius + spheres[j].radius + margin_;
        if ((spheres[i].centre - spheres[j].centre).squaredNorm() > reach * reach) continue;
        pairs_.push_back({std::min(spheres[i].index, spheres[j].index),
                          std::max(spheres[i].index, spheres[j].index)});
      }
    }
  }

  const SphereHierarchy& hierarchy_;
  double margin_;
  std::vector<LeafPair> pairs_;
  std::int64_t tests_ = 0;
};

std::vector<LeafPair> SphereHierarchy::near_pairs(double margin, std::int64_t& tests) const {
  if (spheres_.empty()) return {};
  Traversal traversal(*this, margin);
  traversal.visit(levels_.size() - 1, 0, 0);
  tests += traversal.tests();
  return traversal.pairs();
}

}  // namespace weft::bsi
