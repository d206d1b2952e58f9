#include "sim/scene/time_curve.h"

#include "sim/scene/easing.h"

namespace weft::sim {

namespace {

// Returns the index of the last entry of `times` that is not after `time`, or -1 if all entries are
// later.
int piece_at(const std::vector<double>& times, double time) {
  return static_cast<int>(std::upper_bound(times.begin(), times.end(), time) - times.begin()) - 1;
}

}  // namespace

template <class Value>
TimeCurve<Value>::TimeCurve(const Varying<Value>& source)
    : varies_(source.varies()), constant_(source.constant_or_zero()) {
  if (!varies_) return;
  if (source.gust() != nullptr) {
    gust_.emplace(*source.gust());
  } else {
    curve_ = *source.curve();
  }
}

template <class Value>
Value TimeCurve<Value>::at(const Instant& now) const {
  if (!varies_) return constant_;
  if constexpr (std::is_same_v<Value, Vec3>) {
    if (gust_) return gust_->at(now.time);
  }
  const auto& [times, values, between] = curve_;
  const int piece = piece_at(times, between == Between::step ? now.within : now.time);
  if (piece < 0) return values.front();
  if (between == Between::step || piece + 1 == static_cast<int>(times.size())) return values[piece];
  const double s = (now.time - times[piece]) / (times[piece + 1] - times[piece]);
  const double part = between == Between::smooth ? eased(s) : s;
  return values[piece] + part * (values[piece + 1] - values[piece]);
}

template class TimeCurve<double>;
template class TimeCurve<Vec3>;

bool CurveTimes::changes_between(double from, double to) const {
  const auto first =
      std::ranges::partition_point(changes, [&](const auto& change) { return change[1] <= from; });
  return first != changes.end() && (*first)[0] < to;
}

template <class Value>
CurveTimes times_of(const Varying<Value>& source) {
  CurveTimes result;
  if (!source.varies()) return result;
  if (source.gust() != nullptr) {
    result.longest_step = Gust(*source.gust()).longest_step();
    result.changes.push_back({0, std::numeric_limits<double>::infinity()});
    return result;
  }
  const auto& curve = *source.curve();
  const auto& times = curve.times;
  const auto& values = curve.values;
  const Between between = curve.between;
  const auto changes_after = [&](std::size_t i) {
    return i + 1 < times.size() && values[i] != values[i + 1];
  };
  for (std::size_t i = 0; i < times.size(); ++i) {
    const bool changes_before = i > 0 && changes_after(i - 1);
    if (between == Between::step) {
      if (changes_before) result.changes.push_back({times[i], times[i]});
    } else if (changes_after(i)) {
      result.changes.push_back({times[i], times[i + 1]});
    }
    const bool is_event = changes_before || (between != Between::step && changes_after(i));
    if (is_event && times[i] > 0) result.events.push_back({times[i], between == Between::step});
  }
  return result;
}

template CurveTimes times_of(const Varying<double>&);
template CurveTimes times_of(const Varying<Vec3>&);

}  // namespace weft::sim
