#include "sim/sweep/sweep_estimate.h"

#include <algorithm>
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

// Returns the indices of runs that can run.
std::vector<std::size_t> runnable(const SweepPlan& plan) {
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < plan.runs.size(); ++i) {
    if (plan.runs[i].refusal.empty()) indices.push_back(i);
  }
  return indices;
}

}  // namespace

SweepEstimate estimate_sweep(const std::filesystem::path& directory, const SweepPlan& plan,
                             EngineOptions options, std::size_t count) {
  const std::vector<std::size_t> all = runnable(plan);
  SweepEstimate estimate;
  estimate.runs = all.size();
  count = std::min(count, all.size());
  for (std::size_t i = 0; i < count; ++i)
    estimate.pilots.push_back(all[(2 * i + 1) * all.size() / (2 * count)]);
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
