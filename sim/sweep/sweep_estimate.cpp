#include "sim/sweep/sweep_estimate.h"

#include <algorithm>
#include <cmath>
#include <system_error>

#include "sim/sweep/run_folder.h"

namespace weft::sim {

namespace {

// Ignores all events: the results of pilots are read from their files.
class SilentObserver final : public EngineObserver {
 public:
  void begun(std::size_t, int, const std::filesystem::path&) override {}
  void ended(std::size_t, const RunResult&) override {}
  void begins_anew(std::size_t, const std::string&) override {}
  void left_out(std::size_t, const std::string&) override {}
  void interrupted(std::size_t) override {}
  void held_by_another(std::size_t) override {}
  void idle() override {}
};

// Returns the bytes of all files in a folder.
double size_of(const std::filesystem::path& folder) {
  double bytes = 0;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const auto size = entry.file_size(error);
    if (!error) bytes += static_cast<double>(size);
  }
  return bytes;
}

// Returns the indices of runs that can run, from the least work to the most.
std::vector<std::size_t> runnable(const SweepPlan& plan) {
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < plan.runs.size(); ++i) {
    if (plan.runs[i].refusal.empty()) indices.push_back(i);
  }
  std::ranges::stable_sort(indices, {}, [&](std::size_t i) { return plan.runs[i].work; });
  return indices;
}

// Returns `count` of the runs, one out of each of `count` equal parts. Its place in the part is a
// multiple of the golden ratio: at the same place, the period of a factor of a grid could be that
// of the parts, and all pilots would have one of its values.
std::vector<std::size_t> pilots_of(const std::vector<std::size_t>& runs, std::size_t count) {
  constexpr double golden_ratio = 0.61803398874989485;
  std::vector<std::size_t> pilots;
  for (std::size_t i = 0; i < count; ++i) {
    const double part = static_cast<double>(i), turn = 0.5 + golden_ratio * part;
    const double place = (part + turn - std::floor(turn)) / static_cast<double>(count);
    pilots.push_back(runs[static_cast<std::size_t>(place * static_cast<double>(runs.size()))]);
  }
  return pilots;
}

}  // namespace

SweepEstimate estimate_sweep(const std::filesystem::path& directory, const SweepPlan& plan,
                             EngineOptions options, std::size_t count) {
  const std::vector<std::size_t> all = runnable(plan);
  SweepEstimate estimate;
  estimate.runs = all.size();
  estimate.pilots = pilots_of(all, std::min(count, all.size()));
  options.runs.clear();
  for (const std::size_t index : estimate.pilots) options.runs.push_back({index});
  SilentObserver observer;
  const EngineReport report = compute_runs(directory, plan, options, observer);
  estimate.stop_signal = report.stop_signal;
  estimate.input_faults = report.input_faults;
  for (const std::size_t index : estimate.pilots) {
    const RunFolder folder(directory, plan.runs[index].hash);
    const auto result = folder.result();
    if (!result || !result->is_done()) continue;
    estimate.least_cpu = estimate.done == 0 ? result->cpu_seconds
                                            : std::min(estimate.least_cpu, result->cpu_seconds);
    estimate.most_cpu = std::max(estimate.most_cpu, result->cpu_seconds);
    estimate.peak_memory = std::max(estimate.peak_memory, result->peak_memory);
    estimate.mean_cpu += result->cpu_seconds;
    estimate.mean_wall += result->wall_seconds;
    estimate.mean_disk += size_of(folder.path());
    ++estimate.done;
  }
  if (estimate.done == 0) return estimate;
  for (double* mean : {&estimate.mean_cpu, &estimate.mean_wall, &estimate.mean_disk})
    *mean /= static_cast<double>(estimate.done);
  return estimate;
}

}  // namespace weft::sim
