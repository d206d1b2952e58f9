// The limit of CPU time for a run.
#pragma once

#include <chrono>
#include <string>

#include "sim/simulation/simulation.h"

namespace weft::sim {

class CpuLimit {
 public:
  // Starts to limit the CPU time (s) of the process, all threads together.
  explicit CpuLimit(double limit);
  // True if the limit is exceeded. Reads the clock of CPU time at most once per millisecond. Other
  // calls cost some tens of nanoseconds.
  bool is_passed();
  // Excludes CPU time (s) that was spent on something else. A negative time adds CPU time spent
  // earlier.
  void exclude(double time) { start_ += time; }
  // Returns the failure of a run that exceeded the limit. Its text tells the time reached, the
  // steps, and the fastest particle.
  Failure failure(const Simulation& simulation) const;

 private:
  double limit_;  // s of CPU time, at the start
  double start_;  // s of CPU time
  std::chrono::steady_clock::time_point last_look_;
};

}  // namespace weft::sim
