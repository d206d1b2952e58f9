// Outputs of sweeps: `[outputs]` of sweep files, and `weft sweep collect`.
#include <nlohmann/json.hpp>

#include "sim/command/run_command.h"
#include "tests/sim/weft_process.h"

namespace weft::sim::sweep_collect_test {
namespace {

constexpr const char* base_case = R"_([time]
duration = 0.05
[contact]
enabled = false
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [4, 4] }
[[body.pin]]
edges = ["first_row"]
[outputs]
low = "min(lower('sheet').z)"
cost = "last(steps)"
)_";

constexpr const char* densities = R"_(case = "base.toml"
[factors]
"world.gravity.2" = { list = [-5, -10] }
"time.duration" = { list = [0.04, 0.05] }
[outputs]
stretch = "max(largest_stretch)"
cost = "duration"
)_";

class SweepCollect : public WeftCommand {
 protected:
  SweepCollect() {
    write("base.toml", base_case);
    write("sweep.toml", densities);
  }
  // Returns the cells of a file of comma-separated values without quotes.
  std::vector<std::vector<std::string>> table(const std::string& name) const {
    std::vector<std::vector<std::string>> rows;
    std::ifstream file(path(name));
    for (std::string line; std::getline(file, line);) {
      auto& row = rows.emplace_back(1);
      bool is_quoted = false;
      for (const char byte : line) {
        if (byte == '"') {
          is_quoted = !is_quoted;
        } else if (byte == ',' && !is_quoted) {
          row.emplace_back();
        } else {
          row.back() += byte;
        }
      }
    }
    return rows;
  }
  std::vector<std::string> column(const std::string& name) const {
    const auto rows = table("out/sweep/summary.csv");
    const auto place = std::ranges::find(rows.at(0), name) - rows[0].begin();
    std::vector<std::string> cells;
    for (std::size_t i = 1; i < rows.size(); ++i)
      cells.push_back(rows[i].at(static_cast<std::size_t>(place)));
    return cells;
  }
};

// The plan knows the sweep file wherever the command runs, and says when it is gone.
TEST_F(SweepCollect, FindsTheSweepFileFromAnyFolder) {
  ASSERT_EQ(weft({"sweep", "sweep.toml", "--quiet"}).code, 0);
  write("sweep.toml", std::string(densities) + "added = \"frames\"\n");
  const auto collect = [&] {
    return weft({"sweep", "collect", path("out/sweep").string(), "--json"},
                [] { std::filesystem::current_path("/"); });
  };
  const Result found = collect();
  ASSERT_EQ(found.code, 0) << found.err;
  EXPECT_EQ(found.err, "");
  EXPECT_EQ(table("out/sweep/summary.csv").at(0).at(10), "added");
  std::filesystem::remove(path("sweep.toml"));
  const Result gone = collect();
  EXPECT_EQ(gone.code, 0);
  EXPECT_EQ(gone.err, "weft: there is no " + path("sweep.toml").string() +
                          " any more; the outputs are those that it had (another may be named "
                          "after the folder)\n");
}

TEST_F(SweepCollect, SummarisesTheOutputsOfCaseAndSweep) {
  const Result run = weft({"sweep", "sweep.toml", "--quiet"});
  ASSERT_EQ(run.code, 0) << run.err;
  const auto rows = table("out/sweep/summary.csv");
  EXPECT_EQ(rows.at(0),
            (std::vector<std::string>{"run", "hash", "status", "failure", "reason",
                                      "world.gravity.2", "time.duration", "low", "cost", "stretch",
                                      "wall_s", "cpu_s", "peak_memory_mib", "weft_version"}));
  // The sweep's output `cost` replaces that of the case.
  EXPECT_EQ(column("cost"), (std::vector<std::string>{"0.04", "0.05", "0.04", "0.05"}));
  // Twice the gravity sags nearly twice as deep.
  const std::vector<std::string> low = column("low");
  EXPECT_NEAR(std::stod(low[3]) / std::stod(low[1]), 2, 0.1);
  // The values are those of `weft outputs` on the trajectory.
  const Result direct = weft({"outputs", "out/sweep/runs/" + rows[1][1] + "/run.h5", "--json",
                              "s = max(largest_stretch)"});
  EXPECT_EQ(std::stod(rows[1][9]), nlohmann::json::parse(direct.out)["s"].get<double>());
  for (const char* name : {"summary.h5", "correlations.csv", "plots/low-time.duration.svg",
                           "plots/stretch-world.gravity.2.svg"}) {
    EXPECT_TRUE(exists("out/sweep/" + std::string(name))) << name;
  }
}

TEST_F(SweepCollect, AnswersNewQuestionsWithoutRunningAgain) {
  ASSERT_EQ(weft({"sweep", "sweep.toml", "--quiet"}).code, 0);
  const auto read_all = [&] {
    return read_bytes(path("out/sweep/summary.csv")) + read_bytes(path("out/sweep/summary.h5")) +
           read_bytes(path("out/sweep/correlations.csv"));
  };
  const std::string before = read_all();
  // Collecting again gives the same bytes, times included: they are those of the runs.
  ASSERT_EQ(weft({"sweep", "collect", "out/sweep"}).code, 0);
  EXPECT_EQ(read_all(), before);
  write("sweep.toml", std::string(densities) + "fall = \"lowr('sheet')\"\n");
  const Result wrong = weft({"sweep", "collect", "out/sweep"});
  EXPECT_EQ(wrong.code, exit_code::bad_case);
  EXPECT_EQ(wrong.err, "sweep.toml:8:9: unknown function \"lowr\"\n  did you mean \"lower\"?\n");
  EXPECT_EQ(read_all(), before);
  write("new.toml", "case = \"base.toml\"\n[outputs]\nwidth = \"last(size('sheet').x)\"\n");
  const Result added = weft({"sweep", "collect", "out/sweep", "new.toml", "--json"});
  ASSERT_EQ(added.code, 0) << added.err;
  EXPECT_EQ(nlohmann::json::parse(added.out)["outputs"],
            (std::vector<std::string>{"low", "cost", "width"}));
  EXPECT_NEAR(std::stod(column("width").at(0)), 0.1, 1e-3);
  EXPECT_FALSE(exists("out/sweep/plots/stretch-time.duration.svg"));
  // Nothing has run: the results are as old as they were.
  EXPECT_EQ(weft({"sweep", "sweep.toml", "--dry-run", "--json"}).out.find("not begun"),
            std::string::npos);
}

