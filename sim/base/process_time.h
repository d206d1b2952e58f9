// The CPU time of the process.
#pragma once

#include <ctime>

namespace weft::sim {

// Returns the CPU time of all threads of the process (s).
inline double process_cpu_time() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace weft::sim
