// The command `weft sweep`.
#pragma once

#include <string>
#include <vector>

namespace weft::sim {

struct SweepCommand {
  std::string path;                    // sweep file; of `work` and `status` the folder of the sweep
  std::string directory;               // folder of the results; empty: out/NAME of the sweep file
  std::vector<std::string> overrides;  // "KEY=VALUE" for all runs
  int processes = 0;                   // runs at a time; 0: as many as there are cores
  int threads = 0;                     // per run; 0: an equal share of the cores, `work`: one
  int retries = 0;                     // further attempts of a run that crashed
  bool fail_fast = false;
  bool rerun_failed = false;
  bool dry_run = false;  // lists the runs and writes nothing
  bool json = false;
  bool quiet = false;
  // Engine "slurm": slices, slices at a time (0: no limit), and options of sbatch.
  bool to_slurm = false;
  int tasks = 0, tasks_at_a_time = 0;
  std::vector<std::string> sbatch_options;
  int pilots = 3;  // `estimate`: number of runs to compute
  // Seconds after its start by which the command must have ended; 0: no limit, or that of the job.
  double wall_time = 0;
  // `work`: the slice of the list that this process takes, the number of slices, and the path of
  // the list; empty: to_do.json of the folder.
  int slice = 0, slices = 1;
  std::string list;
  bool only_slice = false;      // leaves the runs of other slices alone
  std::string collected_sweep;  // `collect`: path of a sweep file with outputs, or empty
};

// Plans a sweep, computes the runs that have no result, and prints those that failed. Returns the
// exit code: one of exit_code or, after a signal, 130 (SIGINT) or 143 (SIGTERM; also if its time
// was up before its runs were done).
int run_sweep(const SweepCommand& command);
// Computes a few runs of a sweep and prints what all of them will cost. Returns the exit code:
// exit_code::some_runs_failed if a pilot is not done.
int estimate_sweep_cost(const SweepCommand& command);
// Plans a sweep, and freezes the list of its runs still to do for `work`. Returns the exit code.
int write_sweep_plan(const SweepCommand& command);
// Computes a slice of the frozen list of a sweep, and helps with the other slices. Returns the exit
// code, as run_sweep() does.
int work_on_sweep(const SweepCommand& command);
// Makes the summary, the table of correlations and the plots of a sweep anew, without running
// anything. The outputs are those of the case and of the sweep file `collected_sweep` or, if that
// is empty, of the sweep file that the plan names. Returns the exit code.
int collect_sweep(const SweepCommand& command);
// Prints the states of all runs. Returns 0, whatever they are, or exit_code::input_output.
int show_sweep_status(const SweepCommand& command);

}  // namespace weft::sim
