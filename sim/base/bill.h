// The cost of a run and of its parts.
#pragma once

namespace weft::sim {

struct Cost {
  double wall = 0;  // wall time, s
  double cpu = 0;   // CPU time of all threads of the process, s

  Cost& operator+=(const Cost& other) {
    wall += other.wall;
    cpu += other.cpu;
    return *this;
  }
  friend Cost operator+(Cost a, const Cost& b) { return a += b; }
  friend Cost operator-(const Cost& a, const Cost& b) { return {a.wall - b.wall, a.cpu - b.cpu}; }
};

// The costs of the parts of a run. The parts do not overlap, and their sum is the total.
struct Bill {
  Cost setup;           // reading the case; making the scene, the integrator and the trajectory
  Cost pilot;           // pilot runs that correct time.accuracy
  Cost run;             // time integration; energies of steps and frames
  Cost record;          // gathering frames and writing the trajectory
  Cost error_estimate;  // the second, more exact run of the error estimate
  Cost total;
};

// A cost of the bill and the prefix of its names in JSON and in the trajectory. For example, the
// prefix "setup_" gives the names setup_wall_s and setup_cpu_s.
struct BillPart {
  const char* prefix;
  Cost Bill::*cost;
};
inline constexpr BillPart bill_parts[] = {
    {"", &Bill::total},   {"setup_", &Bill::setup},   {"pilot_", &Bill::pilot},
    {"run_", &Bill::run}, {"record_", &Bill::record}, {"error_estimate_", &Bill::error_estimate}};

}  // namespace weft::sim
