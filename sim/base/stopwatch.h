// Clocks for the cost of the parts of a run.
#pragma once

#include <chrono>

#include "sim/base/bill.h"
#include "sim/base/process_time.h"

namespace weft::sim {

// Measures the wall and CPU time since its construction.
class Stopwatch {
 public:
  Stopwatch() : Stopwatch(std::chrono::steady_clock::now(), process_cpu_time()) {}
  // Returns a stopwatch that measures since the start of the process. The wall time from that start
  // to this call is estimated by the CPU time so far.
  static Stopwatch since_process_start() {
    const std::chrono::duration<double> loading(process_cpu_time());
    return {std::chrono::steady_clock::now() -
                std::chrono::duration_cast<std::chrono::steady_clock::duration>(loading),
            0};
  }
  Cost elapsed() const {
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - wall_start_;
    return {wall.count(), process_cpu_time() - cpu_start_};
  }

 private:
  Stopwatch(std::chrono::steady_clock::time_point wall_start, double cpu_start)
      : wall_start_(wall_start), cpu_start_(cpu_start) {}

  std::chrono::steady_clock::time_point wall_start_;
  double cpu_start_;  // CPU time of the process at the start, s
};

// Adds the wall and CPU time from its construction to its destruction to one part of the bill.
class CostTimer {
 public:
  explicit CostTimer(Cost& part) : part_(part) {}
  ~CostTimer() { part_ += stopwatch_.elapsed(); }
  CostTimer(const CostTimer&) = delete;
  CostTimer& operator=(const CostTimer&) = delete;

 private:
  Cost& part_;
  Stopwatch stopwatch_;
};

}  // namespace weft::sim
