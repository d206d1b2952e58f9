// Shortest separation vectors and bounds of rounding, for kernels that compute distances. For
// kernel files only, like lanes.h.
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

// The shortest vector found so far from a point of the second feature to a point of the first, and
// its squared length.
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

// Bounds of rounding (docs/theory.md, "The narrow phase"). `length` bounds the error of a
// separation vector, `shadow` that of the gap between projections, both relative to the size of the
// pair. `relative` is a factor that covers the rounding of products and squares.
template <class Float>
struct Bounds {
  static constexpr Float u = RoundingOf<Float>::unit;
  static constexpr Float length = 24 * u, shadow = 12 * u, relative = 1 + 16 * u;
};

// Returns the size of a pair, given the square of the size. The result is infinite if products of
// two coordinates might overflow; the pair then stays undecided.
template <class Float>
WEFT_INLINE Lanes<Float> safe_size(Lanes<Float> squared) {
  return square_root(16 * squared + RoundingOf<Float>::smallest_square) * Float{0.25};
}

// Returns true in lanes where the distance certainly exceeds `reach`. `gap` is the gap between the
// projections on a vector, times the length of the vector. `squared` is the square of that length,
// and `size` is the size of the pair.
template <class Float>
WEFT_INLINE auto is_apart(Lanes<Float> gap, Lanes<Float> squared, Lanes<Float> reach,
                          Lanes<Float> size) {
  const auto length = square_root(squared + RoundingOf<Float>::smallest_square);
  return gap > length * (reach + Bounds<Float>::shadow * size) * Bounds<Float>::relative;
}

// Returns the largest reach for which is_apart() holds, less what rounding may add, or 0 if there
// is none.
template <class Float>
WEFT_INLINE Lanes<Float> distance_above(Lanes<Float> gap, Lanes<Float> squared, Lanes<Float> size) {
  constexpr Float more = 1 + 8 * Bounds<Float>::u;
  const auto length = square_root(squared + RoundingOf<Float>::smallest_square);
  const auto distance =
      gap / (length * (Bounds<Float>::relative * more)) - Bounds<Float>::shadow * size * more;
  return distance > 0 ? distance : Lanes<Float>{};
}

}  // namespace weft::bsi::WEFT_KERNELS
