#include "sim/command/sweep_command.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <set>

#include "sim/base/stopwatch.h"
#include "sim/case/case_error.h"
#include "sim/case/case_text.h"
#include "sim/command/guarded_command.h"
#include "sim/command/run_command.h"
#include "sim/sweep/correlation.h"
#include "sim/sweep/job_time.h"
#include "sim/sweep/local_engine.h"
#include "sim/sweep/plan_file.h"
#include "sim/sweep/slurm_engine.h"
#include "sim/sweep/summary_lock.h"
#include "sim/sweep/sweep_estimate.h"
#include "sim/sweep/sweep_folder.h"
#include "sim/sweep/sweep_monitor.h"
#include "sim/sweep/sweep_reader.h"
#include "sim/sweep/sweep_records.h"
#include "sim/sweep/sweep_values.h"
#include "sim/sweep/to_do_list.h"

namespace weft::sim {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Calls run() and turns its exceptions into messages and exit codes.
int with_faults(const SweepCommand& command, const std::function<int()>& run) {
  RunCommand about;
  about.case_path = command.path;
  about.overrides = command.overrides;
  about.json = command.json;
  return report_faults(about, [&](std::optional<std::string>&) { return run(); });
}

fs::path directory_of(const SweepCommand& command) {
  if (!command.directory.empty()) return command.directory;
  return fs::path("out") / fs::path(command.path).stem();
}

void print_json(const Json& json) {
  std::cout << json.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
}

Json value_json(const std::string& toml) {
  const Json json = Json::parse(toml, nullptr, false);
  return json.is_primitive() && !json.is_discarded() ? json : Json(plain_text(toml));
}

Json run_json(std::size_t index, const SweepPlan& plan, const RunRecord& record) {
  const PlannedRun& run = plan.runs[index];
  Json json{{"run", index + 1}, {"hash", run.hash}, {"status", state_name(record.state)}};
  json["values"] = Json::object();
  for (std::size_t i = 0; i < plan.factors.size(); ++i)
    json["values"][plan.factors[i]] = value_json(run.values[i]);
  if (record.state == RunState::failed) {
    json["failure"] = failure_name(record.result.failure);
    json["reason"] = record.result.reason;
  }
  return json;
}

Json counts_json(const RecordCounts& counts) {
  return {{"done", counts.done},
          {"failed", counts.failed},
          {"interrupted", counts.interrupted},
          {"running", counts.running},
          {"not_begun", counts.not_begun}};
}

// Returns the JSON object about a sweep with those runs for which `shown` holds.
Json sweep_json(const fs::path& directory, const SweepPlan& plan,
                const std::vector<RunRecord>& records, int code,
                const std::function<bool(const RunRecord&)>& shown) {
  Json json{{"weft_version", WEFT_VERSION},
            {"exit_code", code},
            {"directory", directory.string()},
            {"left_out", plan.left_out},
            {"counts", counts_json(count_records(records))}};
  json["runs"] = Json::array();
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (shown(records[i])) json["runs"].push_back(run_json(i, plan, records[i]));
  }
  return json;
}

bool has_failed(const RunRecord& record) { return record.state == RunState::failed; }

std::string run_line(std::size_t index, const SweepPlan& plan) {
  const PlannedRun& run = plan.runs[index];
  return std::to_string(index + 1) + "  " + run.hash.substr(0, 16) + "  " + values_text(plan, run);
}

void print_failures(const SweepPlan& plan, const std::vector<RunRecord>& records) {
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (!has_failed(records[i])) continue;
    const RunResult& result = records[i].result;
    std::cout << "failed  " << printable(run_line(i, plan)) << "\n  "
              << failure_name(result.failure) << ": " << printable(in_one_line(result.reason))
              << '\n';
  }
}

void print_counts(const SweepPlan& plan, const std::vector<RunRecord>& records) {
  std::cout << counted(static_cast<std::int64_t>(records.size()), "run", "runs") << ": "
            << counts_text(count_records(records));
  if (plan.left_out > 0)
    std::cout << "; " << counted(plan.left_out, "combination", "combinations")
              << " left out by rules";
  std::cout << '\n';
}

