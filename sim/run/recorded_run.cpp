#include "sim/run/recorded_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <limits>
#include <stdexcept>

#include "sim/accuracy/accuracy_pilot.h"
#include "sim/accuracy/error_monitor.h"
#include "sim/base/output_folder.h"
#include "sim/base/state_archive.h"
#include "sim/base/stopwatch.h"
#include "sim/case/case_checks.h"
#include "sim/case/case_text.h"
#include "sim/case/case_writer.h"
#include "sim/case/frame_times.h"
#include "sim/motion/dynamics.h"
#include "sim/probes/outputs.h"
#include "sim/run/initial_state.h"
#include "sim/run/output_check.h"
#include "sim/run/restart.h"
#include "sim/run/resumption.h"
#include "sim/run/run_checkpoint.h"
#include "sim/scene/recorded_bodies.h"
#include "sim/scene/scene.h"
#include "sim/simulation/cpu_limit.h"
#include "sim/simulation/simulation.h"
#include "sim/trajectory/frame_recorder.h"
#include "sim/trajectory/xdmf_file.h"

namespace weft::sim {

namespace {

constexpr double no_limit = std::numeric_limits<double>::infinity();

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Returns the sum of the costs of two runs.
Bill operator+(Bill sum, const Bill& more) {
  for (const BillPart& part : bill_parts) sum.*part.cost += more.*part.cost;
  return sum;
}

// A run: steps the simulation and passes its states to the recorder.
class Run final : private StepObserver {
 public:
  Run(const Scene& scene, const RunOptions& options, const Stopwatch& started)
      : scene_(scene),
        options_(options),
        started_(started),
        simulation_(scene),
        frame_times_(scene.source),
        checkpoint_(options.trajectory) {
    simulation_.add_observer(*this);
    if (options.estimate_error) {
      const CostTimer timer(estimate_cost_);
      monitor_.emplace(scene, options.stop_signal);
    }
    if (options.resumed != nullptr) restore(*options.resumed);
    if (was_complete()) return;
    refuse_bad_outputs();
    open_trajectory();
  }

  // Runs the case and returns the report. Begins with the first frame, or after the checkpoint.
  RunReport execute() {
    setup_ = started_.elapsed() - estimate_cost_ - record_cost_;
    say_start();
    report_.trajectory = options_.trajectory;
    if (was_complete()) return report_of_complete_run();
    if (options_.resumed == nullptr && frame_times_.at(0) == 0.0) record_next(simulation_.state());
    cpu_limit_.emplace(scene_.source.compute.cpu_limit.value_or(no_limit));
    cpu_limit_->exclude(-options_.earlier.pilot.cpu);
    simulation_.set_reason_to_stop([this] { return reason_to_stop(); });
    // The first step may take as long as the set-up did. Waiting frames are committed now if they
    // would otherwise wait too long.
    recorder_->commit_before_pause(started_.elapsed().wall);
    integrate();
    finish();
    return report_;
  }

 private:
  void say_start() {
    say(scene_.source.accuracy_choice);
    for (const std::string& text :
         {long_step_notice(scene_.source.time), late_pins_notice(scene_.source),
          idle_device_notice(scene_.source), rounding_notice(scene_),
          no_sidecar_notice(options_.trajectory)}) {
      if (options_.warning && !text.empty()) options_.warning(text);
    }
    report_.compute = simulation_.compute();
    if (!report_.compute.empty()) say("contact search on " + report_.compute);
    say(simulation_.decision());
    if (!report_.resumed_at) return;
    say(was_complete() ? options_.trajectory + " is complete"
                       : "goes on from the checkpoint at t = " + rounded_text(*report_.resumed_at) +
                             " s, after " + counted(options_.resumed->steps, "step", "steps"));
  }
  void say(const std::string& text) const {
    if (options_.notice && !text.empty()) options_.notice(text);
  }
  void fill_report() {
    const bool failed = report_.status == RunReport::Status::failed;
    report_.simulated_time =
        failed ? last_recorded_ : std::min(simulation_.time(), scene_.source.time.duration);
    report_.counts = simulation_.counts();
    report_.compute = simulation_.compute();
    report_.decision = simulation_.decision();
    if (monitor_) report_.error_estimate = monitor_->estimate();
    if (!recorder_) return;
    report_.frames = recorder_->frames();
    report_.energies = recorder_->energies();
  }

