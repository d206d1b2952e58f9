// Computes the runs of a plan on this machine, several at a time.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/sweep/run_folder.h"
#include "sim/sweep/sweep_plan.h"

namespace weft::sim {

struct EngineOptions {
  std::string program;        // path of the weft command
  int processes = 1;          // runs at a time
  int threads = 1;            // most threads of each
  int retries = 0;            // further attempts of a run that crashed, or could not read or write
  bool fail_fast = false;     // stops after the first failure
  bool rerun_failed = false;  // computes failed runs again
  std::vector<std::size_t> runs;  // indices of the runs in the plan that this engine may take
};

// Learns how the runs of an engine go. All functions are called by the thread of the engine.
class EngineObserver {
 public:
  virtual ~EngineObserver() = default;
  // Runs `index` begins, `attempt` counting from 1. Its messages go to the file `log`.
  virtual void begun(std::size_t index, int attempt, const std::filesystem::path& log) = 0;
  // Run `index` has ended and its result is written.
  virtual void ended(std::size_t index, const RunResult& result) = 0;
  // Run `index` was stopped and can go on later.
  virtual void interrupted(std::size_t index) = 0;
  // Run `index` is left to another worker that is at it.
  virtual void left_to_another(std::size_t index) = 0;
  // Is called several times per second.
  virtual void idle() = 0;
};

struct EngineReport {
  int stop_signal = 0;      // SIGINT or SIGTERM if one of them stopped the engine
  double wall_seconds = 0;  // of the engine
  double busy_seconds = 0;  // wall time of all runs; at most processes * wall_seconds
};

// Computes all runs of options.runs that have no result, in the order of the list, and writes their
// results. A run with a refusal is left alone. Runs with equal hashes are computed once. SIGINT or
// SIGTERM stops all runs by SIGTERM; a second one kills them. Both signals are blocked meanwhile.
// Throws FileError if the folder of the sweep cannot be written.
EngineReport compute_runs(const std::filesystem::path& directory, const SweepPlan& plan,
                          const EngineOptions& options, EngineObserver& observer);

// Returns the number of processors that this process may use.
int usable_cores();

}  // namespace weft::sim
