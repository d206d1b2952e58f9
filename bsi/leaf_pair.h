// Leaves of the hierarchies, and pairs of them: what the traversals find and the narrow phase
// takes.
#pragma once

#include <compare>
#include <cstdint>

#include "bsi/box_layout.h"

namespace weft::bsi {

// What a leaf bounds.
enum class Leaf {
  quad,
  triangle,  // 2 q and 2 q + 1 are those of quad q, as in Mesh
};

// What traversals compare above the leaves, whose boxes settle what is found.
enum class Bound {
  sphere,  // as the paper does
  box,
  sphere_then_box,  // the boxes of blocks whose spheres meet
};

// Numbers of two triangles (or quads) of the first and the second body; of one body: a <= b.
struct LeafPair {
  int a = 0;
  int b = 0;
  bool operator==(const LeafPair&) const = default;
  // clang-tidy 14 takes the compiler's own comparison with 0 for one with a null pointer.
  auto operator<=>(const LeafPair&) const = default;  // NOLINT(modernize-use-nullptr)
};

// Pairs of leaves of two leaf blocks, which hold up to 2 x 2 quads: bit 8 i + j of `leaves` for
// leaf i of the one and leaf j of the other. Leaf 2 r + c is the first triangle (or the whole) of
// the quad in row r and column c of the block, leaf 4 + 2 r + c its second triangle. Some ten times
// as short as a list of pairs, where bodies touch.
struct LeafBlockPair {
  BoxNode a, b;
  std::uint64_t leaves;
};

}  // namespace weft::bsi
