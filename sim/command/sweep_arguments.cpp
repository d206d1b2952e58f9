#include "sim/command/sweep_arguments.h"

#include <limits>

#include "sim/case/case_text.h"
#include "sim/command/argument_checks.h"

namespace weft::sim {

namespace {

constexpr const char* description =
    R"(Run a case with many values of its keys

  weft sweep SWEEP.toml --dry-run            list the runs
  weft sweep estimate SWEEP.toml -o DIR      run a few of them and state the cost of all
  weft sweep SWEEP.toml -o DIR -j 4          compute those that have no result, four at a time
  weft sweep SWEEP.toml -o DIR --rerun failed   also those that failed
  weft sweep plan SWEEP.toml -o DIR          freeze the list of runs still to do, for workers:
  mpirun -n 2 sh -c 'weft sweep work DIR --slice $OMPI_COMM_WORLD_RANK/2 || true'
  weft sweep status DIR                      what is done, failed, interrupted
  weft sweep collect DIR                     summary and plots anew, with new [outputs]

docs/sweep_reference.md describes sweep files, and the guide shows their use.)";

constexpr int most = std::numeric_limits<int>::max();

// Reads "K/N". Throws CLI::ValidationError unless 0 <= K < N.
void read_slice(const std::string& text, SweepCommand& command) {
  const std::size_t bar = text.find('/');
  const bool is_slice = bar != std::string::npos &&
                        CLI::detail::lexical_cast(text.substr(0, bar), command.slice) &&
                        CLI::detail::lexical_cast(text.substr(bar + 1), command.slices) &&
                        0 <= command.slice && command.slice < command.slices;
  if (is_slice) return;
  throw CLI::ValidationError("--slice", in_quotes(text) +
                                            " is not a slice: expected K/N with 0 <= K < N, such "
                                            "as 0/4");
}

// Adds the options of commands that plan a sweep.
void add_plan_options(CLI::App& sub, SweepCommand& command) {
  sub.add_option("-o,--output", command.directory,
                 "Folder of the results; default: out/NAME of the sweep file")
      ->type_name("DIR")
      ->check(is_name);
  sub.add_option("--set", command.overrides,
                 "Override a case key in all runs, for example --set time.duration=0.5; one "
                 "--set per key")
      ->option_text("KEY=VALUE")
      ->allow_extra_args(false);
}

void add_jobs(CLI::App& sub, SweepCommand& command) {
  sub.add_option("-j,--jobs", command.processes,
                 "Runs at a time, at most one per core; default: one per core. Each gets an equal "
                 "share of the cores for its threads")
      ->type_name("RUNS")
      ->check(CLI::Range(1, most));
}

// Validates an option: returns an error message, or an empty text for a positive number of seconds.
std::string is_wall_time(const std::string& text) {
  double seconds = 0;
  if (CLI::detail::lexical_cast(text, seconds) && seconds > 0 && seconds <= 1e9) return "";
  return in_quotes(text) + " is not a time: expected a positive number of seconds";
}

void add_rerun(CLI::App& sub, SweepCommand& command) {
  sub.add_option_function<std::string>(
         "--rerun", [&command](const std::string&) { command.rerun_failed = true; },
         "Compute again runs that have \"failed\"")
      ->type_name("failed")
      ->check(CLI::IsMember({"failed"}));
}

// Adds the options of commands that compute runs.
void add_engine_options(CLI::App& sub, SweepCommand& command) {
  add_jobs(sub, command);
  sub.add_option("--threads", command.threads,
                 "Threads of each run; default: its share of the cores, of a slice's runs one")
      ->check(CLI::Range(1, most));
  sub.add_option("--wall-time", command.wall_time,
                 "Seconds by which this command must have ended: before, no run begins, and runs "
                 "stop at checkpoints. Default: the time that Slurm leaves to the job")
      ->type_name("SECONDS")
      ->check(is_wall_time);
  sub.add_option("--retry", command.retries,
                 "Further attempts of a run that crashed, or could not read or write its files")
      ->type_name("TIMES")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  sub.add_flag("--fail-fast", command.fail_fast, "Stop all runs after the first failure");
  sub.add_flag("--quiet", command.quiet, "No lines about runs");
}

void add_slurm_options(CLI::App& sub, SweepCommand& command) {
  sub.add_option_function<std::string>(
         "--engine", [&command](const std::string& name) { command.to_slurm = name == "slurm"; },
         "local: compute the runs here. slurm: submit one job array of slices, and return; -j are "
         "then the runs that a task computes at a time, with --threads each")
      ->type_name("ENGINE")
      ->check(CLI::IsMember({"local", "slurm"}));
  sub.add_option("--tasks", command.tasks,
                 "Tasks of the job array; default: one per run still to do, at most MaxArraySize")
      ->check(CLI::Range(1, most));
  sub.add_option("--tasks-at-a-time", command.tasks_at_a_time, "Most tasks at a time")
      ->check(CLI::Range(1, most));
  sub.add_option("--sbatch", command.sbatch_options,
                 "Option for sbatch, for example --sbatch=--time=2:00:00; one --sbatch per option")
      ->option_text("OPTION")
      ->allow_extra_args(false);
}

void add_json(CLI::App& sub, SweepCommand& command) {
  sub.add_flag("--json", command.json, "Print one JSON object");
}

}  // namespace

