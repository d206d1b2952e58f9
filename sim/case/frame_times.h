// The times at which a case records frames.
#pragma once

#include <optional>
#include <vector>

#include "sim/case/case.h"

namespace weft::sim {

// The frames are at output.frame_times, if given. Otherwise they are at the start, at every
// multiple of the interval and at the end.
class FrameTimes {
 public:
  explicit FrameTimes(const Case& source);

  // Returns the time (s) of a frame, counted from 0, or nothing after the last frame.
  std::optional<double> at(long frame) const;
  // Returns the number of frames. Without output.frame_times rounding may change it by one.
  double count() const;
  // True if there may be a frame after `from` and not after `to` (s).
  bool are_between(double from, double to) const;

 private:
  std::vector<double> times_;  // empty: frames by rate
  double rate_, duration_;     // 1/s, s
};

}  // namespace weft::sim
