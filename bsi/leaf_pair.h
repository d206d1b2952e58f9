// Pairs of leaves: what traversals find and the narrow phase looks at.
#pragma once

#include <compare>

namespace weft::bsi {

// Two quads or two triangles, by number.
struct LeafPair {
  int a = 0;
  int b = 0;
  bool operator==(const LeafPair&) const = default;
  // clang-tidy 14 takes the compiler's own comparison with 0 for one with a null pointer.
  auto operator<=>(const LeafPair&) const = default;  // NOLINT(modernize-use-nullptr)
};

}  // namespace weft::bsi
