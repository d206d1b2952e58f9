// The CPU time that a run may take.
#pragma once

#include <chrono>
#include <string>

#include "sim/simulation/simulation.h"

namespace weft::sim {

class CpuLimit {
 public:
  // `limit` (s) of CPU time of the process, all its threads together, from now on.
  explicit CpuLimit(double limit);
  // Looks at most once a millisecond; in between it costs some tens of nanoseconds.
  bool is_passed();
  // Leaves out so much CPU time (s) that was spent on something else.
  void exclude(double time) { start_ += time; }
  // The end of a run that has passed it: how far it came, by what steps, and where it is fastest.
  Failure failure(const Simulation& simulation) const;

 private:
  double limit_;  // s
  double start_;  // s of CPU time
  std::chrono::steady_clock::time_point last_look_;
};

}  // namespace weft::sim
