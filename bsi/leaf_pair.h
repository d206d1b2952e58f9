// Leaves of the hierarchies, and pairs of them: what the traversals find and the narrow phase
// takes.
#pragma once

#include <compare>

namespace weft::bsi {

// What a leaf bounds.
enum class Leaf {
  quad,
  triangle,  // 2 q and 2 q + 1 are those of quad q, as in Mesh
};

// Numbers of two triangles (or quads) of the first and the second body; of one body: a <= b.
struct LeafPair {
  int a = 0;
  int b = 0;
  bool operator==(const LeafPair&) const = default;
  // clang-tidy 14 takes the compiler's own comparison with 0 for one with a null pointer.
  auto operator<=>(const LeafPair&) const = default;  // NOLINT(modernize-use-nullptr)
};

}  // namespace weft::bsi
