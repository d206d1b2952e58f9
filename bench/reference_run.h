// Converged runs that others are judged by.
#pragma once

#include <vector>

#include "bench/timed_run.h"

namespace weft::bench {

struct ReferenceOptions {
  double tolerance = 1e-8;  // m, of the positions
  double certainty = 1e-6;  // m: where the two references part by more, the horizon ends
  double budget = 600;      // s of CPU time of each
};

// Up to the horizon, two methods agree within `certainty`; what lies beyond is chaos, not error.
struct Reference {
  std::vector<double> times;  // at which the two were compared, s: all that were asked for
  std::vector<std::vector<sim::Vec3>> positions;  // by time up to the horizon, then by particle, m
  double agreement = 0;                           // m, the worst up to the horizon
  double horizon = 0;                             // s
};

// Runs the case with two methods of different kinds, both far more exact than what is measured, and
// compares them at `times` (s, increasing, > 0). Says on standard error why one did not end.
Reference find_reference(const sim::Case& source, std::vector<double> times,
                         const ReferenceOptions& options);

// `count` times, equally far apart, the last at `end` (s).
std::vector<double> sample_times(double end, int count);

// The method with its tolerances for positions (m) and, in proportion, for speeds.
void set_tolerance(sim::TimeCase& time, sim::TimeMethod method, double tolerance);

}  // namespace weft::bench