void add_sweep(CLI::App& app, SweepCommand& command, int& code) {
  CLI::App* sweep = app.add_subcommand("sweep", description);
  sweep->add_option("sweep", command.path, "TOML sweep file");
  add_plan_options(*sweep, command);
  sweep->add_flag("--dry-run", command.dry_run, "List the runs and their states; write nothing");
  add_engine_options(*sweep, command);
  add_rerun(*sweep, command);
  add_slurm_options(*sweep, command);
  add_json(*sweep, command);

  CLI::App* estimate = sweep->add_subcommand(
      "estimate", "Compute a few runs of a sweep, which stay, and state the cost of all");
  estimate->add_option("sweep", command.path, "TOML sweep file")->required();
  add_plan_options(*estimate, command);
  add_jobs(*estimate, command);
  estimate->add_option("--pilots", command.pilots, "Runs to compute, from short to long ones")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  add_json(*estimate, command);
  estimate->callback([&] { code = estimate_sweep_cost(command); });

  CLI::App* plan = sweep->add_subcommand(
      "plan", "Plan a sweep and freeze the list of its runs still to do, for weft sweep work");
  plan->add_option("sweep", command.path, "TOML sweep file")->required();
  add_plan_options(*plan, command);
  add_rerun(*plan, command);
  add_json(*plan, command);
  plan->callback([&] { code = write_sweep_plan(command); });

  CLI::App* work = sweep->add_subcommand(
      "work",
      "Compute a slice of the frozen list of a sweep, then runs of other slices that have not "
      "begun");
  work->add_option("folder", command.path, "Folder of the sweep")->required();
  work->add_option_function<std::string>(
          "--slice", [&command](const std::string& text) { read_slice(text, command); },
          "Take every Nth run of the list, from run K on, counted from 0; default: 0/1")
      ->type_name("K/N");
  work->add_option("--list", command.list, "List of runs; default: to_do.json of the folder")
      ->type_name("FILE")
      ->check(is_name);
  work->add_flag("--only-slice", command.only_slice,
                 "Leave the runs of other slices alone: for folders whose locks do not reach all "
                 "machines");
  add_engine_options(*work, command);
  add_json(*work, command);
  work->callback([&] { code = work_on_sweep(command); });

  CLI::App* collect = sweep->add_subcommand(
      "collect",
      "Make the summary and plots anew from the trajectories, with the [outputs] that the sweep "
      "file has now, without running anything");
  collect->add_option("folder", command.path, "Folder of the sweep")->required();
  collect
      ->add_option("sweep", command.collected_sweep,
                   "Sweep file with the outputs; default: the one of the plan")
      ->check(is_name);
  add_json(*collect, command);
  collect->callback([&] { code = collect_sweep(command); });

  CLI::App* status = sweep->add_subcommand("status", "Say which runs are done and which failed");
  status->add_option("folder", command.path, "Folder of the sweep")->required();
  add_json(*status, command);
  status->callback([&] { code = show_sweep_status(command); });

  sweep->callback([&command, &code, sweep] {
    if (!sweep->get_subcommands().empty()) return;
    if (command.path.empty()) throw CLI::RequiredError("sweep");
    code = run_sweep(command);
  });
}

}  // namespace weft::sim
