// Numbers with their derivatives by three variables (forward-mode automatic differentiation). A
// formula that is a template over its number type also gives its gradient and Hessian, exact to
// rounding. The number types are double, Lanes, and jets of double or Lanes.
#pragma once

#include <array>
#include <cstddef>

#include "materials/lanes.h"

namespace weft::materials {

// A number with its gradient and, for order 2, the upper triangle of its Hessian, row by row.
// `Real` is double or Lanes; order is 1 or 2.
template <class Real, int order>
struct Jet {
  static constexpr std::size_t second_count = order == 2 ? 6 : 0;
  Real value;
  std::array<Real, 3> first;
  std::array<Real, second_count> second;

  Jet() = default;
  Jet(const Real& constant) : value(constant) {  // NOLINT(google-explicit-constructor): a number
    first.fill(0.0);
    second.fill(0.0);
  }
  // Returns variable i with this value. Its gradient is unit vector i, and its Hessian is zero.
  static Jet variable(const Real& value, int i) {
    Jet result(value);
    result.first[i] = 1.0;
    return result;
  }

  Jet& operator+=(const Jet& b) { return *this = *this + b; }
  friend Jet operator+(const Jet& a, const Jet& b) { return combined(a, b, 1.0, 1.0); }
  friend Jet operator-(const Jet& a, const Jet& b) { return combined(a, b, 1.0, -1.0); }
  friend Jet operator*(const Real& factor, const Jet& a) {
    Jet result;
    result.value = factor * a.value;
    for (int i = 0; i < 3; ++i) result.first[i] = factor * a.first[i];
    for (std::size_t k = 0; k < second_count; ++k) result.second[k] = factor * a.second[k];
    return result;
  }
  friend Jet operator*(const Jet& a, const Jet& b) {
    Jet result;
    result.value = a.value * b.value;
    for (int i = 0; i < 3; ++i) result.first[i] = a.value * b.first[i] + b.value * a.first[i];
    if constexpr (order == 2) {
      for (int i = 0, k = 0; i < 3; ++i) {
        for (int j = i; j < 3; ++j, ++k) {
          result.second[k] = a.value * b.second[k] + b.value * a.second[k] +
                             a.first[i] * b.first[j] + a.first[j] * b.first[i];
        }
      }
    }
    return result;
  }

 private:
  static Jet combined(const Jet& a, const Jet& b, double p, double q) {
    Jet result;
    result.value = p * a.value + q * b.value;
    for (int i = 0; i < 3; ++i) result.first[i] = p * a.first[i] + q * b.first[i];
    for (std::size_t k = 0; k < second_count; ++k)
      result.second[k] = p * a.second[k] + q * b.second[k];
    return result;
  }
};

// Returns the value of a number, without the derivatives of a jet.
inline double value_of(double a) { return a; }
inline Lanes value_of(const Lanes& a) { return a; }
template <class Real, int order>
Real value_of(const Jet<Real, order>& a) {
  return a.value;
}

// Returns f(a) with its derivatives by the chain rule. The arguments after a are the values of f,
// f' and f'' at a.
inline double composed(double, double f, double, double) { return f; }
inline Lanes composed(const Lanes&, const Lanes& f, const Lanes&, const Lanes&) { return f; }
template <class Real, int order>
Jet<Real, order> composed(const Jet<Real, order>& a, const Real& f, const Real& slope,
                          const Real& curvature) {
  Jet<Real, order> result;
  result.value = f;
  for (int i = 0; i < 3; ++i) result.first[i] = slope * a.first[i];
  if constexpr (order == 2) {
    for (int i = 0, k = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j, ++k)
        result.second[k] = slope * a.second[k] + curvature * a.first[i] * a.first[j];
    }
  }
  return result;
}

// Returns 1 / a. Precondition: a is not zero.
template <class Number>
Number inverse(const Number& a) {
  const auto f = 1.0 / value_of(a);
  const auto slope = -f * f;
  return composed(a, f, slope, -2.0 * slope * f);
}
// Returns the square root of a. Precondition: a is positive.
template <class Number>
Number root(const Number& a) {
  const auto f = square_root(value_of(a));
  const auto slope = 0.5 / f;
  return composed(a, f, slope, -0.5 * slope / value_of(a));
}
// Returns the larger of `a` and the constant `least`. The derivatives are those of `a` if `a`
// exceeds `least`, else zero.
template <class Number>
Number at_least(const Number& a, double least) {
  using Real = decltype(value_of(a));
  const Real value = value_of(a);
  return composed(a, larger(value, least), choose(least < value, Real(1.0), Real(0.0)), Real(0.0));
}

}  // namespace weft::materials
