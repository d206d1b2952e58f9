// Vectors of floats as wide as the registers of the instruction set. For kernel files only, like
// box_lanes.h.
#pragma once

#include <cstdint>

#include "bsi/kernels/box_lanes.h"

namespace weft::bsi::WEFT_KERNELS {

#if defined(__AVX512F__)
constexpr int width = 16;
#elif defined(__AVX2__)
constexpr int width = 8;
#else
constexpr int width = 4;
#endif

typedef float Wide __attribute__((vector_size(4 * width)));
typedef float UnalignedWide __attribute__((vector_size(4 * width), aligned(4), may_alias));
typedef std::int32_t WideBits __attribute__((vector_size(4 * width)));
typedef double UnalignedWideDouble __attribute__((vector_size(8 * width), aligned(8), may_alias));

WEFT_INLINE Wide load_wide(const float* from) {
  return *reinterpret_cast<const UnalignedWide*>(from);
}
WEFT_INLINE void store_wide(float* to, Wide lanes) {
  *reinterpret_cast<UnalignedWide*>(to) = lanes;
}
WEFT_INLINE Wide load_rounded(const double* from) {
  return __builtin_convertvector(*reinterpret_cast<const UnalignedWideDouble*>(from), Wide);
}

#if defined(__AVX2__)  // otherwise Wide is Quad, and box_lanes.h has both functions
WEFT_INLINE Wide smaller(Wide a, Wide b) { return a < b ? a : b; }
WEFT_INLINE Wide larger(Wide a, Wide b) { return a > b ? a : b; }
#endif
WEFT_INLINE WideBits magnitude_bits(Wide a) { return reinterpret_cast<WideBits>(a) & 0x7fffffff; }
WEFT_INLINE Wide magnitude(Wide a) { return reinterpret_cast<Wide>(magnitude_bits(a)); }
WEFT_INLINE Wide square_root(Wide a) {
  Wide root;
  for (int i = 0; i < width; ++i) root[i] = __builtin_sqrtf(a[i]);
  return root;
}
WEFT_INLINE Wide square(Wide x, Wide y, Wide z) { return x * x + y * y + z * z; }

// shuffle<Order>(a, b) puts element Order::of(i) of the sequence a, b into lane i.
template <int... i>
struct Indices {};
template <int count, int... i>
struct IndicesUpTo : IndicesUpTo<count - 1, count - 1, i...> {};
template <int... i>
struct IndicesUpTo<0, i...> {
  using Type = Indices<i...>;
};
template <class Order, int... i>
WEFT_INLINE Wide shuffle(Wide a, Wide b, Indices<i...>) {
  return __builtin_shufflevector(a, b, Order::of(i)...);
}
template <class Order>
WEFT_INLINE Wide shuffle(Wide a, Wide b) {
  return shuffle<Order>(a, b, typename IndicesUpTo<width>::Type{});
}

template <int parity>
struct EverySecond {
  static constexpr int of(int i) { return 2 * i + parity; }
};
// even() and odd() return the even and the odd lanes of the sequence a, b.
WEFT_INLINE Wide even(Wide a, Wide b) { return shuffle<EverySecond<0>>(a, b); }
WEFT_INLINE Wide odd(Wide a, Wide b) { return shuffle<EverySecond<1>>(a, b); }

template <int half>
struct Alternate {
  static constexpr int of(int i) { return i % 2 * width + i / 2 + half * (width / 2); }
};
// alternate_first() and alternate_second() return the two halves of the sequence a0 b0 a1 b1 ...
WEFT_INLINE Wide alternate_first(Wide a, Wide b) { return shuffle<Alternate<0>>(a, b); }
WEFT_INLINE Wide alternate_second(Wide a, Wide b) { return shuffle<Alternate<1>>(a, b); }

template <int component>
struct ThirdOfTwo {
  static constexpr int of(int i) { return 3 * i + component < 2 * width ? 3 * i + component : 0; }
};
template <int component>
struct ThirdOfThree {
  static constexpr int of(int i) {
    return 3 * i + component < 2 * width ? i : 3 * i + component - width;
  }
};
// Returns every third element of the sequence a, b, c, starting with element `component`.
template <int component>
WEFT_INLINE Wide every_third(Wide a, Wide b, Wide c) {
  return shuffle<ThirdOfThree<component>>(shuffle<ThirdOfTwo<component>>(a, b), c);
}

// Stores the sequence a0 b0 c0 d0 a1 b1 ... (4 * width floats).
WEFT_INLINE void store_alternately(float* to, Wide a, Wide b, Wide c, Wide d) {
  const Wide first_ac = alternate_first(a, c), second_ac = alternate_second(a, c);
  const Wide first_bd = alternate_first(b, d), second_bd = alternate_second(b, d);
  store_wide(to, alternate_first(first_ac, first_bd));
  store_wide(to + width, alternate_second(first_ac, first_bd));
  store_wide(to + 2 * width, alternate_first(second_ac, second_bd));
  store_wide(to + 3 * width, alternate_second(second_ac, second_bd));
}

}  // namespace weft::bsi::WEFT_KERNELS