int list_runs(const SweepCommand& command, const SweepPlan& plan) {
  const fs::path directory = directory_of(command);
  const std::vector<RunRecord> records = read_records(directory, plan);
  if (command.json) {
    print_json(sweep_json(directory, plan, records, exit_code::done,
                          [](const RunRecord&) { return true; }));
    return exit_code::done;
  }
  for (std::size_t i = 0; i < records.size(); ++i) {
    std::cout << printable(run_line(i, plan)) << "  " << state_name(records[i].state);
    if (has_failed(records[i]))
      std::cout << ": " << printable(in_one_line(records[i].result.reason));
    std::cout << '\n';
  }
  print_counts(plan, records);
  return exit_code::done;
}

// Returns the time by which the command must have ended, if there is one.
std::optional<StopSchedule::Clock::time_point> end_of(const SweepCommand& command) {
  const auto after = [](double seconds) {
    return StopSchedule::Clock::now() + std::chrono::duration_cast<StopSchedule::Clock::duration>(
                                            std::chrono::duration<double>(seconds));
  };
  const std::optional<double> of_job = seconds_left_of_job();
  const double of_command = command.wall_time - Stopwatch::since_process_start().elapsed().wall;
  if (command.wall_time <= 0) return of_job ? std::optional(after(*of_job)) : std::nullopt;
  return after(of_job ? std::min(*of_job, of_command) : of_command);
}

EngineOptions engine_options(const SweepCommand& command, std::size_t runs) {
  const int cores = usable_cores();
  EngineOptions options;
  options.program = fs::read_symlink("/proc/self/exe").string();
  options.processes = command.processes > 0
                          ? command.processes
                          : std::clamp(static_cast<int>(std::min<std::size_t>(runs, 1U << 20U)), 1,
                                       std::max(1, cores / std::max(1, command.threads)));
  options.threads = command.threads > 0 ? command.threads : std::max(1, cores / options.processes);
  options.retries = command.retries;
  options.fail_fast = command.fail_fast;
  options.end = end_of(command);
  return options;
}

// Throws CaseError for more processes, or more threads of all of them, than cores.
void refuse_too_many_processes(const SweepCommand& command) {
  const int cores = usable_cores();
  if (command.processes > cores) {
    throw CaseError({"-j " + std::to_string(command.processes)}, "more runs at a time than cores",
                    "expected at most " + std::to_string(cores));
  }
  const int most = std::max(1, cores / std::max(1, command.processes));
  if (command.threads <= most) return;
  throw CaseError({"--threads " + std::to_string(command.threads)}, "more threads than cores",
                  "expected at most " + std::to_string(most));
}

// Returns the exit code of a worker that answers for the runs of `records`.
int code_of(const std::vector<RunRecord>& records, const EngineReport& report) {
  if (report.stop_signal != 0) return 128 + report.stop_signal;
  const RecordCounts counts = count_records(records);
  const bool have_ended = counts.interrupted + counts.running + counts.not_begun == 0;
  if (report.ran_out_of_time && !have_ended) return 128 + SIGTERM;
  const int left_out = report.input_faults.empty() ? 0 : counts.not_begun;
  return counts.failed + counts.interrupted + left_out > 0 ? exit_code::some_runs_failed
                                                           : exit_code::done;
}

void print_complaints(const std::set<std::string>& input_faults) {
  for (const std::string& fault : input_faults) complain("weft: " + fault);
}

void print_complaints(const OutputCollector& collector) {
  for (const std::string& complaint : collector.complaints()) complain("weft: " + complaint);
}

// Writes the summary. Workers of slices leave it to others while runs go on there, unless it is
// some seconds old: of many short slices, each would read the results of all.
void summarise(const SweepCommand& command, const fs::path& directory, const SweepPlan& plan,
               const std::vector<RunRecord>& records, OutputCollector& collector) {
  const RecordCounts counts = count_records(records);
  std::error_code unknown;
  const auto age =
      fs::file_time_type::clock::now() - fs::last_write_time(directory / "summary.csv", unknown);
  const bool is_new = !unknown && age < std::chrono::seconds(10);
  if (command.slices > 1 && is_new && counts.running > 0) return;
  write_summary(directory, plan, records, collector);
  // Workers of slices leave the plots to weft sweep collect.
  if (command.slices == 1) write_plots(summary_of(plan, records, collector), directory);
}

