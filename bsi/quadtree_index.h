// The flat numbers of a quadtree, as the BSI numbers its texels: the root is 0, and the children of
// n are 4 n + i, 1 <= i <= 4.
#pragma once

#include <bit>
#include <cassert>
#include <cstdint>

namespace weft::bsi {

// Node (u, v) of the 2^level x 2^level nodes of a level, 0 <= level <= 31.
struct QuadtreePlace {
  int level = 0;
  std::uint32_t u = 0, v = 0;
  bool operator==(const QuadtreePlace&) const = default;
};

// Children 1 to 4 are (2u, 2v), (2u + 1, 2v), (2u, 2v + 1), (2u + 1, 2v + 1).
constexpr std::uint64_t flat_child(std::uint64_t node, int i) {
  assert(1 <= i && i <= 4);
  return 4 * node + static_cast<std::uint64_t>(i);
}

// Of any node but the root.
constexpr std::uint64_t flat_parent(std::uint64_t node) {
  assert(node > 0);
  return (node - 1) / 4;
}

// Number of the first node of a level: (4^level - 1) / 3. Nodes of a level follow each other in
// Morton order.
constexpr std::uint64_t first_flat_index(int level) {
  return ((std::uint64_t{1} << (2 * level)) - 1) / 3;
}

// O(level).
constexpr std::uint64_t flat_index(const QuadtreePlace& place) {
  std::uint64_t morton = 0;
  for (int bit = place.level - 1; bit >= 0; --bit) {
    morton = 4 * morton + 2 * (place.v >> bit & 1U) + (place.u >> bit & 1U);
  }
  return first_flat_index(place.level) + morton;
}

constexpr QuadtreePlace quadtree_place(std::uint64_t index) {
  // 3 n + 1 lies in [4^level, 4^(level + 1)).
  QuadtreePlace place{static_cast<int>(std::bit_width(3 * index + 1) - 1) / 2, 0, 0};
  const std::uint64_t morton = index - first_flat_index(place.level);
  for (int bit = 0; bit < place.level; ++bit) {
    place.u |= static_cast<std::uint32_t>(morton >> (2 * bit) & 1U) << bit;
    place.v |= static_cast<std::uint32_t>(morton >> (2 * bit + 1) & 1U) << bit;
  }
  return place;
}

}  // namespace weft::bsi
