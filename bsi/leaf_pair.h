// Leaves of pyramids, and pairs of leaves: traversals find them, the narrow phase examines them.
#pragma once

#include <compare>
#include <cstdint>

#include "bsi/detail/box_layout.h"

namespace weft::bsi {

// The shape that a leaf bounds.
enum class Leaf {
  quad,
  triangle,  // triangles 2 q and 2 q + 1 belong to quad q, as in Mesh
};

// The bounds that traversals compare above the leaves. Leaves are always compared by their boxes,
// so all three give the same result.
enum class Bound {
  sphere,  // as in Davis' bounding sphere image
  box,
  sphere_then_box,  // spheres first, then the boxes of blocks whose spheres meet
};

// Two triangles, or two quads: `a` of the first body, `b` of the second. Within one body a <= b.
struct LeafPair {
  int a = 0;
  int b = 0;
  bool operator==(const LeafPair&) const = default;
  // clang-tidy 14 mistakes the generated comparison with 0 for one with a null pointer.
  auto operator<=>(const LeafPair&) const = default;  // NOLINT(modernize-use-nullptr)
};

// The pairs of leaves of two leaf blocks, each of up to 2 x 2 quads. Bit 8 i + j of `leaves` stands
// for leaf i of `a` and leaf j of `b`. Leaf 2 r + c is the first triangle of the quad in row r and
// column c of the block, or the whole quad. Leaf 4 + 2 r + c is its second triangle. Where bodies
// touch, a list of block pairs is about ten times shorter than the list of their leaf pairs.
struct LeafBlockPair {
  BoxNode a, b;
  std::uint64_t leaves;
};

}  // namespace weft::bsi
