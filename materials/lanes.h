// Batches of numbers, one per lane of a vector register. The formulas of the materials are
// templates over their number type: `double` for one stencil, `Lanes` for one stencil per lane.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#if defined(__AVX__)
#include <immintrin.h>
#endif

namespace weft::materials {

// lane_count is the number of doubles in a batch. The name of the inline namespace depends on it. A
// program that was compiled with another lane count than Weft's libraries therefore fails to link.
#if defined(__AVX512F__)
inline namespace eight_lanes {
inline constexpr int lane_count = 8;
#else
inline namespace four_lanes {
inline constexpr int lane_count = 4;  // one AVX register, or two SSE registers
#endif

// A batch of numbers. It wraps GCC's vector extension in a class that Eigen's matrices accept as
// their scalar.
struct Lanes {
  typedef double Vector __attribute__((vector_size(8 * lane_count)));
  // The result of a comparison. In lanes where the comparison is true, all bits are set.
  struct Mask {
    typedef decltype(Vector{} < Vector{}) Bits;
    Bits bits;
    friend Mask operator^(Mask a, Mask b) { return {a.bits ^ b.bits}; }
    friend Mask operator|(Mask a, Mask b) { return {a.bits | b.bits}; }
  };

  Vector values;

  Lanes() = default;
  Lanes(double all) : values(all - Vector{}) {}  // NOLINT(google-explicit-constructor): a number
  explicit Lanes(Vector each) : values(each) {}

  Lanes& operator+=(Lanes b) { return values += b.values, *this; }
  Lanes& operator-=(Lanes b) { return values -= b.values, *this; }
  Lanes& operator*=(Lanes b) { return values *= b.values, *this; }
  Lanes& operator/=(Lanes b) { return values /= b.values, *this; }
  friend Lanes operator+(Lanes a, Lanes b) { return Lanes(a.values + b.values); }
  friend Lanes operator-(Lanes a, Lanes b) { return Lanes(a.values - b.values); }
  friend Lanes operator*(Lanes a, Lanes b) { return Lanes(a.values * b.values); }
  friend Lanes operator/(Lanes a, Lanes b) { return Lanes(a.values / b.values); }
  friend Lanes operator-(Lanes a) { return Lanes(-a.values); }
  friend Mask operator<(Lanes a, Lanes b) { return {a.values < b.values}; }
  friend Mask operator<=(Lanes a, Lanes b) { return {a.values <= b.values}; }
  friend Mask operator==(Lanes a, Lanes b) { return {a.values == b.values}; }
};

// The functions square_root(), larger(), choose() and arc_tangent() exist for both number types; on
// `Lanes` they act lane by lane.
inline double square_root(double a) { return std::sqrt(a); }
inline double larger(double a, double b) { return a > b ? a : b; }
inline double choose(bool condition, double yes, double no) { return condition ? yes : no; }
inline double arc_tangent(double y, double x) { return std::atan2(y, x); }

inline Lanes square_root(Lanes a) {
#if defined(__AVX512F__)
  return Lanes(Lanes::Vector(_mm512_sqrt_pd(a.values)));
#elif defined(__AVX__)
  return Lanes(Lanes::Vector(_mm256_sqrt_pd(a.values)));
#else
  Lanes root;
  for (int i = 0; i < lane_count; ++i) root.values[i] = std::sqrt(a.values[i]);
  return root;
#endif
}
inline Lanes larger(Lanes a, Lanes b) { return Lanes(a.values > b.values ? a.values : b.values); }
inline Lanes choose(Lanes::Mask condition, Lanes yes, Lanes no) {
  return Lanes(condition.bits ? yes.values : no.values);
}
// Returns `a`, negated in the lanes where the condition holds.
inline Lanes negate_where(Lanes::Mask condition, Lanes a) { return choose(condition, -a, a); }
inline Lanes magnitude(Lanes a) { return negate_where(a < Lanes(0), a); }

// Returns std::atan2(y, x) within 2 units in the last place. Precondition: the sum and the ratio of
// |x| and |y| neither overflow nor underflow. Zeros count as positive, so two zeros give 0. NaN
// gives NaN. Symmetries reduce the problem to atan t with |t| <= 0.66. There
// atan t = t + t^3 P(t^2) / Q(t^2), with a relative error of 1.8e-16 (S. L. Moshier, Cephes,
// atan.c, 1984).
inline Lanes arc_tangent(Lanes y, Lanes x) {
  constexpr double half_pi = std::numbers::pi / 2, half_pi_rest = 6.123233995736765886e-17;
  const Lanes height = magnitude(y), width = magnitude(x);
  const Lanes::Mask is_steep = width < height, is_back = x < Lanes(0);
  const Lanes shorter = choose(is_steep, width, height), longer = choose(is_steep, height, width);
  const Lanes::Mask is_diagonal = 0.66 * longer < shorter;
  const Lanes denominator = choose(is_diagonal, shorter + longer, longer);
  const Lanes t = choose(is_diagonal, shorter - longer, shorter) /
                  choose(denominator == Lanes(0), 1.0, denominator);
  const Lanes z = t * t;
  const Lanes p = (((-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z -
                    7.500855792314704667340e1) *
                       z -
                   1.228866684490136173410e2) *
                      z -
                  6.485021904942025371773e1;
  const Lanes q = ((((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z +
                    4.328810604912902668951e2) *
                       z +
                   4.853903996359136964868e2) *
                      z +
                  1.945506571482613964425e2;
  const Lanes small = t + t * (z * p / q);
  // The angle is that of the octant plus or minus `small`. The octant's angle is a multiple of
  // pi / 4: the rounded multiple `octant` plus its rounding error `rest`. The sign of y is applied
  // last.
  Lanes octant = choose(is_diagonal, half_pi / 2, 0.0);
  octant = choose(is_steep, half_pi - octant, octant);
  octant = choose(is_back, 2 * half_pi - octant, octant);
  const Lanes rest = half_pi_rest / half_pi * octant;
  const Lanes angle = octant + (negate_where(is_steep ^ is_back, small) + rest);
  return negate_where(y < Lanes(0), angle);
}

// The functions below work on lane_count vectors of three numbers that are adjacent in memory.
// Each vector belongs to one lane. Pointers to unaligned numbers spell out their type, because
// `auto` would deduce an aligned one.
typedef double UnalignedLanes __attribute__((vector_size(8 * lane_count), aligned(8), may_alias));

#if defined(__AVX512F__)
// Loads adjacent vectors from an address. Returns all their x, all y and all z, by lane.
inline std::array<Lanes, 3> load_vectors(const double* at) {
  const UnalignedLanes* rows =
      reinterpret_cast<const UnalignedLanes*>(at);  // NOLINT(modernize-use-auto)
  const Lanes::Vector a = rows[0], b = rows[1], c = rows[2];
  const Lanes::Vector x = __builtin_shufflevector(a, b, 0, 3, 6, 9, 12, 15, 0, 0);
  const Lanes::Vector y = __builtin_shufflevector(a, b, 1, 4, 7, 10, 13, 0, 0, 0);
  const Lanes::Vector z = __builtin_shufflevector(a, b, 2, 5, 8, 11, 14, 0, 0, 0);
  return {Lanes(__builtin_shufflevector(x, c, 0, 1, 2, 3, 4, 5, 10, 13)),
          Lanes(__builtin_shufflevector(y, c, 0, 1, 2, 3, 4, 8, 11, 14)),
          Lanes(__builtin_shufflevector(z, c, 0, 1, 2, 3, 4, 9, 12, 15))};
}
// Adds the vector of lane i to the i-th of the adjacent vectors at an address.
inline void add_vectors(const std::array<Lanes, 3>& v, double* at) {
  UnalignedLanes* rows = reinterpret_cast<UnalignedLanes*>(at);  // NOLINT(modernize-use-auto)
  const Lanes::Vector x = v[0].values, y = v[1].values, z = v[2].values;
  const Lanes::Vector a = __builtin_shufflevector(x, y, 0, 8, 0, 1, 9, 0, 2, 10);
  const Lanes::Vector b = __builtin_shufflevector(x, y, 0, 3, 11, 0, 4, 12, 0, 5);
  const Lanes::Vector c = __builtin_shufflevector(x, y, 13, 0, 6, 14, 0, 7, 15, 0);
  rows[0] += __builtin_shufflevector(a, z, 0, 1, 8, 3, 4, 9, 6, 7);
  rows[1] += __builtin_shufflevector(b, z, 10, 1, 2, 11, 4, 5, 12, 7);
  rows[2] += __builtin_shufflevector(c, z, 0, 13, 2, 3, 14, 5, 6, 15);
}
// Returns each number of `a` three times in succession: factors for the components of adjacent
// vectors.
inline std::array<Lanes, 3> threefold(Lanes a) {
  const Lanes::Vector v = a.values;
  return {Lanes(__builtin_shufflevector(v, v, 0, 0, 0, 1, 1, 1, 2, 2)),
          Lanes(__builtin_shufflevector(v, v, 2, 3, 3, 3, 4, 4, 4, 5)),
          Lanes(__builtin_shufflevector(v, v, 5, 5, 6, 6, 6, 7, 7, 7))};
}
// Returns the numbers of `a` moved up by one lane. The last number of `before` fills the first
// lane.
inline Lanes moved_up(Lanes before, Lanes a) {
  return Lanes(__builtin_shufflevector(before.values, a.values, 7, 8, 9, 10, 11, 12, 13, 14));
}
#else
typedef double Pair __attribute__((vector_size(16)));
typedef double UnalignedPair __attribute__((vector_size(16), aligned(8), may_alias));

// Does the same as load_vectors() above, for four lanes. It loads pairs of numbers. Two pairs that
// are six numbers apart in memory fill the halves of a register. All further shuffles are within
// halves, which makes them fast.
inline std::array<Lanes, 3> load_vectors(const double* at) {
  const auto half = [at](int i) { return Pair(*reinterpret_cast<const UnalignedPair*>(at + i)); };
  const Lanes::Vector xy = __builtin_shufflevector(half(0), half(6), 0, 1, 2, 3);
  const Lanes::Vector zx = __builtin_shufflevector(half(2), half(8), 0, 1, 2, 3);
  const Lanes::Vector yz = __builtin_shufflevector(half(4), half(10), 0, 1, 2, 3);
  return {Lanes(__builtin_shufflevector(xy, zx, 0, 5, 2, 7)),
          Lanes(__builtin_shufflevector(xy, yz, 1, 4, 3, 6)),
          Lanes(__builtin_shufflevector(zx, yz, 0, 5, 2, 7))};
}
inline void add_vectors(const std::array<Lanes, 3>& v, double* at) {
  UnalignedLanes* rows = reinterpret_cast<UnalignedLanes*>(at);  // NOLINT(modernize-use-auto)
  const Lanes::Vector xy = __builtin_shufflevector(v[0].values, v[1].values, 0, 4, 2, 6);
  const Lanes::Vector zx = __builtin_shufflevector(v[2].values, v[0].values, 0, 5, 2, 7);
  const Lanes::Vector yz = __builtin_shufflevector(v[1].values, v[2].values, 1, 5, 3, 7);
  rows[0] += __builtin_shufflevector(xy, zx, 0, 1, 4, 5);
  rows[1] += __builtin_shufflevector(yz, xy, 0, 1, 6, 7);
  rows[2] += __builtin_shufflevector(zx, yz, 2, 3, 6, 7);
}
inline std::array<Lanes, 3> threefold(Lanes a) {
  const Lanes::Vector v = a.values;
  return {Lanes(__builtin_shufflevector(v, v, 0, 0, 0, 1)),
          Lanes(__builtin_shufflevector(v, v, 1, 1, 2, 2)),
          Lanes(__builtin_shufflevector(v, v, 2, 3, 3, 3))};
}
inline Lanes moved_up(Lanes before, Lanes a) {
  return Lanes(__builtin_shufflevector(before.values, a.values, 3, 4, 5, 6));
}
#endif

// Returns the adjacent numbers at an address.
inline Lanes lanes_at(const double* at) {
  return Lanes(Lanes::Vector(*reinterpret_cast<const UnalignedLanes*>(at)));
}
inline double sum_of_lanes(Lanes a) {
  double sum = 0;
  for (int i = 0; i < lane_count; ++i) sum += a.values[i];
  return sum;
}

}  // namespace eight_lanes or four_lanes
}  // namespace weft::materials

template <>
struct Eigen::NumTraits<weft::materials::Lanes> : Eigen::NumTraits<double> {
  using Real = weft::materials::Lanes;
  using NonInteger = weft::materials::Lanes;
  using Nested = weft::materials::Lanes;
  using Literal = double;
};
template <class Operation>
struct Eigen::ScalarBinaryOpTraits<double, weft::materials::Lanes, Operation> {
  using ReturnType = weft::materials::Lanes;
};
