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

// The parts do not overlap. The total is measured separately and may slightly exceed their sum.
struct Bill {
  Cost setup;           // reading the case, the scene, the integrator, the file
  Cost pilot;           // of time.accuracy
  Cost run;             // steps and frames, with the energies of both
  Cost record;          // gathering frames and writing the file
  Cost error_estimate;  // the second run, beside this one
  Cost total;
};

// Names of the parts: each prefix is completed by wall_s or cpu_s, in JSON and in the file.
struct BillPart {
  const char* prefix;
  Cost Bill::*cost;
};
inline constexpr BillPart bill_parts[] = {
    {"", &Bill::total},   {"setup_", &Bill::setup},   {"pilot_", &Bill::pilot},
    {"run_", &Bill::run}, {"record_", &Bill::record}, {"error_estimate_", &Bill::error_estimate}};

}  // namespace weft::sim
