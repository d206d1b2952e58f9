// The bill of a run: the cost of each of its parts.
#pragma once

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

// The parts do not overlap; their sum is the total.
struct Bill {
  Cost setup;           // reading the case; making the scene, the integrator and the file
  Cost pilot;           // pilot runs that correct time.accuracy
  Cost run;             // steps and frames, with the energies of both
  Cost record;          // gathering frames and writing the file
  Cost error_estimate;  // second, more exact run that the error estimate compares with
  Cost total;
};

// A part and the prefix of its names. "setup_" stands for setup_wall_s and setup_cpu_s, in JSON and
// in the trajectory.
struct BillPart {
  const char* prefix;
  Cost Bill::*cost;
};
inline constexpr BillPart bill_parts[] = {
    {"", &Bill::total},   {"setup_", &Bill::setup},   {"pilot_", &Bill::pilot},
    {"run_", &Bill::run}, {"record_", &Bill::record}, {"error_estimate_", &Bill::error_estimate}};

}  // namespace weft::sim