// Computes the runs of `options` and prints what came of them. The exit code is about the runs
// `mine` of the plan.
int compute(const SweepCommand& command, const fs::path& directory, const SweepPlan& plan,
            const EngineOptions& options, const std::vector<std::size_t>& mine) {
  std::signal(SIGUSR1, SIG_IGN);  // the engine heeds it; before and after, it would end the command
  std::vector<RunRecord> records = read_records(directory, plan);
  OutputCollector collector(directory, joined_outputs(plan.case_outputs, plan.sweep_outputs));
  EngineReport report;
  {
    SweepMonitor monitor(directory, plan, records, collector,
                         {options.processes, command.quiet, command.slices == 1});
    report = compute_runs(directory, plan, options, monitor);
  }
  {
    const SummaryLock lock(directory);
    // Other workers may have ended runs meanwhile.
    records = read_records(directory, plan);
    summarise(command, directory, plan, records, collector);
  }
  print_complaints(collector);
  print_complaints(report.input_faults);
  std::vector<RunRecord> answered;
  answered.reserve(mine.size());
  for (const std::size_t index : mine) answered.push_back(records[index]);
  const int code = code_of(answered, report);
  if (command.json) {
    Json json = sweep_json(directory, plan, records, code, has_failed);
    json["input_faults"] = report.input_faults;
    print_json(json);
    return code;
  }
  print_failures(plan, records);
  print_counts(plan, records);
  if (report.busy_seconds > 0) {
    const double share = report.busy_seconds / (options.processes * report.wall_seconds);
    std::cout << "  " << rounded_text(std::round(10 * report.wall_seconds) / 10) << " s, "
              << counted(options.processes, "process", "processes") << " of "
              << counted(options.threads, "thread", "threads") << ", busy "
              << rounded_text(std::round(100 * share)) << " %\n";
  }
  std::cout << "  summary " << printable((directory / "summary.csv").string()) << '\n';
  return code;
}

// Returns the outputs of the sweep file that the command names, or of the one that the plan names.
// If that is there no more, they are those of the plan, and a note says so.
std::vector<OutputExpression> outputs_to_collect(const SweepCommand& command,
                                                 const SweepPlan& plan) {
  if (!command.collected_sweep.empty()) return read_sweep_outputs(command.collected_sweep);
  std::error_code unknown;
  if (!fs::exists(plan.sweep, unknown)) {
    std::cerr << "weft: there is no " << plan.sweep
              << " any more; the outputs are those that it had (another may be named after the "
                 "folder)\n";
    return plan.sweep_outputs;
  }
  return read_sweep_outputs(fs::proximate(plan.sweep).string());
}

void print_estimate(const SweepEstimate& estimate, int processes) {
  std::printf("%zu of %zu runs as pilots, %zu of them done\n", estimate.pilots.size(),
              estimate.runs, estimate.done);
  if (estimate.done == 0) return;
  std::printf("  CPU time     %.3g s per run (%.3g to %.3g), %.3g hours for all\n",
              estimate.mean_cpu, estimate.least_cpu, estimate.most_cpu, estimate.cpu_hours());
  std::printf("  wall time    %.3g s for all, %d at a time\n", estimate.wall(processes), processes);
  std::printf("  memory       %.3g MiB per run\n", estimate.peak_memory);
  std::printf("  disk         %.3g MB for all\n", 1e-6 * estimate.disk());
}

// Returns the options of `work` that a job's tasks take over from the submission.
std::string worker_options(const SweepCommand& command) {
  std::string text = " --jobs " + std::to_string(std::max(1, command.processes)) + " --threads " +
                     std::to_string(std::max(1, command.threads));
  if (command.retries > 0) text += " --retry " + std::to_string(command.retries);
  if (command.fail_fast) text += " --fail-fast";
  if (command.wall_time > 0) text += " --wall-time " + rounded_text(command.wall_time);
  return text;
}

