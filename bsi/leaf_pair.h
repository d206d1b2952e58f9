// Leaves of the hierarchies and pairs of them, which traversals find and the narrow phase reads.
#pragma once

#include <compare>
#include <cstdint>

#include "bsi/detail/box_layout.h"

namespace weft::bsi {

// The shape that a leaf bounds.
enum class Leaf {
  quad,
  triangle,  // 2 q and 2 q + 1 belong to quad q, as in Mesh
};

// The bounds that traversals compare above the leaves. The boxes of the leaves decide the result.
enum class Bound {
  sphere,  // as the paper does
  box,
  sphere_then_box,  // spheres first, then the boxes of blocks whose spheres meet
};

// Two triangles (or quads): `a` of the first body, `b` of the second; a <= b within one body.
struct LeafPair {
  int a = 0;
  int b = 0;
  bool operator==(const LeafPair&) const = default;
  // clang-tidy 14 takes the compiler's own comparison with 0 for one with a null pointer.
  auto operator<=>(const LeafPair&) const = default;  // NOLINT(modernize-use-nullptr)
};

// Pairs of leaves of two leaf blocks, which hold up to 2 x 2 quads. Bit 8 i + j of `leaves` stands
// for leaf i of `a` and leaf j of `b`. Leaf 2 r + c is the first triangle (or the whole) of the
// quad in row r and column c of the block; leaf 4 + 2 r + c is its second triangle. Where bodies
// touch, a list of these is about ten times shorter than a list of pairs.
struct LeafBlockPair {
  BoxNode a, b;
  std::uint64_t leaves;
};

}  // namespace weft::bsi
