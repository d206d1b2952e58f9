// Eight numbers side by side: the formulas of the materials are templates over their number type,
// `double` for one stencil, `Lanes` for eight at once.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <utility>

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
// Exchanges halves of each 2 distance numbers between each row and that `distance` below it.
template <int distance, int... lane>
void exchange(std::array<Lanes::Vector, lane_count>& rows, std::integer_sequence<int, lane...>) {
  for (int i = 0; i < lane_count; ++i) {
    if ((i & distance) != 0) continue;
    const Lanes::Vector a = rows[i], b = rows[i + distance];
    rows[i] = __builtin_shufflevector(
        a, b, ((lane & distance) == 0 ? lane : lane_count + lane - distance)...);
    rows[i + distance] = __builtin_shufflevector(
        a, b, ((lane & distance) == 0 ? lane + distance : lane_count + lane)...);
  }
}
// Row i of eight numbers becomes column i.
inline void transpose(std::array<Lanes::Vector, lane_count>& rows) {
  constexpr std::make_integer_sequence<int, lane_count> lanes;
  exchange<1>(rows, lanes);
  exchange<2>(rows, lanes);
  exchange<4>(rows, lanes);
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
