// Which quads come near what: single, dual and self traversal of pyramids.
#pragma once

#include <cstdint>
#include <vector>

#include "bsi/pyramid.h"

namespace weft::bsi {

struct QuadPair {
  int a = 0;  // a quad of the first body (for a self traversal: a <= b)
  int b = 0;  // a quad of the second
  bool operator==(const QuadPair&) const = default;
  // clang-tidy 14 takes the compiler's own comparison with 0 for one with a null pointer.
  auto operator<=>(const QuadPair&) const = default;  // NOLINT(modernize-use-nullptr)
};

struct TraversalCounters {
  std::int64_t sphere_tests = 0;
};

// True if the spheres come within `margin` of each other, in float32 with a bound of the rounding
// added: never false where exact arithmetic would say true, and true beyond by at most 2^-19 of
// the distance. Neither sphere may be empty.
inline bool spheres_within(const Sphere& first, const Sphere& second, float margin) {
  const float x = first.x - second.x;
  const float y = first.y - second.y;
  const float z = first.z - second.z;
  const float reach = first.radius + second.radius + margin;
  // Both sides together are off by at most 11 units of 2^-24; neither underflows (radius_floor).
  constexpr float rounding = 1 + 0x1p-20F;
  return x * x + y * y + z * z <= reach * reach * rounding;
}

// Every function appends, in an order that depends on the pyramids alone, pairs of quads: all of
// those whose points come within `margin` (metres, >= 0) of each other, only such whose spheres do,
// and none twice. (Some whose spheres come that near are left out, where the spheres of larger
// blocks prove that the points do not.)
//
// The set is settled by one rule, so that every implementation finds the same: a pair of blocks
// within the margin is followed by splitting the one with the larger radius, the first body's when
// they are equal, a block of one quad never; a block paired with itself by pairing its children,
// each with itself and with those after it.
//
// The pyramids must be built (Pyramid::is_built). Thread-safe; memory in use is proportional to the
// depth of the pyramids, not recursive.

// Quads whose spheres come within `margin` of the ball. The centre must be finite and below
// Pyramid::coordinate_limit.
void single_traversal(const Pyramid& pyramid, const Vec3& centre, double radius, double margin,
                      std::vector<int>& quads, TraversalCounters& counters);
// Pairs (a of the first, b of the second).
void dual_traversal(const Pyramid& first, const Pyramid& second, double margin,
                    std::vector<QuadPair>& pairs, TraversalCounters& counters);
// Unordered pairs of one body, a <= b, neighbours and the quad with itself included: a quad can
// fold.
void self_traversal(const Pyramid& pyramid, double margin, std::vector<QuadPair>& pairs,
                    TraversalCounters& counters);

}  // namespace weft::bsi
