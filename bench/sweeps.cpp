// Cost of planning, listing and summarising a sweep of many runs, without the runs.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "bench/experiments.h"
#include "bench/temporary_folder.h"
#include "bench/timed_command.h"
#include "sim/base/stopwatch.h"
#include "sim/sweep/correlation.h"
#include "sim/sweep/plan_file.h"
#include "sim/sweep/run_folder.h"
#include "sim/sweep/sweep_monitor.h"
#include "sim/sweep/sweep_outputs.h"
#include "sim/sweep/sweep_reader.h"
#include "sim/sweep/sweep_records.h"
#include "sim/sweep/to_do_list.h"
#include "sim/sweep/whole_file.h"

namespace weft::bench {

namespace {

namespace fs = std::filesystem;
using namespace weft::sim;

constexpr const char* base_case = R"([contact]
friction = 0.3
[material.cotton]
density = 0.2
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [9, 9] }
[[obstacle]]
name = "ball"
position = [0, 0, -0.5]
shape = { type = "sphere", radius = 0.3, resolution = [9] }
)";

std::string sweep_text(int runs) {
  return "case = \"base.toml\"\n[factors]\n"
         "\"contact.friction\" = { uniform = [0.1, 0.5] }\n"
         "\"material.cotton.density\" = { log_uniform = [0.1, 0.4] }\n"
         "\"material.cotton.bending_stiffness\" = { log_uniform = [1e-6, 1e-4] }\n"
         "\"time.duration\" = { uniform = [0.1, 0.5] }\n"
         "[sample]\nmethod = \"sobol\"\nruns = " +
         std::to_string(runs) +
         "\n[outputs]\nstretch = \"max(largest_stretch)\"\n"
         "tip = \"last(position('sheet', 0, 0).z)\"\n";
}

