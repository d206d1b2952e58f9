// The CPU time that a run may take.
#pragma once

#include <chrono>
#include <string>

#include "sim/simulation/simulation.h"

namespace weft::sim {

class CpuLimit {
 public:
  // Limits the CPU time (s) of the process, all threads together, from now on.
  explicit CpuLimit(double limit);
  // True if the limit is exceeded. Reads the clock of CPU time at most once per millisecond; other
  // calls cost some tens of nanoseconds.
  bool is_passed();
  // Leaves out CPU time (s) that was spent on something else.
  void exclude(double time) { start_ += time; }
  // The failure of a run that exceeded the limit: how far it came, by which steps, and where it is
  // fastest.
  Failure failure(const Simulation& simulation) const;

 private:
  double limit_;  // s
  double start_;  // s of CPU time
  std::chrono::steady_clock::time_point last_look_;
};

}  // namespace weft::sim
