// Values of a case that vary in time, evaluated by forces, and the times at which they limit steps.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <vector>

#include "sim/case/varying.h"
#include "sim/scene/gust.h"
#include "sim/scene/motion.h"

namespace weft::sim {

// A value of a case that can be evaluated at any time.
template <class Value>
class TimeCurve {
 public:
  explicit TimeCurve(const Varying<Value>& source);

  bool varies() const { return varies_; }
  // Returns the value at an instant. Cost: O(log times); O(waves) for a gust.
  Value at(const Instant& now) const;

 private:
  bool varies_;
  Value constant_;          // if it does not vary
  CurveCase<Value> curve_;  // if it has times
  std::optional<Gust> gust_;
};

extern template class TimeCurve<double>;
extern template class TimeCurve<Vec3>;

// The times of a varying value that limit the choice of steps.
struct CurveTimes {
  // Corners and jumps after t = 0, where steps must end.
  std::vector<MotionEvent> events;
  // Intervals (s) in which the value changes; a jump is an interval of no length.
  std::vector<std::array<double, 2>> changes;
  double longest_step = std::numeric_limits<double>::infinity();  // s; resolves a gust

  // Returns true if the value changes after `from` and before `to` (s).
  bool changes_between(double from, double to) const;
};

template <class Value>
CurveTimes times_of(const Varying<Value>& source);

extern template CurveTimes times_of(const Varying<double>&);
extern template CurveTimes times_of(const Varying<Vec3>&);

}  // namespace weft::sim
