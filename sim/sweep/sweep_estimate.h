// The cost of a sweep, extrapolated from a few of its runs.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "sim/sweep/local_engine.h"
#include "sim/sweep/sweep_plan.h"

namespace weft::sim {

struct SweepEstimate {
  std::vector<std::size_t> pilots;  // indices of the runs that were looked at
  std::size_t done = 0;             // those of them that are done; the figures below are theirs
  std::size_t runs = 0;             // runs of the sweep that can run
  double least_cpu = 0, mean_cpu = 0, most_cpu = 0;  // s per run
  double mean_wall = 0;                              // s per run
  double peak_memory = 0;                            // MiB of the run that takes most
  double mean_disk = 0;                              // bytes per run
  int stop_signal = 0;                               // SIGINT or SIGTERM, if one ended the pilots
  std::set<std::string> input_faults;                // EngineReport::input_faults of the pilots

  double cpu_hours() const { return mean_cpu * static_cast<double>(runs) / 3600; }
  double disk() const { return mean_disk * static_cast<double>(runs); }
  // Wall time (s) of all runs, `processes` at a time.
  double wall(int processes) const { return mean_wall * static_cast<double>(runs) / processes; }
};

// Computes `count` runs of the plan, from little to much work (RunPlan::work), unless they have
// results, and extrapolates. The pilots are runs of the sweep: their results stay. `options.runs`
// is not read. Throws FileError as compute_runs() does.
SweepEstimate estimate_sweep(const std::filesystem::path& directory, const SweepPlan& plan,
                             EngineOptions options, std::size_t count);

}  // namespace weft::sim
