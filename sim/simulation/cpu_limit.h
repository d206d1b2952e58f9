// The limit of CPU time for a run.
#pragma once

#include <chrono>
#include <string>

#include "sim/simulation/simulation.h"

namespace weft::sim {

class CpuLimit {
 public:
  // Limits the CPU time of the process, all threads together, to `limit` (s) from now on.
  explicit CpuLimit(double limit);
  // True if the limit is exceeded. Reads the clock of CPU time at most once per millisecond. Other
  // calls read only a fast clock and return false.
  bool is_passed();
  // Excludes `time` (s) of CPU time that was not spent on the run. A negative `time` counts CPU
  // time spent before the start.
  void exclude(double time) { start_ += time; }
  // Returns the failure of a run that exceeded the limit. Its text states the time reached, the
  // numbers of steps and cut steps, and the fastest particle, if a particle moves.
  Failure failure(const Simulation& simulation) const;

 private:
  double limit_;  // largest CPU time (s)
  double start_;  // CPU time of the process at the start (s)
  std::chrono::steady_clock::time_point last_look_;
};

}  // namespace weft::sim
