// Computes the runs of a plan on this machine, several at a time.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "sim/sweep/run_folder.h"
#include "sim/sweep/stop_schedule.h"
#include "sim/sweep/sweep_plan.h"
#include "sim/sweep/to_do_list.h"

namespace weft::sim {

struct EngineOptions {
  std::string program;        // path of the weft command
  int processes = 1;          // runs at a time
  int threads = 1;            // most threads of each
  int retries = 0;            // further attempts of a run that crashed, or could not read or write
  bool fail_fast = false;     // stops after the first failure
  std::vector<RunToDo> runs;  // runs that this engine answers for
  // Runs that other workers answer for, and that this one takes as soon as it has begun all of
  // `runs`.
  std::vector<RunToDo> others;
  // Time by which the engine must have ended. Some time before, it stops its runs (StopSchedule).
  std::optional<StopSchedule::Clock::time_point> end;
};

// Learns how the runs of an engine go. All functions are called by the thread of the engine.
class EngineObserver {
 public:
  virtual ~EngineObserver() = default;
  // Runs `index` begins, `attempt` counting from 1. Its messages go to the file `log`.
  virtual void begun(std::size_t index, int attempt, const std::filesystem::path& log) = 0;
  // Run `index` has ended and its result is written.
  virtual void ended(std::size_t index, const RunResult& result) = 0;
  // Run `index` cannot go on from its checkpoint for this reason, and begins at t = 0.
  virtual void begins_anew(std::size_t index, const std::string& reason) = 0;
  // Run `index` is left without a result for this reason, which is about a file that it reads.
  virtual void left_out(std::size_t index, const std::string& reason) = 0;
  // Run `index` was stopped and can go on later.
  virtual void interrupted(std::size_t index) = 0;
  // Another worker is at run `index`.
  virtual void held_by_another(std::size_t index) = 0;
  // Is called several times per second.
  virtual void idle() = 0;
};

struct EngineReport {
  int stop_signal = 0;           // SIGINT or SIGTERM if one of them stopped the engine
  bool ran_out_of_time = false;  // true if EngineOptions::end or SIGUSR1 stopped it
  // Reasons why runs were left without a result: files that they read and that are not as planned.
  std::set<std::string> input_faults;
  double wall_seconds = 0;  // of the engine
  double busy_seconds = 0;  // wall time of all runs; at most processes * wall_seconds
};

// Computes all runs of options.runs, in the order of the list, and writes their results; then those
// of options.others that no worker has begun. Runs that another worker is at are waited for, and
// taken over if it gives them up, if they belong to options.runs.
//
// A run of which a file is not as planned, before it begins or when it has ended, gets no result:
// it would be that of another hash. The files of its attempt are removed if an input has changed,
// and kept for a later call if one cannot be read.
//
// SIGINT or SIGTERM stops all runs by SIGTERM; a second one kills them. SIGUSR1 says that time is
// short (StopSchedule). These signals are blocked meanwhile. Throws FileError if the folder of the
// sweep cannot be written.
EngineReport compute_runs(const std::filesystem::path& directory, const SweepPlan& plan,
                          const EngineOptions& options, EngineObserver& observer);

// Returns the number of processors that this process may use.
int usable_cores();

}  // namespace weft::sim
