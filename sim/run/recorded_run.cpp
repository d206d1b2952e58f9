#include "sim/run/recorded_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <limits>

#include "sim/case/case_checks.h"
#include "sim/motion/energy_watch.h"
#include "sim/run/initial_state.h"
#include "sim/simulation/cpu_limit.h"
#include "sim/trajectory/frame_recorder.h"

namespace weft::sim {

namespace {

constexpr double no_limit = std::numeric_limits<double>::infinity();

// The path, with its folder made where it is missing: once all else is ready, since what is wrong
// with a case must leave nothing behind.
std::string in_folder(const std::string& path) {
  const auto folder = std::filesystem::path(path).parent_path();
  std::error_code error;
  if (!folder.empty()) std::filesystem::create_directories(folder, error);
  if (error) throw FileError(folder.string() + ": cannot create: " + error.message());
  return path;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Steps the integrator and hands its states to the recorder.
class Run {
 public:
  Run(const Scene& scene, const RunOptions& options)
      : scene_(scene),
        options_(options),
        dynamics_(scene, report_.statistics),
        integrator_(make_integrator(scene, dynamics_)),
        recorder_(std::in_place, scene, dynamics_, in_folder(options.trajectory), options.force,
                  report_.bill.record, error_series()),
        energy_watch_(dynamics_, integrator_->state()) {
    if (!options.estimate_error) return;
    const CostTimer timer(report_.bill.error_estimate);
    monitor_.emplace(scene, options.stop_signal);
  }

  // `started` was made before the set-up.
  RunReport execute(const Stopwatch& started) {
    setup_ = started.elapsed() - report_.bill.error_estimate;
    if (options_.notice && !scene_.source.accuracy_choice.empty()) {
      options_.notice(scene_.source.accuracy_choice);
    }
    const std::string long_step = long_step_notice(scene_.source.time);
    if (options_.notice && !long_step.empty()) options_.notice(long_step);
    note_compute();
    note_decision();
    report_.trajectory = options_.trajectory;
    record(0.0, integrator_->state());
    cpu_limit_.emplace(scene_.source.compute.cpu_limit.value_or(no_limit));
    cpu_limit_->exclude(-options_.earlier.pilot.cpu);
    integrator_->set_reason_to_stop([this] { return reason_to_stop(); });
    // The first step may take as long as the set-up.
    recorder_->commit_before_pause(started.elapsed().wall);
    integrate();
    recorder_->commit();
    recorder_->check_in_place();
    const bool failed = report_.status == RunReport::Status::failed;
    report_.simulated_time =
        failed ? last_recorded_ : std::min(integrator_->time(), scene_.source.time.duration);
    report_.frames = recorder_->frames();
    report_.energies = recorder_->energies();
    report_.counts = integrator_->counts();
    note_compute();
    if (monitor_) report_.error_estimate = monitor_->estimate();
    settle(started);
    recorder_->finish({status_name(report_.status), report_.reason, report_.bill});
    close_file();
    settle(started);
    return report_;
  }

 private:
  void close_file() {
    const CostTimer cost(report_.bill.record);
    const PhaseTimer timer(report_.statistics.phases.record);
    recorder_.reset();
  }

  // Makes the bill whole: the run is what is not another part.
  void settle(const Stopwatch& started) {
    Bill& bill = report_.bill;
    const Cost here = started.elapsed();
    bill.run = here - setup_ - bill.record - bill.error_estimate;
    bill.setup = setup_ + options_.earlier.setup;
    bill.pilot = options_.earlier.pilot;
    bill.total = here + options_.earlier.total;
  }

  // Frame times are multiples of the interval; the end of the run is always a frame.
  double frame_time(long frame) const {
    return std::min(static_cast<double>(frame) / scene_.source.time.frames_per_second,
                    scene_.source.time.duration);
  }

  std::vector<TrajectoryWriter::Series> error_series() const {
    std::vector<TrajectoryWriter::Series> series;
    for (const SceneBody& body : scene_.bodies) {
      if (body.dynamic && options_.estimate_error) {
        series.push_back({"error_estimate_" + body.name, "m"});
      }
    }
    return series;
  }

  void record(double time, std::span<const double> y) {
    const auto errors = monitor_ ? compare(time, y) : std::span<const double>{};
    const double stretch = recorder_->add_frame(time, y, integrator_->counts(), errors);
    report_.largest_stretch = std::max(report_.largest_stretch, stretch);
    last_recorded_ = time;
  }

  // The cost of the second run is kept apart from that of this one.
  std::span<const double> compare(double time, std::span<const double> y) {
    const Stopwatch stopwatch;
    const auto errors = monitor_->compare(time, y);
    const Cost cost = stopwatch.elapsed();
    report_.bill.error_estimate += cost;
    if (cpu_limit_) cpu_limit_->exclude(cost.cpu);
    return errors;
  }

  void integrate() {
    std::vector<double> interpolated(dynamics_.state_size());
    const double duration = scene_.source.time.duration;
    auto last_look = std::chrono::steady_clock::now();
    for (long frame = 1; last_recorded_ < duration;) {
      if (is_interrupted()) return interrupt();
      if (const auto reason = integrator_->step())
        return left_a_step_ ? interrupt() : fail_with_last_state(*reason);
      note_gap();
      note_decision();
      // A step that is found wrong after it was taken leaves the last frame as the last good state.
      if (const auto reason = note_step()) return fail(*reason);
      for (; last_recorded_ < duration && frame_time(frame) <= integrator_->time(); ++frame) {
        if (const auto reason = integrator_->state_at(frame_time(frame), interpolated))
          return fail(*reason);
        record(frame_time(frame), interpolated);
      }
      // The next step may take as long as this one.
      recorder_->commit_before_pause(seconds_since(last_look));
      last_look = std::chrono::steady_clock::now();
      if (options_.progress) options_.progress(std::min(integrator_->time(), duration));
      if (last_recorded_ < duration && cpu_limit_->is_passed())
        return fail_with_last_state(cpu_limit_->reason(scene_, *integrator_));
    }
  }

  bool is_interrupted() const {
    return options_.stop_signal != nullptr && *options_.stop_signal != 0;
  }
  std::optional<std::string> reason_to_stop() {
    left_a_step_ = is_interrupted();
    if (left_a_step_) return "interrupted";
    if (cpu_limit_->is_passed()) return cpu_limit_->reason(scene_, *integrator_);
    return std::nullopt;
  }

  void interrupt() {
    report_.status = RunReport::Status::interrupted;
    report_.reason = reason_of_signal(*options_.stop_signal);
  }
  void fail(const std::string& reason) {
    report_.status = RunReport::Status::failed;
    report_.reason = reason;
  }
  // The last good state is kept as a frame of its own.
  void fail_with_last_state(const std::string& reason) {
    fail(reason);
    if (integrator_->time() > last_recorded_) record(integrator_->time(), integrator_->state());
  }

  // Records the step, or says what is wrong with it.
  std::optional<std::string> note_step() {
    const PhaseTimer timer(report_.statistics.phases.energies);
    const Energies energies =
        dynamics_.energies_at_last_rate(integrator_->time(), integrator_->state());
    recorder_->add_step(*integrator_, energies);
    return energy_watch_.check(integrator_->time(), integrator_->state(), energies);
  }

  void note_gap() {
    if (dynamics_.contact() == nullptr) return;
    const auto gap = dynamics_.contact()->smallest_gap();
    if (gap) report_.smallest_gap = std::min(report_.smallest_gap.value_or(*gap), *gap);
  }

  // At the start, and at the end if a device failed in between.
  void note_compute() {
    if (dynamics_.contact() == nullptr) return;
    const std::string text = dynamics_.contact()->compute().text();
    if (text == report_.compute) return;
    report_.compute = text;
    if (options_.notice) options_.notice("contact search on " + text);
  }

  // At the start, and whenever the integrator changes its mind.
  void note_decision() {
    std::string text = integrator_->decision();
    if (text == report_.decision) return;
    report_.decision = std::move(text);
    if (options_.notice) options_.notice(report_.decision);
  }

  const Scene& scene_;
  const RunOptions& options_;
  RunReport report_;
  Dynamics dynamics_;
  std::unique_ptr<Integrator> integrator_;
  std::optional<FrameRecorder> recorder_;
  EnergyWatch energy_watch_;
  std::optional<ErrorMonitor> monitor_;
  std::optional<CpuLimit> cpu_limit_;
  Cost setup_;                // of this run
  bool left_a_step_ = false;  // as it was interrupted
  double last_recorded_ = 0;
};

}  // namespace

const char* status_name(RunReport::Status status) {
  switch (status) {
    case RunReport::Status::done:
      return "done";
    case RunReport::Status::failed:
      return "failed";
    case RunReport::Status::interrupted:
      return "interrupted";
  }
  return "";
}

std::string reason_of_signal(int signal) {
  if (signal == SIGINT) return "stopped by Ctrl-C (SIGINT)";
  if (signal == SIGTERM) return "stopped by SIGTERM";
  return "stopped from outside";
}

RunReport run_simulation(const Scene& scene, const RunOptions& options) {
  const Stopwatch started;
  // Whatever is wrong with the case is said before anything is written.
  check_initial_state(scene);
  return Run(scene, options).execute(started);
}

}  // namespace weft::sim
