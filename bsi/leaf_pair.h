// Leaves of pyramids, and the pairs of leaves that traversals find.
#pragma once

#include <compare>
#include <cstdint>

#include "bsi/detail/box_layout.h"

namespace weft::bsi {

// The shape whose box is a leaf of a pyramid.
enum class Leaf {
  quad,
  triangle,  // triangles 2 q and 2 q + 1 belong to quad q, as in Mesh
};

// The bounds of blocks that a traversal compares. Groups, pairs of whole patches and leaves are
// compared by their boxes alone, so the bound does not change the pairs of leaves that are found.
enum class Bound {
  sphere,  // the bounds of Davis' bounding sphere image
  box,
  sphere_then_box,  // spheres, then boxes where the spheres meet
};

// The indices of two leaves, which are triangles or quads: `a` is a leaf of the first body, `b` of
// the second. In the result of a self traversal a <= b. For a single traversal, `a` is the index of
// a point.
struct LeafPair {
  int a = 0;
  int b = 0;
  bool operator==(const LeafPair&) const = default;
  // clang-tidy 14 mistakes the generated comparison with 0 for one with a null pointer.
  auto operator<=>(const LeafPair&) const = default;  // NOLINT(modernize-use-nullptr)
};

// Pairs of leaves of two leaf blocks, each of up to 2 x 2 quads. Bit 8 i + j of `leaves` stands for
// leaf i of block `a` and leaf j of block `b`. Leaf 2 r + c is the first triangle of the quad in
// row r and column c of the block, or the whole quad. Leaf 4 + 2 r + c is the second triangle of
// that quad. A pair of blocks takes 24 bytes and stands for up to 64 pairs of leaves, of 8 bytes
// each.
struct LeafBlockPair {
  BoxNode a, b;
  std::uint64_t leaves;
};

}  // namespace weft::bsi
