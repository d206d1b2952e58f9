// The bill of a run: what each part of it costs.
#pragma once

#include <chrono>

#include "sim/base/process_time.h"

namespace weft::sim {

struct Cost {
  double wall = 0;  // s
  double cpu = 0;   // s, all threads of the process

  Cost& operator+=(const Cost& other) {
    wall += other.wall;
    cpu += other.cpu;
    return *this;
  }
  friend Cost operator+(Cost a, const Cost& b) { return a += b; }
  friend Cost operator-(const Cost& a, const Cost& b) { return {a.wall - b.wall, a.cpu - b.cpu}; }
};

// No second is in two parts. The total is measured by itself, and may be a little more than its
// parts.
struct Bill {
  Cost setup;           // reading the case, the scene, the integrator, the file
  Cost pilot;           // of time.accuracy
  Cost run;             // steps and frames, with the energies of both
  Cost record;          // gathering frames and writing the file
  Cost error_estimate;  // the second run, beside this one
  Cost total;
};

// Each part has a prefix; wall_s or cpu_s completes its name in JSON and in the file.
struct BillPart {
  const char* prefix;
  Cost Bill::*cost;
};
inline constexpr BillPart bill_parts[] = {
    {"", &Bill::total},   {"setup_", &Bill::setup},   {"pilot_", &Bill::pilot},
    {"run_", &Bill::run}, {"record_", &Bill::record}, {"error_estimate_", &Bill::error_estimate}};

// Measures the cost since it was made.
class Stopwatch {
 public:
  Stopwatch() : Stopwatch(std::chrono::steady_clock::now(), process_cpu_time()) {}
  // Starts when the process did. Loading it is taken to last as long as its CPU time.
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
  double cpu_start_;  // s
};

// Adds the cost from its making to its end to one part.
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
