// The folder of a sweep's results: `weft sweep` replaces only files that sweeps have written.
#include <algorithm>

#include "sim/command/run_command.h"
#include "tests/sim/weft_process.h"

namespace weft::sim::sweep_folder_test {
namespace {

namespace fs = std::filesystem;

constexpr const char* base_case = R"(
[time]
duration = 0.02
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [4, 4] }
)";

constexpr const char* durations = R"_(case = "base.toml"
[factors]
"time.duration" = { list = [0.01, 0.02] }
[outputs]
low = "min(lower('sheet').z)"
)_";

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class SweepFolder : public WeftCommand {
 protected:
  SweepFolder() {
    write("base.toml", base_case);
    write("sweep.toml", durations);
    fs::create_directories(path("out/plots"));
    fs::create_directories(path("out/slurm"));
  }

  // Writes a case whose particles lie at the points of the file out/summary.h5, and a sweep of it.
  void write_sweep_of_particles() const {
    write("particles.toml", R"(
[[particles]]
name = "grains"
radius = 0.01
positions = { type = "file", path = "out/summary.h5", dataset = "places" }
)");
    write("grains.toml", R"(case = "particles.toml"
[factors]
"time.duration" = { list = [0.01, 0.02] }
)");
  }

  std::ptrdiff_t files() const {
    return std::ranges::count_if(fs::recursive_directory_iterator(path("out")),
                                 [](const auto& entry) { return entry.is_regular_file(); });
  }
};

TEST_F(SweepFolder, FilesThatNoSweepHasWrittenStay) {
  for (const std::string name :
       {"out/plan.json", "out/to_do.json", "out/summary.csv", "out/summary.h5",
        "out/correlations.csv", "out/plots/mine.svg", "out/slurm/job.sh", "out/slurm/to_do.json"}) {
    write(name, "mine");
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{"sweep"}, {"sweep", "plan"}, {"sweep", "estimate"}}) {
      std::vector<std::string> arguments = command;
      arguments.insert(arguments.end(), {"sweep.toml", "-o", "out"});
      const Result result = weft(arguments);
      EXPECT_EQ(result.code, exit_code::input_output) << name;
      EXPECT_EQ(result.err, name +
                                ": exists already, in a folder without a plan of Weft, and is not "
                                "overwritten; name another folder (-o), or move the file\n");
    }
    EXPECT_EQ(read_bytes(path(name)), "mine");
    EXPECT_EQ(files(), 1) << name;
    fs::remove(path(name));
  }
}

// The plan is written first, so that a sweep goes on wherever it was interrupted.
TEST_F(SweepFolder, SweepsGoOnInTheirFolder) {
  write("out/notes.txt", "mine");  // a name that no sweep writes
  ASSERT_EQ(weft({"sweep", "plan", "sweep.toml", "-o", "out"}).code, exit_code::done);
  fs::remove(path("out/to_do.json"));
  for (int i = 0; i < 2; ++i) {
    const Result result = weft({"sweep", "sweep.toml", "-o", "out", "--quiet"});
    EXPECT_EQ(result.code, exit_code::done) << result.err;
  }
  EXPECT_TRUE(exists("out/plots/low-time.duration.svg"));
  EXPECT_EQ(read_bytes(path("out/notes.txt")), "mine");
  // Another version of Weft has planned into this folder.
  write("out/plan.json", "{\"plan_format\": 1000, \"weft_version\": \"9.0.0\"}");
  EXPECT_EQ(weft({"sweep", "sweep.toml", "-o", "out", "--quiet"}).code, exit_code::done);
}

TEST_F(SweepFolder, FilesThatTheSweepReadsStay) {
  write_sweep_of_particles();
  write("out/summary.h5", "places");
  const auto expect_refused = [&](const std::string& sweep, const std::string& file) {
    const std::string before = read_bytes(path(file));
    const Result result = weft({"sweep", sweep, "-o", "out"});
    EXPECT_EQ(result.code, exit_code::bad_case);
    EXPECT_EQ(result.err, file +
                              ": the sweep reads this file, which weft sweep would replace\n"
                              "  expected another folder for the results (-o), or another name "
                              "of the file\n");
    EXPECT_EQ(read_bytes(path(file)), before);
  };
  expect_refused("grains.toml", "out/summary.h5");
  // Also in the folder of an earlier sweep.
  write("out/plan.json", "{\"plan_format\": 1000}");
  expect_refused("grains.toml", "out/summary.h5");
  fs::remove(path("out/summary.h5"));
  write("out/summary.csv", base_case);
  write("case.toml", "case = \"out/summary.csv\"\n[factors]\n\"time.duration\" = { list = [1] }\n");
  expect_refused("case.toml", "out/summary.csv");
  write("out/summary.csv", "[material.wool]\ndensity = 0.3\n");
  write("base.toml", std::string(base_case) + "[[include]]\npath = \"out/summary.csv\"\n");
  expect_refused("sweep.toml", "out/summary.csv");
}

// Lines of the resolved case are not those of the sweep file. The run has its own file.
TEST_F(SweepFolder, FaultsOfShapeFilesBelongToTheirRuns) {
  write("bad.h5", "no HDF5");
  write("base.toml", R"(
[time]
duration = 0.02
[[body]]
name = "sheet"
shape = { type = "file", path = "bad.h5", dataset = "places" }
)");
  const Result result = weft({"sweep", "sweep.toml", "-o", "out", "--quiet"});
  EXPECT_EQ(result.code, exit_code::some_runs_failed);
  EXPECT_EQ(result.err, "");
  EXPECT_TRUE(contains(result.out, "bad_case: out/runs/")) << result.out;
  EXPECT_TRUE(contains(result.out, "/run.toml:")) << result.out;
  EXPECT_FALSE(contains(result.out, "sweep.toml:")) << result.out;
}

// Outputs are checked on the first run that can be set up.
TEST_F(SweepFolder, OutputsAreCheckedBesideDamagedShapes) {
  write("bad.h5", "no HDF5");
  const auto sweep = [&](const std::string& outputs) {
    write("sweep.toml", R"(case = "base.toml"
[factors]
"body.sheet.shape" = { list = [
  { type = "file", path = "bad.h5", dataset = "places" },
  { type = "rectangle", size = [0.1, 0.1], resolution = [4, 4] },
] }
[outputs]
)" + outputs);
    return weft({"sweep", "sweep.toml", "-o", "out", "--quiet"});
  };
  const Result bad = sweep("low = \"min(lower('shet').z)\"\n");
  EXPECT_EQ(bad.code, exit_code::bad_case) << bad.out;
  EXPECT_TRUE(contains(bad.err, "sweep.toml:8:")) << bad.err;
  EXPECT_FALSE(exists("out/plan.json"));
  const Result good = sweep("low = \"min(lower('sheet').z)\"\n");
  EXPECT_EQ(good.code, exit_code::some_runs_failed) << good.err;
  EXPECT_TRUE(contains(good.out, "2 runs: 1 done, 1 failed")) << good.out;
}

}  // namespace
}  // namespace weft::sim::sweep_folder_test
