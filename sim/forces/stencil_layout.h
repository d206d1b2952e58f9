// Layouts: how the nodes of a force's stencils lie in an image.
#pragma once

#include <utility>

#include "materials/lanes.h"

namespace weft::sim {

// Marks a node that a stencil lacks. Any node but the first may be absent. A value read at an
// absent node is that of an arbitrary particle, and a value added there must be zero.
inline constexpr int no_node = -1;

// A layout is a class with two functions. couples(a, b) tells whether the derivatives couple nodes
// a and b. follows(node) tells whether a node usually is the particle after that of the preceding
// node, as in a row of an image. AnyStencil fits any stencil.
struct AnyStencil {
  static constexpr bool follows(int) { return false; }
  static constexpr bool couples(int, int) { return true; }
};
// The corners of a quad in the order of bsi::quad_triangles. Corners 0 and 3 are not coupled,
// because no edge of the two triangles joins them.
struct QuadCorners {
  static constexpr bool follows(int node) { return node == 1 || node == 3; }
  static constexpr bool couples(int a, int b) { return a + b != 3 || a * b != 0; }
};

// Number of coupled pairs of different nodes.
template <int Nodes, class Layout>
constexpr int coupled_pair_count() {
  int count = 0;
  for (int a = 0; a < Nodes; ++a) {
    for (int b = a + 1; b < Nodes; ++b) count += Layout::couples(a, b) ? 1 : 0;
  }
  return count;
}

// Calls body(a, b) with integral constants for all coupled pairs of nodes a <= b.
template <int Nodes, class Layout, class Body>
void for_each_coupled_pair(const Body& body) {
  const auto with = [&]<int a, int... b>(std::integral_constant<int, a> row,
                                         std::integer_sequence<int, b...>) {
    const auto one = [&]<int column>(std::integral_constant<int, column> other) {
      if constexpr (a <= column && Layout::couples(a, column)) body(row, other);
    };
    (one(std::integral_constant<int, b>()), ...);
  };
  [&]<int... a>(std::integer_sequence<int, a...> all) {
    (with(std::integral_constant<int, a>(), all), ...);
  }
  (std::make_integer_sequence<int, Nodes>());
}

// One integer per stencil of a batch.
struct LaneIntegers {
  typedef int Vector __attribute__((vector_size(sizeof(int) * materials::lane_count)));
  Vector values;
};

}  // namespace weft::sim
