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
  auto operator<=>(const QuadPair&) const = default;
};

struct TraversalCounters {
  std::int64_t sphere_tests = 0;
};

// Every function appends, in an order that depends on the pyramids alone, each pair of quads whose
// spheres come within `margin` (metres, >= 0) of each other exactly once: a superset of the pairs
// whose points do.

// Quads whose spheres come within `margin` of the ball.
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
