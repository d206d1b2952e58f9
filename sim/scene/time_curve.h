// Values of a case that may vary in time, and the times at which they limit steps.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <vector>

#include "sim/case/varying.h"
#include "sim/scene/gust.h"
#include "sim/scene/motion.h"

namespace weft::sim {

// A value of a case as a function of time.
template <class Value>
class TimeCurve {
 public:
  explicit TimeCurve(const Varying<Value>& source);

  bool varies() const { return varies_; }
  // Returns the value at an instant. O(log times) for a curve, O(waves) for a gust.
  Value at(const Instant& now) const;

 private:
  bool varies_;
  Value constant_;          // the value if it is constant
  CurveCase<Value> curve_;  // times and values if the value is given by a curve
  std::optional<Gust> gust_;
};

extern template class TimeCurve<double>;
extern template class TimeCurve<Vec3>;

// Times at which a varying value limits steps.
struct CurveTimes {
  // Corners and jumps after t = 0, where steps must end.
  std::vector<MotionEvent> events;
  // Intervals (s) in which the value changes. At a jump, both ends of the interval are the same.
  std::vector<std::array<double, 2>> changes;
  // Longest step (s) that resolves the gust; infinite if there is no gust.
  double longest_step = std::numeric_limits<double>::infinity();

  // Returns true if the value changes after `from` and before `to` (s).
  bool changes_between(double from, double to) const;
};

template <class Value>
CurveTimes times_of(const Varying<Value>& source);

extern template CurveTimes times_of(const Varying<double>&);
extern template CurveTimes times_of(const Varying<Vec3>&);

}  // namespace weft::sim
