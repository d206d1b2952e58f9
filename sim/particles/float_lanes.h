// Batches of numbers in single precision, one per row of a batch (row_batches.h).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "sim/base/vectors.h"
#include "sim/particles/row_batches.h"

#if defined(__AVX__)
#include <immintrin.h>
#endif

namespace weft::sim {

// A batch of numbers: one AVX register, or two SSE registers. It wraps GCC's vector extension in a
// class that Eigen's matrices accept as their scalar.
struct FloatLanes {
  static constexpr int count = RowBatches::width;
  typedef float Vector __attribute__((vector_size(4 * count)));
  // The result of a comparison. In lanes where the comparison is true, all bits are set.
  struct Mask {
    typedef decltype(Vector{} < Vector{}) Bits;
    Bits bits;
    friend Mask operator|(Mask a, Mask b) { return {a.bits | b.bits}; }
  };

  Vector values;

  FloatLanes() = default;
  FloatLanes(float all) : values(all - Vector{}) {}  // NOLINT(google-explicit-constructor)
  explicit FloatLanes(Vector each) : values(each) {}

  FloatLanes& operator+=(FloatLanes b) { return values += b.values, *this; }
  FloatLanes& operator-=(FloatLanes b) { return values -= b.values, *this; }
  FloatLanes& operator*=(FloatLanes b) { return values *= b.values, *this; }
  friend FloatLanes operator+(FloatLanes a, FloatLanes b) {
    return FloatLanes(a.values + b.values);
  }
  friend FloatLanes operator-(FloatLanes a, FloatLanes b) {
    return FloatLanes(a.values - b.values);
  }
  friend FloatLanes operator*(FloatLanes a, FloatLanes b) {
    return FloatLanes(a.values * b.values);
  }
  friend FloatLanes operator/(FloatLanes a, FloatLanes b) {
    return FloatLanes(a.values / b.values);
  }
  friend FloatLanes operator-(FloatLanes a) { return FloatLanes(-a.values); }
  friend Mask operator<(FloatLanes a, FloatLanes b) { return {a.values < b.values}; }
};

// These act lane by lane.
inline FloatLanes square_root(FloatLanes a) {
#if defined(__AVX__)
  return FloatLanes(FloatLanes::Vector(_mm256_sqrt_ps(a.values)));
#else
  for (int i = 0; i < FloatLanes::count; ++i) a.values[i] = std::sqrt(a.values[i]);
  return a;
#endif
}
inline FloatLanes larger(FloatLanes a, FloatLanes b) {
  return FloatLanes(a.values > b.values ? a.values : b.values);
}
inline FloatLanes choose(FloatLanes::Mask condition, FloatLanes yes, FloatLanes no) {
  return FloatLanes(condition.bits ? yes.values : no.values);
}
inline FloatLanes magnitude(FloatLanes a) { return choose(a < FloatLanes(0), -a, a); }

// Returns one bit per lane, which is set where the comparison is true. Lane 0 has the lowest bit.
inline unsigned bits_of(FloatLanes::Mask mask) {
#if defined(__AVX__)
  return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask.bits)));
#else
  unsigned bits = 0;
  for (int i = 0; i < FloatLanes::count; ++i) bits |= (mask.bits[i] != 0 ? 1U : 0U) << i;
  return bits;
#endif
}

// Four adjacent numbers in memory, aligned to their size.
typedef float FourFloats __attribute__((vector_size(16), may_alias));

// Transposes two squares of four by four numbers side by side.
inline void transpose_squares(std::array<FloatLanes::Vector, 4>& rows) {
  const auto [a, b, c, d] = rows;
  const FloatLanes::Vector low_ac = __builtin_shufflevector(a, c, 0, 8, 1, 9, 4, 12, 5, 13),
                           high_ac = __builtin_shufflevector(a, c, 2, 10, 3, 11, 6, 14, 7, 15),
                           low_bd = __builtin_shufflevector(b, d, 0, 8, 1, 9, 4, 12, 5, 13),
                           high_bd = __builtin_shufflevector(b, d, 2, 10, 3, 11, 6, 14, 7, 15);
  rows = {__builtin_shufflevector(low_ac, low_bd, 0, 8, 1, 9, 4, 12, 5, 13),
          __builtin_shufflevector(low_ac, low_bd, 2, 10, 3, 11, 6, 14, 7, 15),
          __builtin_shufflevector(high_ac, high_bd, 0, 8, 1, 9, 4, 12, 5, 13),
          __builtin_shufflevector(high_ac, high_bd, 2, 10, 3, 11, 6, 14, 7, 15)};
}

// Loads four adjacent numbers at the address of each lane, which `at` returns. Returns the first
// number of every address, by lane, then all second ones, and so on.
template <class Address>
[[gnu::always_inline]] inline std::array<FloatLanes, 4> load_fours(const Address& at) {
  std::array<FloatLanes::Vector, 4> rows;
  for (int i = 0; i < 4; ++i) {
    const FourFloats low = *reinterpret_cast<const FourFloats*>(at(i)),
                     high = *reinterpret_cast<const FourFloats*>(at(i + 4));
    rows[i] = __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
  }
  transpose_squares(rows);
  return {FloatLanes(rows[0]), FloatLanes(rows[1]), FloatLanes(rows[2]), FloatLanes(rows[3])};
}
// Stores what load_fours() returns, lane 0 first.
template <class Address>
[[gnu::always_inline]] inline void store_fours(const std::array<FloatLanes, 4>& numbers,
                                               const Address& at) {
  std::array<FloatLanes::Vector, 4> rows{numbers[0].values, numbers[1].values, numbers[2].values,
                                         numbers[3].values};
  transpose_squares(rows);
  for (int i = 0; i < FloatLanes::count; ++i) {
    FourFloats* const to = reinterpret_cast<FourFloats*>(at(i));  // NOLINT(modernize-use-auto)
    *to = i < 4 ? __builtin_shufflevector(rows[i], rows[i], 0, 1, 2, 3)
                : __builtin_shufflevector(rows[i - 4], rows[i - 4], 4, 5, 6, 7);
  }
}

}  // namespace weft::sim

template <>
struct Eigen::NumTraits<weft::sim::FloatLanes> : Eigen::NumTraits<float> {
  using Real = weft::sim::FloatLanes;
  using NonInteger = weft::sim::FloatLanes;
  using Nested = weft::sim::FloatLanes;
  using Literal = float;
};

namespace weft::sim {

using FloatLaneVec3 = Eigen::Matrix<FloatLanes, 3, 1>;

inline void set_lane(FloatLaneVec3& vectors, int lane, const Vec3& vector) {
  for (int k = 0; k < 3; ++k) vectors[k].values[lane] = static_cast<float>(vector[k]);
}
inline Vec3 get_lane(const FloatLaneVec3& vectors, int lane) {
  return {vectors[0].values[lane], vectors[1].values[lane], vectors[2].values[lane]};
}

}  // namespace weft::sim