// Submits the runs still to do to Slurm and prints the number of the job.
int submit(const SweepCommand& command, const fs::path& directory, const SweepPlan& plan,
           const std::vector<RunToDo>& list) {
  if (list.empty()) {
    if (command.json) {
      print_json({{"exit_code", exit_code::done}, {"job", nullptr}, {"tasks", 0}});
    } else {
      std::cout << "no run is to be done; nothing was submitted\n";
    }
    return exit_code::done;
  }
  SlurmOptions options;
  options.program = fs::read_symlink("/proc/self/exe").string();
  options.name = fs::path(command.path).stem().string();
  options.tasks = command.tasks;
  options.tasks_at_a_time = command.tasks_at_a_time;
  options.cores = std::max(1, command.processes) * std::max(1, command.threads);
  options.worker_options = worker_options(command);
  options.sbatch_options = command.sbatch_options;
  const SlurmJob job = submit_to_slurm(directory, plan, list, options);
  if (command.json) {
    print_json({{"exit_code", exit_code::done}, {"job", job.id}, {"tasks", job.tasks}});
  } else {
    std::cout << "job " << printable(job.id) << " of " << counted(job.tasks, "task", "tasks")
              << " submitted for " << counted(static_cast<std::int64_t>(list.size()), "run", "runs")
              << "; weft sweep status " << printable(directory.string()) << " tells how it goes\n";
  }
  return exit_code::done;
}

// Returns the indices of all runs.
std::vector<std::size_t> all_runs(const SweepPlan& plan) {
  std::vector<std::size_t> indices(plan.runs.size());
  std::iota(indices.begin(), indices.end(), 0);
  return indices;
}

// Writes the plan of a sweep into a folder that holds nothing else of the same names.
void write_own_plan(const SweepCommand& command, const SweepCase& sweep, const fs::path& directory,
                    const SweepPlan& plan) {
  refuse_lost_files(directory, files_of_sweep(sweep, command.overrides), plan);
  write_plan(directory, plan);
}

// Writes the plan of a sweep and the list of its runs still to do, and returns that list.
std::vector<RunToDo> freeze(const SweepCommand& command, const SweepCase& sweep,
                            const fs::path& directory, const SweepPlan& plan) {
  write_own_plan(command, sweep, directory, plan);
  std::vector<RunToDo> list = runs_to_do(directory, plan, command.rerun_failed);
  write_to_do_list(to_do_path(directory), plan, list);
  return list;
}

}  // namespace

int run_sweep(const SweepCommand& command) {
  return with_faults(command, [&] {
    if (!command.to_slurm) refuse_too_many_processes(command);
    const SweepCase sweep = read_sweep(command.path);
    const SweepPlan plan = plan_sweep(sweep, command.overrides);
    check_outputs(plan);
    if (command.dry_run) return list_runs(command, plan);
    const fs::path directory = directory_of(command);
    if (command.to_slurm) refuse_live_job(directory);
    const std::vector<RunToDo> list = freeze(command, sweep, directory, plan);
    if (command.to_slurm) return submit(command, directory, plan, list);
    EngineOptions options = engine_options(command, plan.runs.size());
    options.runs = list;
    return compute(command, directory, plan, options, all_runs(plan));
  });
}

int write_sweep_plan(const SweepCommand& command) {
  return with_faults(command, [&] {
    const SweepCase sweep = read_sweep(command.path);
    const SweepPlan plan = plan_sweep(sweep, command.overrides);
    check_outputs(plan);
    const fs::path directory = directory_of(command);
    const std::vector<RunToDo> list = freeze(command, sweep, directory, plan);
    const std::vector<RunRecord> records = read_records(directory, plan);
    if (command.json) {
      Json json = sweep_json(directory, plan, records, exit_code::done, has_failed);
      json["to_do"] = list.size();
      print_json(json);
      return exit_code::done;
    }
    print_counts(plan, records);
    std::cout << "  " << counted(static_cast<std::int64_t>(list.size()), "run", "runs")
              << " to do, longest first, in " << printable(to_do_path(directory).string()) << '\n';
    return exit_code::done;
  });
}

