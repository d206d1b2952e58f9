#include "bench/reference_run.h"

#include <algorithm>
#include <cstdio>

#include "sim/accuracy/error_monitor.h"

namespace weft::bench {

using namespace sim;

void set_tolerance(TimeCase& time, TimeMethod method, double tolerance) {
  time.method = method;
  time.position_tolerance = tolerance;
  time.relative_tolerance = std::min(0.1, 10 * tolerance);
}

std::vector<double> sample_times(double end, int count) {
  std::vector<double> times;
  for (int i = 1; i <= count; ++i) times.push_back(end * i / count);
  return times;
}

Reference find_reference(const Case& source, std::vector<double> times,
                         const ReferenceOptions& options) {
  Reference reference;
  reference.times = std::move(times);
  const auto run = [&](TimeMethod method) {
    Case exact = source;
    set_tolerance(exact.time, method, options.tolerance);
    TimedRun result = simulate(exact, reference.times, options.budget);
    if (!result.failure.empty()) std::fprintf(stderr, "reference: %s\n", result.failure.c_str());
    return result;
  };
  const TimedRun one = run(TimeMethod::arkode);
  const TimedRun other = run(TimeMethod::cvode);
  const std::size_t reached = std::min(one.positions.size(), other.positions.size());
  for (std::size_t i = 0; i < reached; ++i) {
    const double apart = rms_distance(one.positions[i], other.positions[i]);
    if (!(apart <= options.certainty)) break;  // NaN, too
    reference.horizon = reference.times[i];
    reference.agreement = std::max(reference.agreement, apart);
    reference.positions.push_back(one.positions[i]);
  }
  return reference;
}

}  // namespace weft::bench
