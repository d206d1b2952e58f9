#include "sim/run/recorded_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <limits>

#include "sim/accuracy/accuracy_pilot.h"
#include "sim/accuracy/error_monitor.h"
#include "sim/base/output_folder.h"
#include "sim/base/stopwatch.h"
#include "sim/case/case_checks.h"
#include "sim/case/frame_times.h"
#include "sim/motion/dynamics.h"
#include "sim/probes/outputs.h"
#include "sim/run/initial_state.h"
#include "sim/run/output_check.h"
#include "sim/scene/scene.h"
#include "sim/simulation/cpu_limit.h"
#include "sim/simulation/simulation.h"
#include "sim/trajectory/frame_recorder.h"

namespace weft::sim {

namespace {

constexpr double no_limit = std::numeric_limits<double>::infinity();

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// A run: steps the simulation and passes its states to the recorder.
class Run final : private StepObserver {
 public:
  Run(const Scene& scene, const RunOptions& options)
      : scene_(scene), options_(options), simulation_(scene), frame_times_(scene.source) {
    refuse_bad_outputs();
    recorder_.emplace(simulation_, in_output_folder(options.trajectory), options.force,
                      report_.bill.record, more_series());
    simulation_.add_observer(*this);
    if (!options.estimate_error) return;
    const CostTimer timer(report_.bill.error_estimate);
    monitor_.emplace(scene, options.stop_signal);
  }

  // Runs the case and returns the report. `started` was started before the set-up.
  RunReport execute(const Stopwatch& started) {
    setup_ = started.elapsed() - report_.bill.error_estimate;
    say_start();
    report_.trajectory = options_.trajectory;
    if (frame_times_.at(0) == 0.0) record_next(simulation_.state());
    cpu_limit_.emplace(scene_.source.compute.cpu_limit.value_or(no_limit));
    cpu_limit_->exclude(-options_.earlier.pilot.cpu);
    simulation_.set_reason_to_stop([this] { return reason_to_stop(); });
    // The first step may take as long as the set-up did. Waiting frames are committed now if they
    // would otherwise wait too long.
    recorder_->commit_before_pause(started.elapsed().wall);
    integrate();
    recorder_->commit();
    recorder_->check_in_place();
    fill_report();
    settle(started);
    recorder_->finish({status_name(report_.status), report_.reason, report_.bill});
    close_file();
    evaluate();
    settle(started);
    report_.statistics = simulation_.statistics();
    return report_;
  }

 private:
  void say_start() {
    say(scene_.source.accuracy_choice);
    say(long_step_notice(scene_.source.time));
    say(late_pins_notice(scene_.source));
    report_.compute = simulation_.compute();
    if (!report_.compute.empty()) say("contact search on " + report_.compute);
    say(simulation_.decision());
  }
  void say(const std::string& text) const {
    if (options_.notice && !text.empty()) options_.notice(text);
  }
  void fill_report() {
    const bool failed = report_.status == RunReport::Status::failed;
    report_.simulated_time =
        failed ? last_recorded_ : std::min(simulation_.time(), scene_.source.time.duration);
    report_.frames = recorder_->frames();
    report_.energies = recorder_->energies();
    report_.counts = simulation_.counts();
    report_.compute = simulation_.compute();
    report_.decision = simulation_.decision();
    if (monitor_) report_.error_estimate = monitor_->estimate();
  }

  void after_step(const Simulation& simulation) override {
    const auto gap = simulation.smallest_gap();
    if (gap) report_.smallest_gap = std::min(report_.smallest_gap.value_or(*gap), *gap);
    recorder_->add_step(simulation);
  }
  void after_decision(const std::string& text) override { say(text); }

  void close_file() {
    const CostTimer cost(report_.bill.record);
    const PhaseTimer timer(simulation_.dynamics().statistics().phases.record);
    recorder_.reset();
  }

  void refuse_bad_outputs() const {
    const auto& outputs = scene_.source.outputs;
    if (!outputs.empty()) check_outputs(outputs, recorded_contents(simulation_, more_series()));
  }

  // Evaluates the outputs from the file.
  void evaluate() {
    if (scene_.source.outputs.empty()) return;
    const CostTimer cost(report_.bill.record);
    report_.outputs =
        evaluate_outputs(scene_.source.outputs, TrajectoryReader(options_.trajectory));
  }

  // Sets all parts of the bill. The cost of the run is the total cost less all other parts.
  void settle(const Stopwatch& started) {
    Bill& bill = report_.bill;
    const Cost here = started.elapsed();
    bill.run = here - setup_ - bill.record - bill.error_estimate;
    bill.setup = setup_ + options_.earlier.setup;
    bill.pilot = options_.earlier.pilot;
    bill.total = here + options_.earlier.total;
  }

  std::vector<TrajectoryWriter::Series> more_series() const {
    if (!options_.estimate_error) return {};
    return error_series(scene_);
  }

  void record(double time, std::span<const double> y) {
    const auto errors = monitor_ ? compare(time, y) : std::span<const double>{};
    const double stretch = recorder_->add_frame(time, y, simulation_.counts(), errors);
    report_.largest_stretch = std::max(report_.largest_stretch, stretch);
    last_recorded_ = time;
  }

