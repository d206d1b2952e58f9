#include "sim/accuracy_pilot.h"

#include <algorithm>
#include <cstdio>
#include <optional>

#include "sim/case/accuracy_choice.h"
#include "sim/case/case_checks.h"
#include "sim/case/case_writer.h"
#include "sim/error_estimate.h"
#include "sim/process_time.h"

namespace weft::sim {

namespace {

constexpr double looser = 16;
// m. Beyond it the curves of error against tolerance are rough.
constexpr double loosest_pilot = 2e-5;
constexpr int samples = 20;  // times at which the two runs are compared

// The largest distance of the two runs, m; nothing where one fails or no motion is.
std::optional<double> distance(const Scene& scene, const TimeCase& tight) {
  Statistics statistics;
  Dynamics dynamics(scene, statistics);
  const auto integrator = make_integrator(scene, dynamics);
  ErrorMonitor monitor(scene, tight, nullptr);
  std::vector<double> y(dynamics.state_size());
  for (int i = 1; i <= samples; ++i) {
    const double time = scene.source.time.duration * i / samples;
    while (integrator->time() < time) {
      if (integrator->step()) return std::nullopt;
    }
    integrator->state_at(time, y);
    monitor.compare(time, y);
  }
  const ErrorEstimate estimate = monitor.estimate();
  if (!estimate.failure.empty()) return std::nullopt;
  const double largest =
      std::ranges::max_element(estimate.bodies, {}, &BodyError::largest)->largest;
  return largest > 0 ? std::optional(largest) : std::nullopt;
}

TimeCase with_tolerance(const TimeCase& time, double tolerance) {
  TimeCase result = time;
  result.position_tolerance = tolerance;
  result.relative_tolerance = std::min(0.1, 10 * tolerance);
  return result;
}

}  // namespace

void correct_accuracy(Case& target) {
  if (!has_chosen_tolerance(target)) return;
  const double start = process_cpu_time();
  const double duration = target.time.duration;
  const double first = target.time.position_tolerance;
  const double loose = std::min({looser * first, loosest_pilot, position_tolerance_limit(target)});
  const double tight = loose / looser;
  Case pilot = target;
  pilot.time = with_tolerance(target.time, loose);
  const auto apart = distance(*build_scene(pilot), with_tolerance(target.time, tight));
  if (!apart) {
    target.accuracy_choice += "; a pilot run told nothing";
  } else {
    const double expected =
        duration * (error_rate_at(target, loose) - error_rate_at(target, tight));
    const double factor = *apart / expected;
    const double wanted = tolerance_at(target, *target.time.accuracy / (factor * duration));
    target.time = with_tolerance(target.time, wanted);
    char text[160];
    std::snprintf(text, sizeof text,
                  "; a pilot run of %.2g s of CPU finds %.2g times the usual errors: "
                  "position_tolerance %.3g m",
                  process_cpu_time() - start, factor, target.time.position_tolerance);
    target.accuracy_choice += text;
  }
  target.resolved_text = case_text(target);
}

}  // namespace weft::sim
