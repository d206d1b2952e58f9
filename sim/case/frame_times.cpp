#include "sim/case/frame_times.h"

#include <algorithm>
#include <cmath>

namespace weft::sim {

FrameTimes::FrameTimes(const Case& source)
    : times_(source.output.frame_times),
      rate_(source.time.frames_per_second),
      duration_(source.time.duration) {}

std::optional<double> FrameTimes::at(long frame) const {
  if (!times_.empty()) {
    if (frame >= static_cast<long>(times_.size())) return std::nullopt;
    return times_[static_cast<std::size_t>(frame)];
  }
  if (frame > 0 && static_cast<double>(frame - 1) / rate_ >= duration_) return std::nullopt;
  return std::min(static_cast<double>(frame) / rate_, duration_);
}

double FrameTimes::count() const {
  if (!times_.empty()) return static_cast<double>(times_.size());
  return 1 + std::ceil(duration_ * rate_ * (1 - 1e-12));
}

bool FrameTimes::are_between(double from, double to) const {
  if (!times_.empty())
    return std::ranges::upper_bound(times_, from) != std::ranges::upper_bound(times_, to);
  return to >= duration_ || std::floor(from * rate_) != std::floor(to * rate_);
}

}  // namespace weft::sim
