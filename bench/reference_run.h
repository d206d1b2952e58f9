// Converged runs, against which others are compared.
#pragma once

#include <vector>

#include "bench/timed_run.h"

namespace weft::bench {

struct ReferenceOptions {
  double tolerance = 1e-8;  // m, of the positions
  double certainty = 1e-6;  // m: distance of the two references at which the horizon ends
  double budget = 600;      // s of CPU time of each
};

// A converged run. Up to the horizon, two methods agree within `certainty`; beyond it the motion is
// chaotic.
struct Reference {
  std::vector<double> times;                      // all times of the comparison, s
  std::vector<std::vector<sim::Vec3>> positions;  // by time up to the horizon, then by particle, m
  double agreement = 0;                           // m, largest distance up to the horizon
  double horizon = 0;                             // s
};

// Runs the case with two methods of different kinds, both far more exact than the measured runs,
// and compares them at `times` (s, increasing, > 0). Reports on standard error why one did not
// finish.
Reference find_reference(const sim::Case& source, std::vector<double> times,
                         const ReferenceOptions& options);

// Returns `count` equidistant times, the last at `end` (s).
std::vector<double> sample_times(double end, int count);

// Sets the method, its tolerance for positions (m) and, in proportion, those for velocities.
void set_tolerance(sim::TimeCase& time, sim::TimeMethod method, double tolerance);

}  // namespace weft::bench