  // Commits all frames, and writes the end of the run and its last checkpoint.
  void finish() {
    recorder_->commit();
    recorder_->check_in_place();
    fill_report();
    report_.bill = bill();
    // A run that is killed once the file has its end needs a checkpoint to go on from.
    checkpoint_.write();
    const bool is_done = report_.status == RunReport::Status::done;
    if (is_done && !checkpoint_.has_written() && options_.resumed == nullptr) {
      checkpoint_.keep(checkpoint_of(simulation_.checkpoint()));
      checkpoint_.write();
    }
    recorder_->finish({status_name(report_.status), report_.reason, report_.bill});
    // The file must have its end before a checkpoint calls the run complete.
    if (is_done) {
      RunCheckpoint last = checkpoint_of(simulation_.checkpoint());
      last.is_complete = true;
      checkpoint_.keep(std::move(last));
    }
    checkpoint_.write();
    close_file();
    evaluate();
    report_.bill = bill();
    report_.statistics = simulation_.statistics();
  }

  // True if the run has ended before, with the same duration.
  bool was_complete() const {
    return options_.resumed != nullptr && options_.resumed->is_complete &&
           options_.resumed->time.duration == scene_.source.time.duration;
  }
  RunReport report_of_complete_run() {
    fill_report();
    report_.frames = options_.resumed->frames;
    report_.energies = options_.resumed->energies;
    report_.bill = options_.resumed->bill;
    report_.statistics = simulation_.statistics();
    evaluate();
    return report_;
  }

  // Makes the trajectory, with the frames up to the checkpoint. The checkpoint of another run,
  // which the file will not belong to, is removed before the file gets its name.
  void open_trajectory() {
    const bool replaces = options_.force || options_.resume || options_.resumed != nullptr;
    refuse_foreign_checkpoint(options_.trajectory, options_.force);
    if (!options_.force) TrajectoryWriter::refuse_foreign_sidecar(options_.trajectory);
    recorder_.emplace(simulation_, in_output_folder(options_.trajectory), replaces, record_cost_,
                      more_series());
    if (options_.resumed != nullptr) {
      recorder_->copy_earlier(options_.resumed->frames);
      read_checkpoint_part([&] {
        StateArchive archive(options_.resumed->recorder);
        recorder_->transfer(archive);
      });
    } else {
      remove_checkpoint(options_.trajectory);
    }
    recorder_->publish();
  }

  // Calls `read`, and throws FileError if the checkpoint does not fit the case.
  void read_checkpoint_part(const auto& read) const {
    try {
      read();
    } catch (const std::invalid_argument& error) {
      throw FileError(checkpoint_path(options_.trajectory) +
                      ": cannot be continued: " + error.what());
    }
  }

  void restore(const RunCheckpoint& from) {
    read_checkpoint_part([&] {
      simulation_.restore(from.simulation);
      if (monitor_) monitor_->restore(from.monitor);
    });
    report_.resumed_at = from.reached;
    report_.smallest_gap = from.smallest_gap;
    report_.largest_stretch = from.largest_stretch;
    last_recorded_ = from.last_frame_time;
    next_frame_ = static_cast<long>(from.next_frame);
    if (from.time.duration != scene_.source.time.duration) find_next_frame();
  }

  // Finds the first frame after the last one recorded, among those of a new duration.
  void find_next_frame() {
    next_frame_ = 0;
    for (auto time = frame_times_.at(0); time && *time <= last_recorded_;
         time = frame_times_.at(next_frame_))
      ++next_frame_;
  }

  // Returns the checkpoint of the run with the state `simulation` (Simulation::checkpoint()).
  RunCheckpoint checkpoint_of(std::string simulation) {
    RunCheckpoint now;
    now.case_text = options_.case_text.empty() ? motion_text(scene_.source) : options_.case_text;
    now.time = scene_.source.time;
    now.accuracy_choice = scene_.source.accuracy_choice;
    now.estimates_error = monitor_.has_value();
    now.reached = simulation_.time();
    now.steps = simulation_.counts().steps;
    now.frames = recorder_->frames();
    now.last_frame_time = last_recorded_;
    now.next_frame = next_frame_;
    now.smallest_gap = report_.smallest_gap;
    now.largest_stretch = report_.largest_stretch;
    now.energies = recorder_->energies();
    now.bill = bill();
    now.simulation = std::move(simulation);
    StateArchive archive;
    recorder_->transfer(archive);
    now.recorder = archive.bytes();
    if (monitor_) now.monitor = monitor_->checkpoint();
    return now;
  }