TEST_F(SweepCollect, RemovesNoPlotsOfOthers) {
  ASSERT_EQ(weft({"sweep", "sweep.toml", "--quiet"}).code, 0);
  write("out/sweep/plots/mine.svg", "<svg>mine</svg>");
  std::filesystem::create_directory(path("out/sweep/plots/folder.svg"));
  write("new.toml", "case = \"base.toml\"\n[outputs]\nwidth = \"last(size('sheet').x)\"\n");
  const Result result = weft({"sweep", "collect", "out/sweep", "new.toml"});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(read_bytes(path("out/sweep/plots/mine.svg")), "<svg>mine</svg>");
  EXPECT_TRUE(exists("out/sweep/plots/folder.svg"));
  EXPECT_FALSE(exists("out/sweep/plots/stretch-time.duration.svg"));
  EXPECT_TRUE(exists("out/sweep/plots/width-time.duration.svg"));
}

TEST_F(SweepCollect, RefusesOutputsBeforeARunBegins) {
  write("sweep.toml", std::string(densities) + "a = \"max(largest_strech)\"\n");
  const Result refused = weft({"sweep", "sweep.toml"});
  EXPECT_EQ(refused.code, exit_code::bad_case);
  EXPECT_EQ(refused.err,
            "sweep.toml:8:10: unknown name \"largest_strech\"\n  did you mean "
            "\"largest_stretch\"?\n");
  const Result estimate = weft({"sweep", "estimate", "sweep.toml"});
  EXPECT_EQ(estimate.code, exit_code::bad_case);
  EXPECT_EQ(estimate.err, refused.err);
  EXPECT_FALSE(exists("out"));
}

// Results have the outputs, so that trajectories may be removed.
TEST_F(SweepCollect, KeepsOutputsOfRunsWithoutTrajectories) {
  ASSERT_EQ(weft({"sweep", "sweep.toml", "--quiet"}).code, 0);
  const std::string before = read_bytes(path("out/sweep/summary.csv"));
  for (const auto& run : std::filesystem::directory_iterator(path("out/sweep/runs")))
    std::filesystem::remove(run.path() / "run.h5");
  const std::vector<WeftProcess::Arguments> commands = {{"sweep", "sweep.toml", "--quiet"},
                                                        {"sweep", "collect", "out/sweep"}};
  for (const WeftProcess::Arguments& command : commands) {
    std::filesystem::remove(path("out/sweep/summary.csv"));
    const Result result = weft(command);
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_EQ(result.err, "");
    EXPECT_EQ(read_bytes(path("out/sweep/summary.csv")), before);
  }
  // A new question has no answer.
  write("sweep.toml", std::string(densities) + "width = \"last(size('sheet').x)\"\n");
  ASSERT_EQ(weft({"sweep", "collect", "out/sweep"}).code, 0);
  EXPECT_EQ(column("width"), (std::vector<std::string>(4)));
  EXPECT_EQ(column("cost"), (std::vector<std::string>{"0.04", "0.05", "0.04", "0.05"}));
}

// The result of a run has its outputs, even if its trajectory can no longer be read.
TEST_F(SweepCollect, KeepsOutputsOfRunsWithDamagedTrajectories) {
  ASSERT_EQ(weft({"sweep", "sweep.toml", "--quiet"}).code, 0);
  const std::string before = read_bytes(path("out/sweep/summary.csv"));
  for (const auto& run : std::filesystem::directory_iterator(path("out/sweep/runs")))
    std::ofstream(run.path() / "run.h5") << "damaged";
  const Result result = weft({"sweep", "collect", "out/sweep"});
  EXPECT_EQ(result.code, 0);
  EXPECT_NE(result.err.find("run.h5: "), std::string::npos) << result.err;
  EXPECT_EQ(read_bytes(path("out/sweep/summary.csv")), before);
}

// The hash of a run does not depend on its outputs: what is done stays done.
TEST_F(SweepCollect, RunsNothingAgainForNewOutputs) {
  ASSERT_EQ(weft({"sweep", "sweep.toml", "--quiet"}).code, 0);
  const std::vector<std::string> hashes = column("hash");
  write("base.toml", std::string(base_case) + "more = \"max(energy_kinetic)\"\n");
  const Result again = weft({"sweep", "sweep.toml", "--dry-run", "--json"});
  const auto runs = nlohmann::json::parse(again.out)["runs"];
  ASSERT_EQ(runs.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(runs[i]["status"], "done");
    EXPECT_EQ(runs[i]["hash"].get<std::string>().substr(0, 16), hashes[i]);
  }
}

}  // namespace
}  // namespace weft::sim::sweep_collect_test
