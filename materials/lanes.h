// Eight numbers side by side: the formulas of the materials are templates over their number type,
// `double` for one stencil, `Lanes` for eight at once.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

#if defined(__AVX512F__)
#include <immintrin.h>
#endif

namespace weft::materials {

inline constexpr int lane_count = 8;

// A vector of GCC's extension in a class, so that it can be the scalar of Eigen's matrices. On
// narrower processors the compiler makes several instructions of each.
struct Lanes {
  typedef double Vector __attribute__((vector_size(8 * lane_count)));
  // Of a comparison: all bits set where true.
  typedef decltype(Vector{} < Vector{}) Mask;

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
  friend Mask operator<(Lanes a, Lanes b) { return a.values < b.values; }
  friend Mask operator<=(Lanes a, Lanes b) { return a.values <= b.values; }
  friend Mask operator==(Lanes a, Lanes b) { return a.values == b.values; }
};

// What formulas ask of either number type, lane by lane.
inline double square_root(double a) { return std::sqrt(a); }
inline double larger(double a, double b) { return a > b ? a : b; }
inline double choose(bool condition, double yes, double no) { return condition ? yes : no; }
inline double arc_tangent(double y, double x) { return std::atan2(y, x); }

inline Lanes square_root(Lanes a) {
#if defined(__AVX512F__)
  return Lanes(Lanes::Vector(_mm512_sqrt_pd(a.values)));
#else
  Lanes root;
  for (int i = 0; i < lane_count; ++i) root.values[i] = std::sqrt(a.values[i]);
  return root;
#endif
}
inline Lanes larger(Lanes a, Lanes b) { return Lanes(a.values > b.values ? a.values : b.values); }
inline Lanes choose(Lanes::Mask condition, Lanes yes, Lanes no) {
  return Lanes(condition ? yes.values : no.values);
}
inline Lanes arc_tangent(Lanes y, Lanes x) {
  Lanes angle;
  for (int i = 0; i < lane_count; ++i) angle.values[i] = std::atan2(y.values[i], x.values[i]);
  return angle;
}
// Row i of eight numbers becomes column i.
inline void transpose(std::array<Lanes::Vector, lane_count>& rows) {
  using Vector = Lanes::Vector;
  using Index = decltype(Vector{} < Vector{});
  // Within pairs of rows, then pairs of pairs, then halves.
  constexpr Index even{0, 8, 2, 10, 4, 12, 6, 14}, odd{1, 9, 3, 11, 5, 13, 7, 15};
  constexpr Index even_pairs{0, 1, 8, 9, 4, 5, 12, 13}, odd_pairs{2, 3, 10, 11, 6, 7, 14, 15};
  constexpr Index low{0, 1, 2, 3, 8, 9, 10, 11}, high{4, 5, 6, 7, 12, 13, 14, 15};
  const auto exchange = [&rows](int distance, const Index& first, const Index& second) {
    for (int i = 0; i < lane_count; ++i) {
      if ((i & distance) != 0) continue;
      const Vector a = rows[i], b = rows[i + distance];
      rows[i] = __builtin_shuffle(a, b, first);
      rows[i + distance] = __builtin_shuffle(a, b, second);
    }
  };
  exchange(1, even, odd);
  exchange(2, even_pairs, odd_pairs);
  exchange(4, low, high);
}

inline double sum_of_lanes(Lanes a) {
  double sum = 0;
  for (int i = 0; i < lane_count; ++i) sum += a.values[i];
  return sum;
}

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