  // The second run of the error estimate is renewed with the first.
  void at_checkpoint(const std::string& state) override {
    RunCheckpoint now = checkpoint_of(state);
    if (monitor_) {
      const Stopwatch stopwatch;
      monitor_->restore(now.monitor);
      count_estimate(stopwatch.elapsed());
    }
    checkpoint_.keep(std::move(now));
    write_checkpoint_before_pause(0);
    is_stopped_at_checkpoint_ =
        options_.stop_at_checkpoint != nullptr && *options_.stop_at_checkpoint != 0;
  }
  // Writes a waiting checkpoint, after its frames, if it would otherwise wait too long.
  void write_checkpoint_before_pause(double pause) {
    if (!checkpoint_.is_due(pause)) return;
    recorder_->commit();
    const CostTimer cost(record_cost_);
    checkpoint_.write();
  }

  void after_step(const Simulation& simulation) override {
    const auto gap = simulation.smallest_gap();
    if (gap) report_.smallest_gap = std::min(report_.smallest_gap.value_or(*gap), *gap);
    recorder_->add_step(simulation);
  }
  void after_decision(const std::string& text) override { say(text); }

  void close_file() {
    const CostTimer cost(record_cost_);
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
    const CostTimer cost(record_cost_);
    report_.outputs =
        evaluate_outputs(scene_.source.outputs, TrajectoryReader(options_.trajectory));
  }

  // Returns the costs so far, with those before the checkpoint. The cost of the run itself is the
  // total cost less all other parts.
  Bill bill() const {
    const Cost here = started_.elapsed();
    Bill now;
    now.record = record_cost_;
    now.error_estimate = estimate_cost_;
    now.run = here - setup_ - record_cost_ - estimate_cost_;
    now.setup = setup_ + options_.earlier.setup;
    now.pilot = options_.earlier.pilot;
    now.total = here + options_.earlier.total;
    return options_.resumed != nullptr ? now + options_.resumed->bill : now;
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
    count_estimate(stopwatch.elapsed());
    return errors;
  }
  void count_estimate(const Cost& cost) {
    estimate_cost_ += cost;
    if (cpu_limit_) cpu_limit_->exclude(cost.cpu);
  }

  void integrate() {
    std::vector<double> interpolated(simulation_.state().size());
    const double duration = scene_.source.time.duration;
    // A longer duration may have frames within the last step before the checkpoint.
    if (const auto failure = record_frames(interpolated)) return fail(*failure);
    auto last_look = std::chrono::steady_clock::now();
    while (simulation_.time() < duration && !simulation_.has_ended()) {
      if (is_interrupted()) return interrupt();
      if (const auto failure = simulation_.step()) return end_with(*failure);
      if (const auto failure = record_frames(interpolated)) return fail(*failure);
      // The next step may take as long as this one did. Waiting frames are committed now if they
      // would otherwise wait too long.
      const double pause = seconds_since(last_look);
      recorder_->commit_before_pause(pause);
      write_checkpoint_before_pause(pause);
      last_look = std::chrono::steady_clock::now();
      if (options_.progress) options_.progress(std::min(simulation_.time(), duration));
      if (simulation_.time() < duration && cpu_limit_->is_passed())
        return fail_with_last_state(cpu_limit_->failure(simulation_));
    }
  }

  bool is_interrupted() const {
    return is_stopped_at_checkpoint_ ||
           (options_.stop_signal != nullptr && *options_.stop_signal != 0);
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
    report_.reason = is_stopped_at_checkpoint_ ? "stopped at a checkpoint, as asked by SIGUSR1"
                                               : reason_of_signal(*options_.stop_signal);
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
  const Stopwatch& started_;  // started before the set-up
  RunReport report_;
  Cost record_cost_, estimate_cost_;
  Simulation simulation_;
  std::optional<FrameRecorder> recorder_;
  std::optional<ErrorMonitor> monitor_;
  std::optional<CpuLimit> cpu_limit_;
  Cost setup_;  // cost of the set-up, without RunOptions::earlier
  FrameTimes frame_times_;
  WaitingCheckpoint checkpoint_;
  bool is_stopped_at_checkpoint_ = false;
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
  RunOptions run = options;
  run.case_text = motion_text(source);
  read_restart(source);
  Resumption found;
  if (options.resume) {
    found =
        find_resumption(options.trajectory, source, {.estimates_error = options.estimate_error});
    if (found.checkpoint) run.resumed = &*found.checkpoint;
  }
  // The checkpoint has settled time.accuracy.
  const PilotReport pilot =
      found.checkpoint
          ? PilotReport{}
          : correct_accuracy(source, {options.notice, options.progress, options.stop_signal});
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
  if (options.resumed == nullptr) check_initial_state(scene);
  return Run(scene, options, started).execute();
}

}  // namespace weft::sim
