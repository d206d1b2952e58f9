// The states of all runs of a sweep, read from its files, and the table of them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/sweep/run_folder.h"
#include "sim/sweep/sweep_plan.h"

namespace weft::sim {

// The state of a run. The result is set if the run is done or has failed.
struct RunRecord {
  RunState state = RunState::not_begun;
  RunResult result;
};

// Reads the states of all runs, in the order of the plan. A run with a refusal has failed. Costs
// about 60 microseconds per run (bench/results/, sweeps.txt).
std::vector<RunRecord> read_records(const std::filesystem::path& directory, const SweepPlan& plan);

// The numbers of runs by state.
struct RecordCounts {
  int done = 0, failed = 0, interrupted = 0, running = 0, not_begun = 0;
};
RecordCounts count_records(const std::vector<RunRecord>& records);
// Returns "3 done, 1 failed, 2 not begun": the states that some run has.
std::string counts_text(const RecordCounts& counts);

// Returns the factors of a run with their values: "contact.friction = 0.3, time.duration = 1.0".
std::string values_text(const SweepPlan& plan, const PlannedRun& run);

}  // namespace weft::sim
