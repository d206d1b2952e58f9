// One simulation, timed, without a trajectory file.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim/integrator/integrator.h"

namespace weft::bench {

struct TimedRun {
  std::string failure;  // empty: reached the last time
  double cpu = 0;       // s, of the whole process, without setting up the scene
  sim::IntegratorCounts counts;
  // Positions of the dynamic particles (m) at each time that was reached.
  std::vector<std::vector<sim::Vec3>> positions;
  // Energies at the start, and at the end of the step that reached each time.
  std::vector<sim::Energies> energies;
};

// Simulates from t = 0 to the last of `times` (s, increasing, > 0). Fails after more CPU time than
// `budget` (s).
TimedRun simulate(const sim::Case& source, std::span<const double> times, double budget);

}  // namespace weft::bench
