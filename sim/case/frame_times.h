// The times at which a case records frames.
#pragma once

#include <optional>
#include <vector>

#include "sim/case/case.h"

namespace weft::sim {

// Either those of output.frame_times, or the start, every multiple of the interval and the end.
class FrameTimes {
 public:
  explicit FrameTimes(const Case& source);

  // Returns the time (s) of a frame, counted from 0; nothing after the last one.
  std::optional<double> at(long frame) const;
  // Returns the number of frames. Rounding may change it by one, unless times are given.
  double count() const;
  // True if there may be a frame after `from` and not after `to`, s.
  bool are_between(double from, double to) const;

 private:
  std::vector<double> times_;  // empty: by rate
  double rate_, duration_;     // 1/s, s
};

}  // namespace weft::sim
