// The times at which a case records frames.
#pragma once

#include <optional>
#include <vector>

#include "sim/case/case.h"

namespace weft::sim {

// The times of frames are output.frame_times, if given. Otherwise they are the start, the multiples
// of 1 / time.frames_per_second before the end of the run, and this end.
class FrameTimes {
 public:
  explicit FrameTimes(const Case& source);

  // Returns the time (s) of a frame. `frame` counts from 0. Returns nothing after the last frame.
  std::optional<double> at(long frame) const;
  // Returns the number of frames. Without output.frame_times it may be wrong by one, due to
  // rounding.
  double count() const;
  // True if a frame may lie in the half-open interval (from, to], in seconds.
  bool are_between(double from, double to) const;

 private:
  std::vector<double> times_;  // output.frame_times (s)
  double rate_, duration_;     // time.frames_per_second (1/s) and time.duration (s)
};

}  // namespace weft::sim
