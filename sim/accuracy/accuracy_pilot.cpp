#include "sim/accuracy/accuracy_pilot.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <limits>
#include <optional>

#include "sim/accuracy/accuracy_choice.h"
#include "sim/accuracy/error_monitor.h"
#include "sim/base/stopwatch.h"
#include "sim/case/case_checks.h"
#include "sim/case/case_writer.h"
#include "sim/case/time_methods.h"
#include "sim/integrator/verlet_steps.h"
#include "sim/motion/spectral_estimate.h"
#include "sim/motion/work.h"
#include "sim/simulation/cpu_limit.h"
#include "sim/simulation/simulation.h"

namespace weft::sim {

namespace {

constexpr double looser = 16;  // ratio of the tolerances of the two runs that are compared
// Loosest tolerance of the two runs that are compared (m). At looser tolerances, the error does not
// grow smoothly with the tolerance.
constexpr double loosest_pilot = 2e-5;
constexpr int samples = 20;  // number of times at which the two runs are compared
// Largest number of pairs of runs. If a run fails, the next pair has tolerances smaller by the
// factor `looser`.
constexpr int most_pairs = 3;
// Factor by which a tolerance decreases after a run with it fails.
constexpr double retreat = 0.25;

TimeCase with_tolerance(const TimeCase& time, double tolerance) {
  TimeCase result = time;
  result.position_tolerance = tolerance;
  result.relative_tolerance = std::min(0.1, 10 * tolerance);
  return result;
}

TimeCase with_verlet(const TimeCase& time, double share) {
  const double tolerance = verlet_tolerance(share);
  TimeCase result = with_tolerance(time, tolerance / 10);
  result.method = TimeMethod::verlet;
  result.relative_tolerance = tolerance;
  return result;
}

template <class... Numbers>
std::string formatted(const char* format, Numbers... numbers) {
  char text[400];
  std::snprintf(text, sizeof text, format, numbers...);
  return text;
}

std::unique_ptr<const Scene> scene_with(const Case& target, const TimeCase& time) {
  Case source = target;
  source.time = time;
  return build_scene(source);
}

// The RMS distance between two runs: its largest value over all bodies and sampled times.
struct Distance {
  double largest = 0;                 // m
  std::optional<double> parted_time;  // from this time (s), distances do not measure errors
};

class Pilot {
 public:
  Pilot(Case& target, const PilotOptions& options)
      : target_(target),
        options_(options),
        limit_(target.compute.cpu_limit.value_or(std::numeric_limits<double>::infinity())) {}

  PilotReport execute() {
    const Case before = target_;
    correct();
    if (stopped()) target_ = before;
    report_.cost = stopwatch_.elapsed();
    return report_;
  }

 private:
  void correct();
  bool choose_verlet(const TimeCase& loose);
  bool is_dearer_than_verlet(const TimeCase& time);
  std::optional<Distance> distance(const TimeCase& loose, const TimeCase& tight);
  void correct_by(const Distance& apart, double loose);
  double make_sure(double wanted, double succeeded);
  bool fails(const TimeCase& time);

  double duration() const { return target_.time.duration; }
  bool stopped() const { return report_.ended_run(); }
  // Returns true if the stop signal or the CPU limit must end the pilot after this step of `run`.
  // Records the reason in the report.
  bool is_stopped_at(const Simulation& run) {
    if (options_.stop_signal != nullptr && *options_.stop_signal != 0) report_.interrupted = true;
    if (!report_.interrupted && limit_.is_passed())
      report_.limit_reason = "in the pilot run of time.accuracy: " + limit_.failure(run).text;
    return stopped();
  }
  // Reports the progress of a run. Returns true if the run may continue.
  bool goes_on(const Simulation& run) {
    if (options_.progress) options_.progress(std::min(run.time(), duration()));
    return !is_stopped_at(run);
  }
  void say(const std::string& text) const {
    if (options_.notice) options_.notice(text);
  }

