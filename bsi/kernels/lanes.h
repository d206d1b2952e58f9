// Vectors of floats or doubles as wide as the registers of the instruction set. For kernel files
// only: all of this is compiled once per instruction set, each time in its own namespace (see
// bsi/detail/instruction_set.h).
//
// Lanes<F> is a GCC vector type: + - * / act on every lane, and `a < b ? c : d` chooses lane by
// lane.
#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#define WEFT_INLINE [[gnu::always_inline]] inline

namespace weft::bsi::WEFT_KERNELS {

#if defined(__AVX512F__)
inline constexpr int vector_bytes = 64;
#elif defined(__AVX__)
inline constexpr int vector_bytes = 32;
#else
inline constexpr int vector_bytes = 16;
#endif

template <class Float>
struct LanesOf {
  typedef Float Type __attribute__((vector_size(vector_bytes)));
};
template <class Float>
using Lanes = typename LanesOf<Float>::Type;
template <class Float>
inline constexpr int lane_count = vector_bytes / static_cast<int>(sizeof(Float));

template <class Float>
struct RoundingOf;
template <>
struct RoundingOf<float> {
  static constexpr float unit = 0x1p-24F;
  static constexpr float smallest_square = 1e-36F;  // above any sum of squares lost by underflow
};
template <>
struct RoundingOf<double> {
  static constexpr double unit = 0x1p-53;
  static constexpr double smallest_square = 1e-300;
};

// smaller() returns `a < b ? a : b` and larger() returns `a > b ? a : b`, lane by lane. If a or b
// is NaN, the result is b. On x86 both use intrinsics, because g++ 12 often misses the instruction
// for such a choice.
#if defined(__SSE2__)
#if defined(__AVX512F__)
#define WEFT_VECTOR(operation) _mm512_##operation
#elif defined(__AVX__)
#define WEFT_VECTOR(operation) _mm256_##operation
#else
#define WEFT_VECTOR(operation) _mm_##operation
#endif
WEFT_INLINE Lanes<float> smaller(Lanes<float> a, Lanes<float> b) {
  return WEFT_VECTOR(min_ps)(a, b);
}
WEFT_INLINE Lanes<double> smaller(Lanes<double> a, Lanes<double> b) {
  return WEFT_VECTOR(min_pd)(a, b);
}
WEFT_INLINE Lanes<float> larger(Lanes<float> a, Lanes<float> b) {
  return WEFT_VECTOR(max_ps)(a, b);
}
WEFT_INLINE Lanes<double> larger(Lanes<double> a, Lanes<double> b) {
  return WEFT_VECTOR(max_pd)(a, b);
}
WEFT_INLINE Lanes<float> square_root(Lanes<float> a) { return WEFT_VECTOR(sqrt_ps)(a); }
WEFT_INLINE Lanes<double> square_root(Lanes<double> a) { return WEFT_VECTOR(sqrt_pd)(a); }
#undef WEFT_VECTOR
#else
template <class V>
WEFT_INLINE V smaller(V a, V b) {
  return a < b ? a : b;
}
template <class V>
WEFT_INLINE V larger(V a, V b) {
  return a > b ? a : b;
}
template <class V>
WEFT_INLINE V square_root(V a) {
  for (unsigned i = 0; i < sizeof(V) / sizeof(a[0]); ++i) a[i] = __builtin_sqrt(a[i]);
  return a;
}
#endif
// Returns every lane clamped to [0, 1]. A NaN becomes 0.
template <class V>
WEFT_INLINE V clamped_to_unit(V a) {
  return smaller(larger(a, V{}), V{} + 1);
}

// Points or vectors in space, one per lane.
template <class V>
struct Lanes3 {
  V x, y, z;
};

template <class V>
WEFT_INLINE Lanes3<V> operator+(const Lanes3<V>& a, const Lanes3<V>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class V>
WEFT_INLINE Lanes3<V> operator-(const Lanes3<V>& a, const Lanes3<V>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class V>
WEFT_INLINE Lanes3<V> operator-(const Lanes3<V>& a) {
  return {-a.x, -a.y, -a.z};
}
template <class V>
WEFT_INLINE Lanes3<V> operator*(V factor, const Lanes3<V>& a) {
  return {factor * a.x, factor * a.y, factor * a.z};
}
template <class V>
WEFT_INLINE V dot(const Lanes3<V>& a, const Lanes3<V>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class V>
WEFT_INLINE Lanes3<V> cross(const Lanes3<V>& a, const Lanes3<V>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <int... index>
struct LaneIndices {};
template <int count>
struct LaneIndicesUpTo;
template <>
struct LaneIndicesUpTo<2> : LaneIndices<0, 1> {};
template <>
struct LaneIndicesUpTo<4> : LaneIndices<0, 1, 2, 3> {};
template <>
struct LaneIndicesUpTo<8> : LaneIndices<0, 1, 2, 3, 4, 5, 6, 7> {};
template <>
struct LaneIndicesUpTo<16> : LaneIndices<0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15> {};

// Returns every second lane of the sequence a, b: lanes 0, 2, 4... if first = 0, or lanes 1, 3,
// 5... if first = 1.
template <int first, class V, int... index>
WEFT_INLINE V every_second(V a, V b, LaneIndices<index...>) {
  return __builtin_shufflevector(a, b, (2 * index + first)...);
}

// Loads one point per lane from points that are stored as four numbers each. The fourth numbers are
// ignored.
template <class Float>
WEFT_INLINE Lanes3<Lanes<Float>> load_points(const Float (*from)[4]) {
  using V = Lanes<Float>;
  constexpr LaneIndicesUpTo<lane_count<Float>> all;
  const V* part = reinterpret_cast<const V*>(from);
  const V xz0 = every_second<0>(part[0], part[1], all);
  const V xz1 = every_second<0>(part[2], part[3], all);
  const V yw0 = every_second<1>(part[0], part[1], all);
  const V yw1 = every_second<1>(part[2], part[3], all);
  return {every_second<0>(xz0, xz1, all), every_second<0>(yw0, yw1, all),
          every_second<1>(xz0, xz1, all)};
}

// Stores point - origin, subtracted in float64, as four numbers. The fourth is 0.
template <class Float>
WEFT_INLINE void store_point(const double* point, const double* origin, Float (&to)[4]) {
  typedef double Double4 __attribute__((vector_size(32)));
  typedef Float Float4 __attribute__((vector_size(4 * sizeof(Float))));
  const Double4 p = {point[0], point[1], point[2], 0};
  const Double4 o = {origin[0], origin[1], origin[2], 0};
  *reinterpret_cast<Float4*>(&to) = __builtin_convertvector(p - o, Float4);
}

}  // namespace weft::bsi::WEFT_KERNELS
