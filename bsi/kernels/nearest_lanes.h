// Functions that all kernels of distances share. For kernel files only, like lanes.h.
#pragma once

#include "bsi/kernels/lanes.h"

namespace weft::bsi::WEFT_KERNELS {

template <class V>
WEFT_INLINE V smallest(V a, V b, V c) {
  return smaller(smaller(a, b), c);
}
template <class V>
WEFT_INLINE V largest(V a, V b, V c) {
  return larger(larger(a, b), c);
}

// The shortest vector found so far from a point of the second feature to one of the first.
template <class V>
struct Nearest {
  V squared;
  Lanes3<V> vector;

  WEFT_INLINE void offer(V other_squared, const Lanes3<V>& other) {
    const auto nearer = other_squared < squared;
    squared = nearer ? other_squared : squared;
    vector.x = nearer ? other.x : vector.x;
    vector.y = nearer ? other.y : vector.y;
    vector.z = nearer ? other.z : vector.z;
  }
};

// Bounds of rounding (docs/theory.md, "The narrow phase"). `length` is for a separation vector and
// `shadow` for the gap between projections, both relative to the size of the pair. `relative` is a
// factor for products and squares.
template <class Float>
struct Bounds {
  static constexpr Float u = RoundingOf<Float>::unit;
  static constexpr Float length = 24 * u, shadow = 12 * u, relative = 1 + 16 * u;
};

// Returns the size of a pair from its square. It is infinite if products of coordinates might
// overflow; all verdicts then stay undecided.
template <class Float>
WEFT_INLINE Lanes<Float> safe_size(Lanes<Float> squared) {
  return square_root(16 * squared + RoundingOf<Float>::smallest_square) * Float{0.25};
}

// Returns true if the distance certainly exceeds `reach`. `gap` is the gap between the projections
// on a vector, times the length of the vector. `squared` is the square of that length.
template <class Float>
WEFT_INLINE auto is_apart(Lanes<Float> gap, Lanes<Float> squared, Lanes<Float> reach,
                          Lanes<Float> size) {
  const auto length = square_root(squared + RoundingOf<Float>::smallest_square);
  return gap > length * (reach + Bounds<Float>::shadow * size) * Bounds<Float>::relative;
}

}  // namespace weft::bsi::WEFT_KERNELS
