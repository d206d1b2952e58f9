// Shows a sweep while it runs, on standard error, and keeps its summary up to date.
#pragma once

#include <chrono>
#include <filesystem>
#include <list>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "sim/sweep/local_engine.h"
#include "sim/sweep/sweep_outputs.h"
#include "sim/sweep/sweep_records.h"

namespace weft::sim {

// Prints a line per run that ends. On a terminal, a table below these lines shows the runs that go
// on, with their progress, and the remaining time. `records` must have one entry per run of the
// plan. It and `collector` outlive the object.
class SweepMonitor final : public EngineObserver {
 public:
  struct Options {
    int processes = 1;
    bool quiet = false;          // prints nothing
    bool writes_summary = true;  // rewrites the summary as runs end, in a twentieth of the time
  };
  SweepMonitor(std::filesystem::path directory, const SweepPlan& plan,
               std::vector<RunRecord>& records, OutputCollector& collector, const Options& options);
  ~SweepMonitor() override;
  SweepMonitor(const SweepMonitor&) = delete;
  SweepMonitor& operator=(const SweepMonitor&) = delete;

  void begun(std::size_t index, int attempt, const std::filesystem::path& log) override;
  void ended(std::size_t index, const RunResult& result) override;
  void begins_anew(std::size_t index, const std::string& reason) override;
  void left_out(std::size_t index, const std::string& reason) override;
  void interrupted(std::size_t index) override;
  void held_by_another(std::size_t index) override;
  void idle() override;

 private:
  using Clock = std::chrono::steady_clock;
  struct Shown {
    std::size_t index;
    std::filesystem::path log;
    Clock::time_point start;
  };

  // Writes the summary if a run has ended since the last one, unless that was just now.
  void refresh_summary();
  void print(std::size_t index, const std::string& text);
  void erase_table();
  void draw_table();
  std::string line_of(const Shown& run) const;
  std::string remaining_text() const;

  std::filesystem::path directory_;
  const SweepPlan& plan_;
  std::vector<RunRecord>& records_;
  OutputCollector& collector_;
  Options options_;
  bool terminal_;
  // Runs of the plan by their hash: runs of one hash share the result.
  std::unordered_multimap<std::string_view, std::size_t> runs_of_hash_;
  std::list<Shown> shown_;
  int lines_drawn_ = 0;
  int ended_here_ = 0;           // runs that this object saw end
  double seconds_here_ = 0;      // their wall time, s
  int to_do_ = 0;                // runs without a result
  bool is_summary_old_ = false;  // a run has ended since the last summary
  Clock::time_point last_drawn_, next_summary_;
};

}  // namespace weft::sim
