#include "sim/command/run_command.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <optional>

#include "sim/accuracy/accuracy_choice.h"
#include "sim/accuracy/accuracy_pilot.h"
#include "sim/base/file_status.h"
#include "sim/case/case_reader.h"
#include "sim/case/case_text.h"
#include "sim/case/case_writer.h"
#include "sim/case/time_methods.h"
#include "sim/command/command_json.h"
#include "sim/command/guarded_command.h"
#include "sim/command/progress_bar.h"
#include "sim/run/input_files.h"
#include "sim/run/output_check.h"
#include "sim/run/recorded_run.h"
#include "sim/run/restart.h"
#include "sim/run/resumption.h"
#include "sim/run/run_checkpoint.h"
#include "sim/scene/scene.h"
#include "sim/trajectory/trajectory.h"

namespace weft::sim {

namespace {

std::atomic<int> caught_signal{0};
std::atomic<int> asked_for_checkpoint{0};
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler writes it");

// Installs the handler of SIGINT and SIGTERM. The first signal asks the run to stop, and becomes
// the reported reason. A second signal ends the process at once. SIGUSR1 asks the run to stop at
// its next checkpoint.
void catch_stop_signals() {
  std::signal(SIGUSR1, [](int) { asked_for_checkpoint = 1; });
  for (const int signal : {SIGINT, SIGTERM}) {
    std::signal(signal, [](int caught) {
      int none = 0;
      if (caught_signal.compare_exchange_strong(none, caught)) return;
      std::signal(caught, SIG_DFL);
      std::raise(caught);  // ends the process when the handler returns
    });
  }
}

// Prints two errors: the largest error of any body over the run, and the largest at its end.
void print_errors(const ErrorEstimate& estimate) {
  const BodyError& worst = *std::ranges::max_element(estimate.bodies, {}, &BodyError::largest);
  const BodyError& last = *std::ranges::max_element(estimate.bodies, {}, &BodyError::last);
  std::printf(
      "  estimated error (RMS) %.3g m at the most (%s, t = %.4g s), %.3g m at t = %.4g s (%s)\n",
      worst.largest, worst.body.c_str(), worst.largest_time, last.last, estimate.last_time,
      last.body.c_str());
}

// Warns on standard error if the error estimate is incomplete or the motion may be chaotic.
void warn_of_errors(const ErrorEstimate& estimate) {
  if (!estimate.failure.empty()) {
    complain("weft: the run that measures the error ended early: " + estimate.failure);
  }
  if (!estimate.parted_time) return;
  std::cerr << "weft: from t = " << rounded_text(*estimate.parted_time)
            << " s on the error is only known to be large: a more exact run differs by "
               "more than a tenth of the motion or the size of a body; the motion may be chaotic "
               "there\n";
}

// Prints the total CPU time (s) and that of each part of the bill.
void print_bill(const Bill& bill) {
  std::printf("  %.3g s of CPU: set-up %.3g", bill.total.cpu, bill.setup.cpu);
  if (bill.pilot.cpu > 0) std::printf(", pilot %.3g", bill.pilot.cpu);
  std::printf(", run %.3g, recording %.3g", bill.run.cpu, bill.record.cpu);
  if (bill.error_estimate.cpu > 0) std::printf(", error estimate %.3g", bill.error_estimate.cpu);
  std::printf("\n");
}

std::string output_text(double value) {
  return std::isnan(value) ? "no number" : rounded_text(value);
}

void print_summary(const RunReport& report) {
  std::printf("%s  %.4g s simulated in %.3g s, %s\n", status_name(report.status),
              report.simulated_time, report.bill.total.wall,
              counted(report.frames, "frame", "frames").c_str());
  print_bill(report.bill);
  std::printf("  steps %lld (%lld vetoed), Newton iterations %lld, linear iterations %lld\n",
              static_cast<long long>(report.counts.steps),
              static_cast<long long>(report.counts.vetoed_steps),
              static_cast<long long>(report.counts.newton_iterations),
              static_cast<long long>(report.counts.linear_iterations));
  if (report.smallest_gap) std::printf("  smallest gap %.3g mm\n", 1e3 * *report.smallest_gap);
  std::printf("  largest stretch %.2f %%\n", 100 * report.largest_stretch);
  if (report.error_estimate) print_errors(*report.error_estimate);
  for (const auto& [name, value] : report.outputs)
    std::printf("  %s %s\n", name.c_str(), output_text(value).c_str());
  if (!report.trajectory.empty())
    std::printf("  trajectory %s\n", printable(report.trajectory).c_str());
}

// Returns the absolute path of a file. Symbolic links are resolved, because a link and ".." after
// it do not cancel each other.
std::string absolute_path(const std::string& path) {
  std::error_code error;
  const auto resolved = std::filesystem::weakly_canonical(path, error);
  return (error ? std::filesystem::absolute(path) : resolved).string();
}

// Returns the overrides of the command and those that its other options stand for. The path of a
// trajectory is relative to the present folder, a key of a case to the folder of the case.
std::vector<std::string> all_overrides(const RunCommand& command) {
  std::vector<std::string> all = command.overrides;
  if (command.extend) all.push_back("time.duration=" + toml_number(*command.extend));
  if (!command.restart_from.empty()) {
    if (!std::isfinite(*command.restart_time))
      throw CaseError({"--time"}, "the time is not a finite number", "expected that of a frame, s");
    all.push_back("restart.path=" + toml_string(absolute_path(command.restart_from)));
    all.push_back("restart.time=" + toml_number(*command.restart_time));
  }
  return all;
}

// Loads the case, calls prepare(case), builds the scene and calls use(scene). Returns the exit code
// that `use` returns or, after a fault, that of report_faults().
int with_scene(const RunCommand& command, const auto& prepare, const auto& use) {
  return report_faults(command, [&](std::optional<std::string>& title) {
    Case source = read_case(command.case_path, all_overrides(command));
    title = source.title;
    read_restart(source);
    prepare(source);
    const std::unique_ptr<const Scene> scene = build_scene(source);
    return use(*scene);
  });
}

// Throws CaseError if the method finds equilibria, because an equilibrium has no error of time
// steps that --estimate-error could measure.
void refuse_no_estimate(const Case& source) {
  if (!source.particles.empty()) {
    throw CaseError({"--estimate-error"}, "a case with particles has no error estimate",
                    "expected a case without particles, or no --estimate-error");
  }
  if (!traits_of(source.time.method).finds_equilibria()) return;
  throw CaseError({"--estimate-error"}, "time.method = \"static\" has no error of time steps",
                  "expected another time.method, or no --estimate-error");
}

// Throws CaseError if a longer duration would change the run so far or, where there is none, if the
// duration is not longer than that of the case.
void refuse_to_extend(const RunCommand& command, const std::string& trajectory,
                      const Case& source) {
  if (!std::filesystem::exists(status_of(trajectory))) {
    const double duration = read_case(command.case_path, command.overrides).time.duration;
    if (*command.extend <= duration) {
      throw CaseError({"--extend"},
                      number_text(*command.extend) + " s is not beyond time.duration, " +
                          number_text(duration) + " s",
                      "expected a longer duration");
    }
  }
  const bool is_static = traits_of(source.time.method).finds_equilibria();
  if (!is_static && !source.time.accuracy) return;
  throw CaseError({"--extend"},
                  is_static ? "the loads of time.method = \"static\" grow with the duration"
                            : "time.accuracy is chosen for the duration",
                  is_static
                      ? "expected another time.method, or a run of its own"
                      : "expected a case with a method and its tolerance, or a run of its own");
}

// Throws CaseError if the run would overwrite a file that the case reads: by the trajectory, its
// sidecar or its checkpoint.
void refuse_input_files(const std::string& trajectory, const Case& source) {
  const auto sidecar = std::filesystem::path(trajectory).replace_extension(".xdmf");
  for (const std::string& path : {trajectory, sidecar.string(), checkpoint_path(trajectory),
                                  unfinished_checkpoint_path(trajectory)})
    refuse_input_file(path, source, "weft run");
}

// Finds where the run goes on, and settles time.accuracy as it did. Without --resume and --extend,
// refuses an existing file now, because the pilot may take long.
Resumption find_start(const RunCommand& command, const std::string& trajectory, Case& source) {
  refuse_input_files(trajectory, source);
  if (!command.resume && !command.extend) {
    TrajectoryWriter::refuse_existing(trajectory, command.force);
    refuse_foreign_checkpoint(trajectory, command.force);
    return {};
  }
  if (command.extend) refuse_to_extend(command, trajectory, source);
  return find_resumption(
      trajectory, source,
      {.estimates_error = command.estimate_error, .extends = command.extend.has_value()});
}

int code_of(RunReport::Status status) {
  switch (status) {
    case RunReport::Status::done:
      return exit_code::done;
    case RunReport::Status::failed:
      return exit_code::numerical_failure;
    case RunReport::Status::interrupted:
      // A run that SIGUSR1 stopped ends like one that SIGTERM stopped.
      return 128 + (caught_signal != 0 ? caught_signal.load() : SIGTERM);
  }
  return exit_code::done;
}

int finish(const RunCommand& command, const Case& source, const RunReport& report,
           const std::vector<std::string>& warnings) {
  const int code = code_of(report.status);
  if (command.json) {
    std::cout << report_json(command, source, report, warnings, code) << '\n';
  } else {
    print_summary(report);
  }
  if (report.error_estimate) warn_of_errors(*report.error_estimate);
  if (report.status == RunReport::Status::failed) complain("weft: " + report.reason);
  return code;
}

void print_notice(const std::string& text) { complain("weft: " + text); }

// Runs the pilot. Announces each of its runs and shows a progress bar for it, unless `quiet`.
PilotReport run_pilot(Case& source, bool quiet) {
  PilotOptions options;
  options.stop_signal = &caught_signal;
  std::optional<ProgressBar> bar;
  options.notice = [&](const std::string& text) {
    if (bar) bar->clear();
    if (!quiet) print_notice(text);
    bar.emplace(source.time.duration, !quiet);
  };
  options.progress = [&](double time) { bar->show(time); };
  PilotReport report = correct_accuracy(source, options);
  if (bar) bar->clear();
  return report;
}

// Returns a warning that nothing of what --extend adds is recorded, if output.frame_times ends
// before.
std::string missing_frames_warning(const Case& source, const RunCheckpoint& from) {
  const std::vector<double>& times = source.output.frame_times;
  if (times.empty() || from.frames == 0 || times.back() > from.last_frame_time) return "";
  return "output.frame_times has no time after " + number_text(times.back()) +
         " s: what --extend adds has no frame; --set output.frame_times=[...] may list more";
}

// Returns the bill before the run. The set-up comprises all costs so far except those of the pilot.
Bill bill_before_run(const RunCommand& command, const PilotReport& pilot) {
  Bill bill;
  bill.total = command.started.elapsed();
  bill.pilot = pilot.cost;
  bill.setup = bill.total - bill.pilot;
  return bill;
}

}  // namespace

int run_case(const RunCommand& command) {
  // Reading a restart may take long. A signal in that time stops the run at its start.
  catch_stop_signals();
  const auto name = std::filesystem::path(command.case_path).stem().string() + ".h5";
  const std::string trajectory = (std::filesystem::path(command.directory) / name).string();
  PilotReport pilot;
  Resumption found;
  RunOptions options;
  const auto prepare = [&](Case& source) {
    if (command.estimate_error) refuse_no_estimate(source);
    options.case_text = motion_text(source);
    found = find_start(command, trajectory, source);
    if (!found.checkpoint) {
      check_outputs_before_pilot(source, command.estimate_error);
      pilot = run_pilot(source, command.quiet);
    }
  };
  return with_scene(command, prepare, [&](const Scene& scene) {
    const Bill earlier = bill_before_run(command, pilot);
    if (pilot.ended_run())
      return finish(command, scene.source, ended_by_pilot(pilot, earlier, &caught_signal), {});
    options.trajectory = trajectory;
    options.force = command.force;
    options.resume = command.resume || command.extend;
    options.resumed = found.checkpoint ? &*found.checkpoint : nullptr;
    options.estimate_error = command.estimate_error;
    options.stop_signal = &caught_signal;
    options.stop_at_checkpoint = &asked_for_checkpoint;
    options.earlier = earlier;
    ProgressBar bar(scene.source.time.duration, !command.quiet);
    options.progress = [&](double time) { bar.show(time); };
    if (!command.quiet) {
      options.notice = [&](const std::string& text) {
        bar.clear();
        print_notice(text);
      };
    }
    std::vector<std::string> warnings;
    options.warning = [&](const std::string& text) {
      bar.clear();
      print_notice(text);
      warnings.push_back(text);
    };
    if (command.extend && found.checkpoint) {
      const std::string text = missing_frames_warning(scene.source, *found.checkpoint);
      if (!text.empty()) options.warning(text);
    }
    const RunReport report = run_simulation(scene, options);
    bar.clear();
    return finish(command, scene.source, report, warnings);
  });
}

}  // namespace weft::sim