void write(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

struct Row {
  std::string step;
  Cost cost;
  bool is_command = false;  // a command of its own, which includes other rows
};

// A sweep in a temporary folder, and the costs of what is done with it.
class ManyRuns {
 public:
  explicit ManyRuns(int runs) {
    write(folder_.path("base.toml"), base_case);
    write(folder_.path("sweep.toml"), sweep_text(runs));
    const TimedCommand run = run_command(
        {weft_command(), "run", "base.toml", "--json", "--quiet", "--set", "time.duration=0.001"},
        folder_.path());
    if (!run.is_well) throw std::runtime_error("weft run: " + run.output);
    report_ = run.output;
  }

  // Measures the parts of a sweep in this process, then the commands.
  void measure() {
    time("plan", [&] { plan_ = plan_sweep(read_sweep(folder_.path("sweep.toml"))); });
    time("write plan", [&] { write_plan(sweep_, plan_); });
    time_command("weft sweep --dry-run", {"sweep", "sweep.toml", "-o", sweep_, "--dry-run"});
    time("list of runs to do",
         [&] { write_to_do_list(to_do_path(sweep_), plan_, runs_to_do(sweep_, plan_, false)); });
    const auto outputs = joined_outputs(plan_.case_outputs, plan_.sweep_outputs);
    values_ = output_values(trajectory_, outputs);
    const std::size_t written = std::min<std::size_t>(100, plan_.runs.size());
    time("write " + std::to_string(written) + " results", [&] {
      for (std::size_t i = 0; i < written; ++i) write_result(plan_.runs[i]);
    });
    for (std::size_t i = written; i < plan_.runs.size(); ++i) copy_result(plan_.runs[i]);
    std::vector<RunRecord> records(plan_.runs.size());
    OutputCollector collector(sweep_, outputs);
    time("summaries as runs end", [&] { end_all_runs(records, collector); });
    time("last summary", [&] { write_summary(sweep_, plan_, records, collector); });
    time("plots", [&] { write_plots(summary_of(plan_, records, collector), sweep_); });
    time("read plan", [&] { plan_ = read_plan(sweep_); });
    time("read results", [&] { records = read_records(sweep_, plan_); });
    done_ = count_records(records).done;
    time_command("weft sweep status", {"sweep", "status", sweep_});
    time_command("weft sweep collect", {"sweep", "collect", sweep_});
    time_command("weft sweep, all done", {"sweep", "sweep.toml", "-o", sweep_, "--quiet"});
  }

  const std::vector<Row>& rows() const { return rows_; }
  bool is_complete() const { return done_ == static_cast<int>(plan_.runs.size()); }
  int done() const { return done_; }

 private:
  void time(const std::string& step, const std::function<void()>& work) {
    const Stopwatch stopwatch;
    work();
    rows_.push_back({step, stopwatch.elapsed(), false});
  }

  void time_command(const char* step, std::vector<std::string> words) {
    words.insert(words.begin(), weft_command());
    const Stopwatch stopwatch;
    const TimedCommand command = run_command(words, folder_.path());
    if (!command.is_well) throw std::runtime_error(std::string(step) + ": " + command.output);
    rows_.push_back({step, {stopwatch.elapsed().wall, command.cpu_s}, true});
  }

  // Gives a run its result and its trajectory, as an engine does. All trajectories share the bytes
  // of one file.
  void write_result(const PlannedRun& run) const {
    const RunFolder run_folder(sweep_, run.hash);
    std::optional<RunAttempt> attempt = run_folder.begin(run.case_text);
    if (!attempt) return;
    fs::create_hard_link(trajectory_, attempt->folder() / "run.h5");
    run_folder.finish(std::move(*attempt), result_of(run));
  }

  // Gives a run the result of the first one, without waiting for the disk.
  void copy_result(const PlannedRun& run) const {
    const std::string& first = plan_.runs.front().hash;
    const fs::path from = RunFolder(sweep_, first).path(), to = RunFolder(sweep_, run.hash).path();
    if (!fs::create_directories(to)) return;
    fs::create_hard_link(trajectory_, to / "run.h5");
    write((to / "run.toml").string(), run.case_text);
    std::string result = read_whole_file(from / "result.json").value();
    result.replace(result.find(first), first.size(), run.hash);
    write((to / "result.json").string(), result);
  }

  // Tells the monitor of a sweep that run after run ends, as fast as it takes the news.
  void end_all_runs(std::vector<RunRecord>& records, OutputCollector& collector) const {
    SweepMonitor monitor(sweep_, plan_, records, collector, {1, true, true});
    for (std::size_t i = 0; i < plan_.runs.size(); ++i) monitor.ended(i, result_of(plan_.runs[i]));
  }

  RunResult result_of(const PlannedRun& run) const {
    RunResult result;
    result.hash = run.hash;
    result.version = "bench";
    result.report = report_;
    result.outputs = values_;
    return result;
  }

  const TemporaryFolder folder_;
  const std::string trajectory_ = folder_.path("out/base.h5");
  const std::string sweep_ = folder_.path("sweep");
  std::string report_;  // of each run, as weft run prints it
  SweepPlan plan_;
  std::map<std::string, double> values_;  // outputs of each run
  std::vector<Row> rows_;
  int done_ = 0;
};

void print_table(int runs, const std::vector<Row>& rows) {
  std::printf("%d runs of four factors and two outputs\n", runs);
  for (const bool are_commands : {false, true}) {
    std::printf("\n%-24s %9s %9s\n", are_commands ? "command" : "part", "wall s", "CPU s");
    for (const Row& row : rows) {
      if (row.is_command == are_commands)
        std::printf("%-24s %9.3f %9.3f\n", row.step.c_str(), row.cost.wall, row.cost.cpu);
    }
  }
}

nlohmann::ordered_json json_of(int runs, const std::vector<Row>& rows) {
  nlohmann::ordered_json json{{"runs", runs}, {"rows", nlohmann::json::array()}};
  for (const Row& row : rows) {
    json["rows"].push_back(
        {{"step", row.step}, {"wall_s", row.cost.wall}, {"cpu_s", row.cost.cpu}});
  }
  return json;
}

}  // namespace

int run_sweeps(const SweepsOptions& options) {
  ManyRuns sweep(options.runs);
  sweep.measure();
  if (options.json) {
    std::printf("%s\n", json_of(options.runs, sweep.rows()).dump(2).c_str());
  } else {
    print_table(options.runs, sweep.rows());
  }
  if (sweep.is_complete()) return 0;
  std::fprintf(stderr, "%d of %d runs are done\n", sweep.done(), options.runs);
  return 1;
}

}  // namespace weft::bench
