#include "sim/accuracy_pilot.h"

#include <algorithm>
#include <cstdio>
#include <optional>

#include "sim/case/accuracy_choice.h"
#include "sim/case/case_checks.h"
#include "sim/case/case_writer.h"
#include "sim/error_estimate.h"
#include "sim/integrator/spectral_estimate.h"
#include "sim/integrator/verlet_steps.h"
#include "sim/integrator/work.h"
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
    if (integrator->state_at(time, y)) return std::nullopt;
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

// Whether the run of this scene takes more work than all steps of verlet.
bool is_dearer_than_verlet(const Scene& scene) {
  Statistics statistics;
  Dynamics dynamics(scene, statistics);
  const std::vector<double> start = dynamics.initial_state();
  const double rate = estimate_spectrum(dynamics, 0, start).stiffest();
  const double limit =
      evaluation_work(scene) * verlet_evaluations(rate, scene.source.time.duration);
  statistics = {};
  const auto integrator = make_integrator(scene, dynamics);
  while (integrator->time() < scene.source.time.duration) {
    if (integrator->step()) return false;
    const double work = work_of(scene, statistics.counters, integrator->counts().linear_iterations);
    if (work > limit) return true;
  }
  return false;
}

const char* name_of(TimeMethod method) {
  return std::ranges::find(calibrated_methods(), method, &CalibratedMethod::method)->name;
}

TimeCase with_verlet(const TimeCase& time, double share) {
  const double tolerance = verlet_tolerance(share);
  TimeCase result = with_tolerance(time, tolerance / 10);
  result.method = TimeMethod::verlet;
  result.relative_tolerance = tolerance;
  return result;
}

// Whether verlet does, and is cheaper than the run of `loose`. Its error goes as the square of its
// steps: that of steps half as long is a quarter.
bool choose_verlet(Case& target, const Case& loose) {
  if (!target.accuracy_chooses_method || target.contact.enabled) return false;
  if (!is_dearer_than_verlet(*build_scene(loose))) return false;
  const double start = process_cpu_time();
  Case pilot = target;
  pilot.time = with_verlet(target.time, longest_verlet_share);
  const auto apart =
      distance(*build_scene(pilot), with_verlet(target.time, longest_verlet_share / 2));
  if (!apart || *apart * 4 / 3 > *target.time.accuracy) return false;
  char text[256];
  std::snprintf(text, sizeof text,
                "verlet with steps of %.2g of the longest stable one for an accuracy of %.3g m "
                "over %.3g s, less work than %s; a pilot run of %.2g s of CPU finds an error of "
                "%.2g m",
                longest_verlet_share, *target.time.accuracy, target.time.duration,
                name_of(target.time.method), process_cpu_time() - start, *apart * 4 / 3);
  target.accuracy_choice = text;
  target.time = pilot.time;
  target.resolved_text = case_text(target);
  return true;
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
  if (choose_verlet(target, pilot)) return;
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
