// Values of a case that may vary in time.
#pragma once

#include <algorithm>
#include <cassert>
#include <type_traits>
#include <variant>
#include <vector>

#include "sim/base/vectors.h"

namespace weft::sim {

// The interpolation of a curve between two of its times. linear: straight. smooth: eased, with zero
// first and second derivatives at the times. step: constant until the next time.
enum class Between { linear, smooth, step };

// A curve through values at given times. The first value holds before the first time, and the last
// value after the last time.
template <class Value>
struct CurveCase {
  std::vector<double> times;  // s, not negative, increasing
  std::vector<Value> values;  // one per time
  Between between = Between::linear;
};

// A wind whose speed fluctuates at random about its mean (sim/scene/gust.h).
struct GustCase {
  Vec3 mean{0, 0, 0};     // m/s
  double intensity = 0;   // standard deviation of the speed, divided by the mean speed
  double time_scale = 1;  // s, integral of the speed's autocorrelation
  int seed = 1;           // seed of the random phases, >= 0
};

// A number or vector of a case: a constant, a curve or, for vectors only, a gust.
template <class Value>
struct Varying {
  std::variant<Value, CurveCase<Value>, GustCase> form;

  Varying(const Value& constant) : form(constant) {}

  const CurveCase<Value>* curve() const { return std::get_if<CurveCase<Value>>(&form); }
  const GustCase* gust() const { return std::get_if<GustCase>(&form); }

  // True if the value changes with time. A curve of equal values does not vary.
  bool varies() const {
    if (gust() != nullptr) return gust()->intensity > 0 && !gust()->mean.isZero(0);
    if (curve() == nullptr) return false;
    const std::vector<Value>& values = curve()->values;
    return std::any_of(values.begin(), values.end(),
                       [&](const Value& value) { return value != values.front(); });
  }
  // Returns the value that holds at all times. Precondition: !varies().
  Value constant() const {
    assert(!varies());
    if (curve() != nullptr) return curve()->values.front();
    if constexpr (std::is_same_v<Value, Vec3>) {
      if (gust() != nullptr) return gust()->mean;
    }
    return std::get<Value>(form);
  }
  // Returns the value that holds at all times, or zero if the value varies.
  Value constant_or_zero() const { return varies() ? zero() : constant(); }
  // True if the value is zero at all times.
  bool is_zero() const { return !varies() && constant() == zero(); }

 private:
  static Value zero() {
    if constexpr (std::is_same_v<Value, Vec3>) {
      return Vec3::Zero();
    } else {
      return 0;
    }
  }
};

// Returns the minimum of the number over all times.
inline double smallest(const Varying<double>& number) {
  if (!number.varies()) return number.constant();
  return *std::min_element(number.curve()->values.begin(), number.curve()->values.end());
}

}  // namespace weft::sim