int estimate_sweep_cost(const SweepCommand& command) {
  return with_faults(command, [&] {
    refuse_too_many_processes(command);
    const SweepCase sweep = read_sweep(command.path);
    const SweepPlan plan = plan_sweep(sweep, command.overrides);
    check_outputs(plan);
    const fs::path directory = directory_of(command);
    write_own_plan(command, sweep, directory, plan);
    const EngineOptions options = engine_options(command, plan.runs.size());
    const SweepEstimate estimate =
        estimate_sweep(directory, plan, options, static_cast<std::size_t>(command.pilots));
    print_complaints(estimate.input_faults);
    if (estimate.stop_signal != 0) return 128 + estimate.stop_signal;
    const int code =
        estimate.done == estimate.pilots.size() ? exit_code::done : exit_code::some_runs_failed;
    if (command.json) {
      print_json({{"exit_code", code},
                  {"runs", estimate.runs},
                  {"pilots", estimate.pilots.size()},
                  {"pilots_done", estimate.done},
                  {"cpu_s_per_run",
                   {{"least", estimate.least_cpu},
                    {"mean", estimate.mean_cpu},
                    {"most", estimate.most_cpu}}},
                  {"cpu_hours", estimate.cpu_hours()},
                  {"wall_s", estimate.wall(options.processes)},
                  {"processes", options.processes},
                  {"peak_memory_mib", estimate.peak_memory},
                  {"disk_bytes", estimate.disk()}});
      return code;
    }
    print_estimate(estimate, options.processes);
    return code;
  });
}

int work_on_sweep(const SweepCommand& command) {
  return with_faults(command, [&] {
    refuse_too_many_processes(command);
    const fs::path directory = command.path;
    const SweepPlan plan = read_plan(directory);
    const std::vector<RunToDo> list = read_to_do_list(
        command.list.empty() ? to_do_path(directory) : fs::path(command.list), plan);
    Slice slice = slice_of(list, static_cast<std::size_t>(command.slice),
                           static_cast<std::size_t>(command.slices));
    EngineOptions options = engine_options(command, list.size());
    if (command.threads == 0 && command.slices > 1) options.threads = 1;
    std::vector<std::size_t> mine;
    for (const RunToDo& run : slice.own) mine.push_back(run.index);
    options.runs = std::move(slice.own);
    if (!command.only_slice) options.others = std::move(slice.others);
    return compute(command, directory, plan, options, mine);
  });
}

int collect_sweep(const SweepCommand& command) {
  return with_faults(command, [&] {
    const fs::path directory = command.path;
    SweepPlan plan = read_plan(directory);
    plan.sweep_outputs = outputs_to_collect(command, plan);
    check_outputs(plan);
    const std::vector<RunRecord> records = read_records(directory, plan);
    OutputCollector collector(directory, joined_outputs(plan.case_outputs, plan.sweep_outputs),
                              true);
    const Summary summary = summary_of(plan, records, collector);
    write_summary(summary, directory);
    write_plots(summary, directory);
    print_complaints(collector);
    if (command.json) {
      Json json = sweep_json(directory, plan, records, exit_code::done, has_failed);
      json["outputs"] = summary.outputs;
      print_json(json);
      return exit_code::done;
    }
    print_counts(plan, records);
    std::cout << "  outputs " << quoted_list(summary.outputs) << '\n'
              << "  summary " << printable((directory / "summary.csv").string()) << '\n'
              << "  correlations " << printable((directory / "correlations.csv").string()) << '\n'
              << "  plots " << printable((directory / "plots").string()) << '\n';
    return exit_code::done;
  });
}

int show_sweep_status(const SweepCommand& command) {
  return with_faults(command, [&] {
    const SweepPlan plan = read_plan(command.path);
    const std::vector<RunRecord> records = read_records(command.path, plan);
    if (command.json) {
      print_json(sweep_json(command.path, plan, records, exit_code::done,
                            [](const RunRecord&) { return true; }));
    } else {
      print_failures(plan, records);
      print_counts(plan, records);
    }
    return exit_code::done;
  });
}

}  // namespace weft::sim