  // Records the state `y` as the next frame of the case.
  void record_next(std::span<const double> y) {
    record(*frame_times_.at(next_frame_), y);
    ++next_frame_;
  }

  // Records the frames up to the end of the last step. `memory` is work memory for interpolated
  // states.
  std::optional<Failure> record_frames(std::vector<double>& memory) {
    for (auto time = frame_times_.at(next_frame_); time && *time <= simulation_.time();
         time = frame_times_.at(next_frame_)) {
      if (auto failure = simulation_.state_at(*time, memory)) return failure;
      record_next(memory);
    }
    return std::nullopt;
  }

  // Compares the state with that of the second, more exact run, and returns the errors. The cost is
  // counted as that of the error estimate, and does not count towards compute.cpu_limit.
  std::span<const double> compare(double time, std::span<const double> y) {
    const Stopwatch stopwatch;
    const auto errors = monitor_->compare(time, y);
    const Cost cost = stopwatch.elapsed();
    report_.bill.error_estimate += cost;
    if (cpu_limit_) cpu_limit_->exclude(cost.cpu);
    return errors;
  }

  void integrate() {
    std::vector<double> interpolated(simulation_.state().size());
    const double duration = scene_.source.time.duration;
    auto last_look = std::chrono::steady_clock::now();
    while (simulation_.time() < duration && !simulation_.has_ended()) {
      if (is_interrupted()) return interrupt();
      if (const auto failure = simulation_.step()) return end_with(*failure);
      if (const auto failure = record_frames(interpolated)) return fail(*failure);
      // The next step may take as long as this one did. Waiting frames are committed now if they
      // would otherwise wait too long.
      recorder_->commit_before_pause(seconds_since(last_look));
      last_look = std::chrono::steady_clock::now();
      if (options_.progress) options_.progress(std::min(simulation_.time(), duration));
      if (simulation_.time() < duration && cpu_limit_->is_passed())
        return fail_with_last_state(cpu_limit_->failure(simulation_));
    }
  }

  bool is_interrupted() const {
    return options_.stop_signal != nullptr && *options_.stop_signal != 0;
  }
  std::optional<Failure> reason_to_stop() {
    if (is_interrupted())
      return Failure{Failure::Kind::interrupted, simulation_.time(), -1, "interrupted"};
    if (cpu_limit_->is_passed()) return cpu_limit_->failure(simulation_);
    return std::nullopt;
  }

  // Ends the run after a step that returned a failure.
  void end_with(const Failure& failure) {
    if (failure.kind == Failure::Kind::interrupted) return interrupt();
    // The state after a failure of energy is wrong. The last frame is the last good state.
    if (failure.kind == Failure::Kind::energy) return fail(failure);
    fail_with_last_state(failure);
  }
  void interrupt() {
    report_.status = RunReport::Status::interrupted;
    report_.reason = reason_of_signal(*options_.stop_signal);
  }
  void fail(const Failure& failure) {
    report_.status = RunReport::Status::failed;
    report_.reason = failure.text;
    report_.failure = failure;
  }
  // Ends the run with a failure, and records the last good state as an additional frame unless it
  // is recorded already.
  void fail_with_last_state(const Failure& failure) {
    fail(failure);
    if (simulation_.time() > last_recorded_) record(simulation_.time(), simulation_.state());
  }

  const Scene& scene_;
  const RunOptions& options_;
  RunReport report_;
  Simulation simulation_;
  std::optional<FrameRecorder> recorder_;
  std::optional<ErrorMonitor> monitor_;
  std::optional<CpuLimit> cpu_limit_;
  Cost setup_;  // cost of the set-up, without RunOptions::earlier
  FrameTimes frame_times_;
  long next_frame_ = 0;
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

RunReport ended_by_pilot(const PilotReport& pilot, const Bill& bill,
                         const std::atomic<int>* stop_signal) {
  RunReport report;
  report.bill = bill;
  if (pilot.interrupted) {
    report.status = RunReport::Status::interrupted;
    report.reason = reason_of_signal(*stop_signal);
    return report;
  }
  report.status = RunReport::Status::failed;
  report.reason = pilot.limit_reason;
  report.failure = Failure{Failure::Kind::cpu_limit, 0, -1, pilot.limit_reason};
  return report;
}

RunReport run_simulation(Case source, const RunOptions& options) {
  const Stopwatch started;
  const PilotReport pilot =
      correct_accuracy(source, {options.notice, options.progress, options.stop_signal});
  RunOptions run = options;
  run.earlier.pilot += pilot.cost;
  const auto note_setup = [&] {
    const Cost elapsed = started.elapsed();
    run.earlier.total = options.earlier.total + elapsed;
    run.earlier.setup = options.earlier.setup + (elapsed - pilot.cost);
  };
  note_setup();
  if (pilot.ended_run()) return ended_by_pilot(pilot, run.earlier, options.stop_signal);
  const auto scene = build_scene(source);
  note_setup();
  return run_simulation(*scene, run);
}

RunReport run_simulation(const Scene& scene, const RunOptions& options) {
  const Stopwatch started;
  // Faults of the case are reported before any file is written.
  check_initial_state(scene);
  return Run(scene, options).execute(started);
}

}  // namespace weft::sim