  Case& target_;
  const PilotOptions& options_;
  CpuLimit limit_;
  Stopwatch stopwatch_;
  PilotReport report_;
  std::optional<Failure> failure_;  // failure that ended the last pair of runs, if any
};

// Makes two runs with these options and measures their distance. Returns nothing if one of them
// fails or is stopped.
std::optional<Distance> Pilot::distance(const TimeCase& loose, const TimeCase& tight) {
  Simulation run(scene_with(target_, loose));
  ErrorMonitor monitor(run.scene(), tight,
                       [&](const Simulation& second) { return !goes_on(second); });
  std::vector<double> y(run.state().size());
  for (int i = 1; i <= samples; ++i) {
    const double time = duration() * i / samples;
    while (run.time() < time) {
      failure_ = run.step();
      if (failure_ || is_stopped_at(run)) return std::nullopt;
    }
    failure_ = run.state_at(time, y);
    if (failure_) return std::nullopt;
    monitor.compare(time, y);
    if (stopped()) return std::nullopt;
  }
  const ErrorEstimate estimate = monitor.estimate();
  if (!estimate.failure.empty()) {
    failure_.emplace().text = estimate.failure;
    return std::nullopt;
  }
  const double largest =
      std::ranges::max_element(estimate.bodies, {}, &BodyError::largest)->largest;
  return Distance{largest, estimate.parted_time};
}

// Makes a run with these options. Returns true if it fails, and false if it succeeds or is stopped.
bool Pilot::fails(const TimeCase& time) {
  Simulation run(scene_with(target_, time));
  while (run.time() < duration()) {
    if (run.step()) return true;
    if (!goes_on(run)) return false;
  }
  return false;
}

// Makes a run with these options. Returns true as soon as it has taken more work than a whole run
// of verlet would. Returns false if it ends before, also if it fails or is stopped.
bool Pilot::is_dearer_than_verlet(const TimeCase& time) {
  const auto scene = scene_with(target_, time);
  Statistics statistics;
  Dynamics dynamics(*scene, statistics);
  const SpectralEstimate fastest = estimate_spectrum(dynamics, 0, dynamics.initial_state());
  const double rate = verlet_rate(fastest.frequency, fastest.decay);
  const double limit = dynamics.evaluation_work() * verlet_evaluations(rate, duration());
  Simulation run(*scene);
  while (run.time() < duration()) {
    if (run.step() || !goes_on(run)) return false;
    if (work_of(run.dynamics(), run.counts().linear_iterations) > limit) return true;
  }
  return false;
}

// Chooses verlet if it is accurate enough and takes less work than the run of `loose`. Returns true
// if verlet is chosen. The error of verlet is proportional to the square of the step. Runs with the
// whole step and half of it therefore differ by 3/4 of the error with the whole step.
bool Pilot::choose_verlet(const TimeCase& loose) {
  if (target_.method_given || target_.contact.enabled) return false;
  // Near a strain limit the membrane is stiffer than at the start, where the steps of verlet are
  // judged.
  if (std::ranges::any_of(target_.material, [](const MaterialCase& material) {
        return material.strain_limit.has_value();
      })) {
    return false;
  }
  say(formatted("pilot of time.accuracy: does verlet take less work than %s?",
                traits_of(target_.time.method).name));
  if (!is_dearer_than_verlet(loose)) return false;
  say("pilot of time.accuracy: runs of verlet with its longest steps and half of them");
  const TimeCase verlet = with_verlet(target_.time, longest_verlet_share);
  const auto apart = distance(verlet, with_verlet(target_.time, longest_verlet_share / 2));
  if (!apart || apart->largest == 0 || apart->largest * 4 / 3 > *target_.time.accuracy)
    return false;
  target_.accuracy_choice = formatted(
      "verlet with steps of %.2g of the longest stable one for an accuracy of %.3g m "
      "over %.3g s, less work than %s; a pilot run finds an error of %.2g m",
      longest_verlet_share, *target_.time.accuracy, duration(), traits_of(target_.time.method).name,
      apart->largest * 4 / 3);
  target_.time = verlet;
  return true;
}

void Pilot::correct() {
  const double first = target_.time.position_tolerance;
  double loose = std::min({looser * first, loosest_pilot, position_tolerance_limit(target_)});
  if (!choose_verlet(with_tolerance(target_.time, loose)) && !stopped()) {
    std::optional<Distance> apart;
    for (int pair = 0; pair < most_pairs && !apart && !stopped(); ++pair) {
      if (pair > 0) loose /= looser;
      say(formatted("pilot of time.accuracy: runs with position_tolerance %.3g and %.3g m", loose,
                    loose / looser));
      apart = distance(with_tolerance(target_.time, loose),
                       with_tolerance(target_.time, loose / looser));
    }
    if (!apart) {
      target_.accuracy_choice +=
          "; no pilot run succeeded: " + (failure_ ? failure_->text : "stopped");
    } else if (apart->largest == 0) {
      target_.accuracy_choice += "; a pilot run finds no error";
    } else {
      correct_by(*apart, loose);
    }
  }
  target_.resolved_text = case_text(target_);
}

// Corrects the tolerance of the case. `apart` is the distance between the runs with the tolerances
// `loose` and loose / looser.
void Pilot::correct_by(const Distance& apart, double loose) {
  const double tight = loose / looser;
  const double expected =
      duration() * (error_rate_at(target_, loose) - error_rate_at(target_, tight));
  const double factor = apart.largest / expected;
  const double wanted = tolerance_at(target_, *target_.time.accuracy / (factor * duration()));
  if (apart.parted_time && wanted < tight) {
    const double kept = make_sure(target_.time.position_tolerance, loose);
    target_.accuracy_choice += formatted(
        "; chaotic: this accuracy cannot be had: from t = %.3g s on, two pilot runs are "
        "further apart than a tenth of the motion or size, %.2g m at the most; "
        "position_tolerance %.3g m, by the calibration alone, for the time before",
        *apart.parted_time, apart.largest, kept);
    return;
  }
  const double kept = make_sure(wanted, loose);
  target_.accuracy_choice += formatted(
      "; a pilot run finds %.2g times the usual errors: position_tolerance %.3g m", factor, kept);
  if (kept < wanted)
    target_.accuracy_choice += formatted(", since a run with %.3g m fails", wanted);
}

// Sets and returns the tolerance of the case. This is `wanted`, or a smaller tolerance if runs
// fail. Tolerances up to `succeeded` need no run, because the run with `succeeded` has succeeded.
// If a run with a larger tolerance fails, smaller tolerances down to `succeeded` are tried.
double Pilot::make_sure(double wanted, double succeeded) {
  double tolerance = wanted;
  for (; tolerance > succeeded && !stopped();
       tolerance = std::max(succeeded, retreat * tolerance)) {
    say(formatted("pilot of time.accuracy: a run with position_tolerance %.3g m", tolerance));
    if (!fails(with_tolerance(target_.time, tolerance))) break;
  }
  target_.time = with_tolerance(target_.time, tolerance);
  return tolerance;
}

}  // namespace

PilotReport correct_accuracy(Case& target, const PilotOptions& options) {
  choose_accuracy(target);
  if (!has_chosen_tolerance(target)) return {};
  return Pilot(target, options).execute();
}

}  // namespace weft::sim
