// A progress bar with the remaining time, on standard error.
#pragma once

#include <chrono>

namespace weft::sim {

// On a terminal the bar is redrawn ten times a second; elsewhere a line is printed at every tenth
// of the way.
class ProgressBar {
 public:
  ProgressBar(double end, bool shown);
  void show(double value);
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  double end_;
  bool shown_;
  bool terminal_;
  Clock::time_point start_, last_drawn_;
  int next_tenth_ = 1;
};

}  // namespace weft::sim
