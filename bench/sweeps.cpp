// Cost of planning, listing and looking at a sweep of many runs, without the runs.
#include <cstdio>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "bench/experiments.h"
#include "bench/temporary_folder.h"
#include "sim/base/stopwatch.h"
#include "sim/sweep/plan_file.h"
#include "sim/sweep/run_folder.h"
#include "sim/sweep/sweep_outputs.h"
#include "sim/sweep/sweep_reader.h"
#include "sim/sweep/sweep_records.h"
#include "sim/sweep/to_do_list.h"

namespace weft::bench {

namespace {

using namespace weft::sim;

constexpr const char* base_case = R"([contact]
friction = 0.3
[material.cotton]
density = 0.2
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [33, 33] }
[[obstacle]]
name = "ball"
position = [0, 0, -0.5]
shape = { type = "sphere", radius = 0.3, resolution = [17] }
)";

std::string sweep_text(int runs) {
  return "case = \"base.toml\"\n[factors]\n"
         "\"contact.friction\" = { uniform = [0.1, 0.5] }\n"
         "\"material.cotton.density\" = { log_uniform = [0.1, 0.4] }\n"
         "\"material.cotton.bending_stiffness\" = { log_uniform = [1e-6, 1e-4] }\n"
         "\"time.duration\" = { uniform = [0.1, 0.5] }\n"
         "[sample]\nmethod = \"sobol\"\nruns = " +
         std::to_string(runs) + "\n";
}

void write(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

struct Row {
  std::string step;
  Cost cost;
};

// Writes the result of a run that took no time.
void write_result(const std::string& folder, const PlannedRun& run) {
  const RunFolder run_folder(folder, run.hash);
  std::optional<RunAttempt> attempt = run_folder.begin(run.case_text);
  RunResult result;
  result.hash = run.hash;
  result.version = "bench";
  if (attempt) run_folder.finish(std::move(*attempt), result);
}

}  // namespace

int run_sweeps(const SweepsOptions& options) {
  const TemporaryFolder folder;
  write(folder.path("base.toml"), base_case);
  write(folder.path("sweep.toml"), sweep_text(options.runs));
  std::vector<Row> rows;
  const auto measure = [&](const char* step, const std::function<void()>& work) {
    const Stopwatch stopwatch;
    work();
    rows.push_back({step, stopwatch.elapsed()});
  };
  SweepPlan plan;
  std::vector<RunRecord> records;
  measure("plan", [&] { plan = plan_sweep(read_sweep(folder.path("sweep.toml"))); });
  measure("write plan", [&] { write_plan(folder.path(), plan); });
  measure("read plan", [&] { plan = read_plan(folder.path()); });
  measure("status, none begun", [&] { records = read_records(folder.path(), plan); });
  measure("freeze list", [&] {
    write_to_do_list(to_do_path(folder.path()), plan, runs_to_do(folder.path(), plan, false));
  });
  measure("write results", [&] {
    for (const PlannedRun& run : plan.runs) write_result(folder.path(), run);
  });
  measure("status, all done", [&] { records = read_records(folder.path(), plan); });
  OutputCollector collector(folder.path(), joined_outputs(plan.case_outputs, plan.sweep_outputs));
  measure("summary", [&] { write_summary(folder.path(), plan, records, collector); });
  const int done = count_records(records).done;

  nlohmann::ordered_json json{{"runs", options.runs}, {"rows", nlohmann::json::array()}};
  if (!options.json)
    std::printf("%d runs\n%-20s %9s %9s\n", options.runs, "step", "wall s", "CPU s");
  for (const Row& row : rows) {
    json["rows"].push_back(
        {{"step", row.step}, {"wall_s", row.cost.wall}, {"cpu_s", row.cost.cpu}});
    if (!options.json)
      std::printf("%-20s %9.3f %9.3f\n", row.step.c_str(), row.cost.wall, row.cost.cpu);
  }
  if (options.json) std::printf("%s\n", json.dump(2).c_str());
  if (done == static_cast<int>(plan.runs.size())) return 0;
  std::fprintf(stderr, "%d of %zu runs are done\n", done, plan.runs.size());
  return 1;
}

}  // namespace weft::bench
