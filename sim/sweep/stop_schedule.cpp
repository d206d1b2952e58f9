#include "sim/sweep/stop_schedule.h"

#include <algorithm>

namespace weft::sim {

namespace {

using Duration = StopSchedule::Clock::duration;
using std::chrono::seconds;

constexpr Duration shortest_window = seconds(2), longest_window = seconds(90);
constexpr Duration checkpoints_after_notice = seconds(30);

}  // namespace

StopSchedule::StopSchedule(std::optional<Clock::time_point> end, Clock::time_point now)
    : knows_end_(end.has_value()) {
  if (!end) return;
  const Duration window = std::clamp((*end - now) / 10, shortest_window, longest_window);
  last_checkpoints_ = *end - window;
  stop_ = *end - window / 2;
}

void StopSchedule::heed_notice(Clock::time_point now) {
  if (knows_end_ || last_checkpoints_) return;
  last_checkpoints_ = now;
  stop_ = now + checkpoints_after_notice;
}

StopSchedule::Phase StopSchedule::phase(Clock::time_point now) const {
  if (stop_ && now >= *stop_) return Phase::stopping;
  return last_checkpoints_ && now >= *last_checkpoints_ ? Phase::last_checkpoints : Phase::running;
}

}  // namespace weft::sim
