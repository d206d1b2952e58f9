// The command `weft sweep`: runs that end, fail, are killed and go on, and two workers at once.
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "sim/command/run_command.h"
#include "sim/sweep/sweep_reader.h"
#include "sim/trajectory/trajectory.h"
#include "tests/sim/weft_process.h"

namespace weft::sim::sweep_command_test {
namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

constexpr const char* base_case = R"(
[time]
duration = 0.02
[material.cotton]
density = 0.2
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [4, 4] }
[[body.pin]]
corners = ["first_first"]
)";

constexpr const char* densities = R"(case = "base.toml"
[factors]
"material.cotton.density" = { range = [0.1, 0.4], count = 4 }
)";

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class SweepCommandTest : public WeftCommand {
 protected:
  SweepCommandTest() { write("base.toml", base_case); }

  Json summary_json(const std::string& out) const {
    const Result status = weft({"sweep", "status", out, "--json"});
    EXPECT_EQ(status.code, 0) << status.err;
    return Json::parse(status.out);
  }
  // Returns the summary without times, memory and version, which are the last four fields.
  std::string lasting_summary(const std::string& out) const {
    std::ifstream file(path(out) / "summary.csv");
    std::string all;
    for (std::string line; std::getline(file, line);) {
      for (int i = 0; i < 4; ++i) line.erase(line.rfind(','));
      all += line + '\n';
    }
    return all;
  }
  std::vector<fs::path> results(const std::string& out) const {
    std::vector<fs::path> found;
    for (const fs::directory_entry& entry : fs::directory_iterator(path(out) / "runs")) {
      if (fs::exists(entry.path() / "result.json")) found.push_back(entry.path() / "result.json");
    }
    return found;
  }
  static void expect_same_frames(const fs::path& one, const fs::path& other) {
    const TrajectoryReader a(one.string()), b(other.string());
    ASSERT_EQ(a.frames(), b.frames()) << one;
    for (int f = 0; f < a.frames(); ++f) EXPECT_EQ(a.positions(0, f), b.positions(0, f)) << one;
  }
  // Waits until a process has `text` in its arguments, and returns its number.
  static pid_t wait_for_process(const std::string& text) {
    for (int i = 0; i < 6000; ++i) {
      const std::vector<pid_t> found = processes_with(text);
      if (!found.empty()) return found.front();
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ADD_FAILURE() << "no process has " << text;
    return -1;
  }
};

TEST_F(SweepCommandTest, ListsRunsAndWritesNothing) {
  write("sweep.toml", densities);
  const Result result = weft({"sweep", "sweep.toml", "--dry-run"});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_TRUE(contains(result.out, "material.cotton.density = 0.2")) << result.out;
  EXPECT_TRUE(contains(result.out, "4 runs: 4 not begun")) << result.out;
  EXPECT_FALSE(exists("out"));
  const Json json = Json::parse(weft({"sweep", "sweep.toml", "--dry-run", "--json"}).out);
  EXPECT_EQ(json.at("runs").size(), 4U);
  EXPECT_EQ(json.at("runs")[1].at("values").at("material.cotton.density"), 0.2);
  EXPECT_EQ(json.at("counts").at("not_begun"), 4);
}

TEST_F(SweepCommandTest, RunsOnceWhatHasNoResult) {
  write("sweep.toml", densities);
  const Result first = weft({"sweep", "sweep.toml", "-o", "out"});
  ASSERT_EQ(first.code, 0) << first.err;
  EXPECT_TRUE(contains(first.out, "4 runs: 4 done")) << first.out;
  EXPECT_TRUE(contains(first.err, "[3/4]")) << first.err;
  EXPECT_EQ(results("out").size(), 4U);
  for (const fs::path& result : results("out")) {
    EXPECT_TRUE(fs::exists(result.parent_path() / "run.h5"));
    EXPECT_EQ(std::distance(fs::directory_iterator(result.parent_path()), {}), 6) << result;
  }
  const std::string summary = read_bytes(path("out/summary.csv"));
  EXPECT_TRUE(summary.starts_with("run,hash,status,failure,reason,material.cotton.density,wall_s,"))
      << summary;

  // More runs into the same folder: those that are there are not computed again.
  write("sweep.toml", R"(case = "base.toml"
[factors]
"material.cotton.density" = { list = [0.5, 0.1, 0.4] }
)");
  const Result second = weft({"sweep", "sweep.toml", "-o", "out"});
  EXPECT_EQ(second.code, 0) << second.err;
  EXPECT_TRUE(contains(second.err, "[1/3]")) << second.err;
  EXPECT_FALSE(contains(second.err, "[2/3]")) << second.err;
  EXPECT_EQ(results("out").size(), 5U);
  EXPECT_TRUE(contains(second.out, "3 runs: 3 done")) << second.out;
}

// A run in a sweep is the run of `weft run` with the same overrides.
TEST_F(SweepCommandTest, RunsAreThoseOfWeftRun) {
  write("sweep.toml", densities);
  ASSERT_EQ(weft({"sweep", "sweep.toml", "-o", "out", "--quiet"}).code, 0);
  const std::string hash =
      summary_json("out").at("runs")[1].at("hash").get<std::string>().substr(0, 16);
  ASSERT_EQ(weft({"run", "base.toml", "--set", "material.cotton.density=0.2", "--quiet"}).code, 0);
  expect_same_frames(path("out/runs/" + hash + "/run.h5"), path("out/base.h5"));
}

// One run of each kind of failure among good ones. A crash is a signal from this test.
TEST_F(SweepCommandTest, NamesEachFailureAndEndsTheOthers) {
  write("sweep.toml", R"(case = "base.toml"
[limits]
time = 20
memory = 400
[sample]
method = "list"
[[run]]
set = { title = "good", "time.duration" = 0.02, "body.sheet.shape.resolution" = [4, 4], "body.sheet.material" = "cotton", "compute.cpu_limit" = 100 }
[[run]]
set = { title = "bad value", "time.duration" = 0.02, "body.sheet.shape.resolution" = [4, 4], "body.sheet.material" = "silk", "compute.cpu_limit" = 100 }
[[run]]
set = { title = "numerical", "time.duration" = 1e6, "body.sheet.shape.resolution" = [4, 4], "body.sheet.material" = "cotton", "compute.cpu_limit" = 0.1 }
[[run]]
set = { title = "over memory", "time.duration" = 1, "body.sheet.shape.resolution" = [1000, 1000], "body.sheet.material" = "cotton", "compute.cpu_limit" = 100 }
[[run]]
set = { title = "crash", "time.duration" = 1e6, "body.sheet.shape.resolution" = [5, 5], "body.sheet.material" = "cotton", "compute.cpu_limit" = 100 }
[[run]]
set = { title = "over time", "time.duration" = 1e6, "body.sheet.shape.resolution" = [4, 4], "body.sheet.material" = "cotton", "compute.cpu_limit" = 100 }
[[run]]
set = { title = "also good", "time.duration" = 0.02, "body.sheet.shape.resolution" = [4, 4], "body.sheet.material" = "cotton", "compute.cpu_limit" = 100 }
)");
  const std::string out = path("out").string();
  const Json plan = Json::parse(weft({"sweep", "sweep.toml", "--dry-run", "--json"}).out);
  const std::string crash = plan.at("runs")[4].at("hash").get<std::string>().substr(0, 16);
  WeftProcess sweep(folder(), {"sweep", "sweep.toml", "-o", out, "-j", "1"});
  const pid_t victim = wait_for_process(out + "/runs/" + crash + "/attempt_");
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  kill(victim, SIGSEGV);
  EXPECT_EQ(sweep.wait(), exit_code::some_runs_failed) << sweep.err();
  const std::string printed = sweep.out();  // which the next command replaces

  const Json runs = summary_json("out").at("runs");
  const std::vector<std::string> kinds{
      "", "bad_case", "numerical_failure", "over_memory", "signal", "over_time", ""};
  const std::vector<std::string> reasons{"",
                                         "sweep.toml:10:",
                                         "compute.cpu_limit",
                                         "more than limits.memory = 400 MiB",
                                         "ended by signal 11",
                                         "took longer than limits.time = 20 s",
                                         ""};
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    if (kinds[i].empty()) {
      EXPECT_EQ(runs[i].at("status"), "done") << runs[i];
      continue;
    }
    EXPECT_EQ(runs[i].at("failure"), kinds[i]) << runs[i];
    EXPECT_TRUE(contains(runs[i].at("reason"), reasons[i])) << runs[i];
    EXPECT_TRUE(contains(printed, reasons[i])) << printed;
  }
  EXPECT_TRUE(contains(printed, "7 runs: 2 done, 5 failed")) << printed;
  // The lines of a reason are joined by bars.
  EXPECT_TRUE(contains(printed, " | expected")) << printed;
  EXPECT_FALSE(contains(printed, "\\n")) << printed;
  const std::string table = read_bytes(path("out/summary.csv"));
  EXPECT_EQ(std::ranges::count(table, '\n'), 1 + 7) << table;

  // Failed runs are computed again only on request.
  const Result again = weft({"sweep", "sweep.toml", "-o", out});
  EXPECT_EQ(again.code, exit_code::some_runs_failed);
  EXPECT_EQ(again.err, "");
}

// A reason that names a place in the case of a run names the file that is there afterwards.
TEST_F(SweepCommandTest, ReasonsNameTheCaseOfTheRun) {
  write("sweep.toml", R"(case = "base.toml"
[factors]
"body.sheet.shape.size" = { list = [[1, 1], [1e200, 1]] }
"time.duration" = { list = [0.02] }
)");
  EXPECT_EQ(weft({"sweep", "sweep.toml", "-o", path("out").string()}).code,
            exit_code::some_runs_failed);
  const Json run = summary_json("out").at("runs")[1];
  const auto reason = run.at("reason").get<std::string>();
  const auto folder = path("out") / "runs" / run.at("hash").get<std::string>().substr(0, 16);
  EXPECT_TRUE(contains(reason, (folder / "run.toml").string() + ":")) << reason;
  EXPECT_TRUE(exists(folder / "run.toml"));
}

TEST_F(SweepCommandTest, RerunsFailedRunsOnRequest) {
  write("sweep.toml", R"(case = "base.toml"
[set]
"time.duration" = 1
[factors]
"compute.cpu_limit" = { list = [1e-6, 100] }
)");
  EXPECT_EQ(weft({"sweep", "sweep.toml", "-o", "out"}).code, exit_code::some_runs_failed);
  EXPECT_EQ(weft({"sweep", "sweep.toml", "-o", "out"}).err, "");
  const Result rerun = weft({"sweep", "sweep.toml", "-o", "out", "--rerun", "failed"});
  EXPECT_TRUE(contains(rerun.err, "[1/2]")) << rerun.err;
  EXPECT_FALSE(contains(rerun.err, "[2/2]")) << rerun.err;
  EXPECT_EQ(rerun.code, exit_code::some_runs_failed);
}

TEST_F(SweepCommandTest, RetriesCrashesAsOftenAsAsked) {
  write("sweep.toml", R"(case = "base.toml"
[factors]
"time.duration" = { list = [1e6] }
)");
  const std::string out = path("out").string();
  WeftProcess sweep(folder(), {"sweep", "sweep.toml", "-o", out, "--retry", "2"});
  std::set<pid_t> killed;
  while (killed.size() < 3) {
    const pid_t victim = wait_for_process(out + "/runs/");
    if (victim > 0 && killed.insert(victim).second) kill(victim, SIGKILL);
  }
  EXPECT_EQ(sweep.wait(), exit_code::some_runs_failed);
  EXPECT_TRUE(contains(sweep.err(), "attempt 3")) << sweep.err();
  const fs::path result = results("out").at(0);
  EXPECT_EQ(Json::parse(read_bytes(result)).at("attempts"), 3);
}

TEST_F(SweepCommandTest, StopsAtTheFirstFailureIfAsked) {
  write("sweep.toml", R"(case = "base.toml"
[sample]
method = "list"
[[run]]
set = { "compute.cpu_limit" = 1e-6, "time.duration" = 1 }
[[run]]
set = { "compute.cpu_limit" = 1000, "time.duration" = 1e6 }
[[run]]
set = { "compute.cpu_limit" = 1000, "time.duration" = 1 }
)");
  const Result result = weft({"sweep", "sweep.toml", "-o", "out", "--fail-fast", "-j", "2"});
  EXPECT_EQ(result.code, exit_code::some_runs_failed);
  EXPECT_TRUE(contains(result.out, "3 runs: 1 failed, 1 interrupted, 1 not begun")) << result.out;
}

TEST_F(SweepCommandTest, CtrlCStopsRunsAndTheNextCallGoesOn) {
  const auto write_sweep = [&](const std::string& durations) {
    write("sweep.toml",
          "case = \"base.toml\"\n[factors]\n\"time.duration\" = { list = " + durations + " }\n");
  };
  const std::string out = path("out").string();
  write_sweep("[0.02]");
  ASSERT_EQ(weft({"sweep", "sweep.toml", "-o", out, "--quiet"}).code, 0);
  write_sweep("[0.02, 1e6]");
  WeftProcess sweep(folder(), {"sweep", "sweep.toml", "-o", out, "-j", "1"});
  wait_for_process(out + "/runs/");
  EXPECT_EQ(summary_json("out").at("counts").at("running"), 1);
  sweep.send(SIGINT);
  EXPECT_EQ(sweep.wait(), 130);
  const std::string printed = sweep.out();  // which the next command replaces
  EXPECT_TRUE(processes_with(out).empty());
  EXPECT_EQ(summary_json("out").at("counts").at("interrupted"), 1);
  EXPECT_TRUE(contains(printed, "1 done, 1 interrupted")) << printed;
}

// Everything is killed at random times, and the sweep is called again until it ends.
TEST_F(SweepCommandTest, LosesNoRunWhenEverythingIsKilled) {
  write("sweep.toml", R"(case = "base.toml"
[set]
"time.duration" = 2
[factors]
"material.cotton.density" = { uniform = [0.1, 0.4] }
"material.cotton.membrane_stiffness" = { log_uniform = [100, 1000] }
[sample]
method = "sobol"
runs = 16
)");
  ASSERT_EQ(weft({"sweep", "sweep.toml", "-o", "whole", "--quiet"}).code, 0);
  const std::string out = path("killed").string();
  std::mt19937 random(20240301);
  std::map<fs::path, std::string> seen;  // bytes of the results so far
  for (int trial = 0; trial < 3; ++trial) {
    WeftProcess sweep(folder(), {"sweep", "sweep.toml", "-o", out, "--quiet"});
    wait_for_process(out + "/runs/");
    std::this_thread::sleep_for(std::chrono::milliseconds(random() % 300));
    sweep.send(SIGKILL);
    for (const pid_t process : processes_with(out)) kill(process, SIGKILL);
    sweep.wait();
    for (const fs::path& result : results("killed")) seen.emplace(result, read_bytes(result));
  }
  const Result last = weft({"sweep", "sweep.toml", "-o", out, "--quiet"});
  EXPECT_EQ(last.code, 0) << last.err;
  EXPECT_EQ(results("killed").size(), 16U);
  EXPECT_LT(seen.size(), 16U);  // a kill came before the end
  for (const auto& [result, bytes] : seen) EXPECT_EQ(read_bytes(result), bytes) << "done twice";
  for (const fs::path& result : results("killed")) {
    const fs::path folder = result.parent_path();
    expect_same_frames(folder / "run.h5", path("whole") / "runs" / folder.filename() / "run.h5");
  }
  EXPECT_EQ(lasting_summary("killed"), lasting_summary("whole"));
}

// Two commands on one folder share its runs.
TEST_F(SweepCommandTest, TwoWorkersDoNoHarm) {
  write("sweep.toml", R"(case = "base.toml"
[set]
"time.duration" = 1
[factors]
"material.cotton.density" = { range = [0.1, 0.4], count = 10 }
)");
  ASSERT_EQ(weft({"sweep", "sweep.toml", "-o", "whole", "--quiet"}).code, 0);
  const std::string out = path("shared").string();
  WeftProcess one(folder(), {"sweep", "sweep.toml", "-o", out, "--quiet", "-j", "1"});
  fs::create_directory(path("elsewhere"));
  write("elsewhere/base.toml", base_case);
  fs::copy_file(path("sweep.toml"), path("elsewhere/sweep.toml"));
  WeftProcess two(path("elsewhere"), {"sweep", "sweep.toml", "-o", out, "--quiet", "-j", "1"});
  EXPECT_EQ(one.wait(), 0) << one.err();
  EXPECT_EQ(two.wait(), 0) << two.err();
  EXPECT_EQ(weft({"sweep", "sweep.toml", "-o", out, "--quiet"}).code, 0);
  EXPECT_EQ(lasting_summary("shared"), lasting_summary("whole"));
}

TEST_F(SweepCommandTest, SlicesCoverThePlan) {
  write("sweep.toml", densities);
  const std::string out = path("out").string();
  EXPECT_EQ(weft({"sweep", "work", out, "--slice", "0/2"}).code, exit_code::input_output);
  ASSERT_EQ(weft({"sweep", "sweep.toml", "-o", "whole", "--quiet"}).code, 0);
  ASSERT_EQ(weft({"sweep", "plan", "sweep.toml", "-o", out}).code, 0);
  const auto work = [&](const std::string& slice) {
    return weft({"sweep", "work", out, "--slice", slice, "--only-slice"});
  };
  const Result first = work("0/3");
  EXPECT_EQ(first.code, 0) << first.err;
  EXPECT_EQ(results("out").size(), 2U);  // runs 1 and 4
  EXPECT_EQ(work("1/3").code, 0);
  EXPECT_EQ(work("2/3").code, 0);
  EXPECT_EQ(results("out").size(), 4U);
  EXPECT_EQ(lasting_summary("out"), lasting_summary("whole"));
  EXPECT_EQ(work("3/3").code, exit_code::bad_case);
}

TEST_F(SweepCommandTest, EstimatesTheCostOfAllRunsByAFew) {
  write("sweep.toml", R"(case = "base.toml"
[factors]
"material.cotton.density" = { range = [0.1, 0.4], count = 100 }
)");
  const Result result = weft({"sweep", "estimate", "sweep.toml", "-o", "out", "--pilots", "2"});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_TRUE(contains(result.out, "2 of 100 runs as pilots, 2 of them done")) << result.out;
  EXPECT_EQ(results("out").size(), 2U);
  const Json json = Json::parse(
      weft({"sweep", "estimate", "sweep.toml", "-o", "out", "--pilots", "2", "--json"}).out);
  double cpu = 0, disk = 0;
  for (const fs::path& pilot : results("out")) {
    cpu += Json::parse(read_bytes(pilot)).at("cpu_s").get<double>();
    for (const auto& file : fs::directory_iterator(pilot.parent_path()))
      disk += static_cast<double>(file.file_size());
  }
  EXPECT_NEAR(json.at("cpu_hours").get<double>(), 50 * cpu / 3600, 1e-12);
  EXPECT_NEAR(json.at("disk_bytes").get<double>(), 50 * disk, 1);
  EXPECT_GT(json.at("peak_memory_mib"), 1);
}

// Pilots differ in the factor that decides about the cost, wherever it stands in the grid, and in
// others that change as fast.
TEST_F(SweepCommandTest, EstimatesByRunsThatDiffer) {
  const std::string friction = "\"contact.friction\" = { list = [0.1, 0.2, 0.3] }\n",
                    density = "\"material.cotton.density\" = { list = [0.1, 0.2] }\n",
                    duration = "\"time.duration\" = { list = [0.02, 0.04] }\n";
  const std::array grids{friction + duration, duration + friction, friction + density};
  for (std::size_t i = 0; i < grids.size(); ++i) {
    const std::string out = "out" + std::to_string(i);
    write("sweep.toml", "case = \"base.toml\"\n[factors]\n" + grids[i]);
    const Result result = weft({"sweep", "estimate", "sweep.toml", "-o", out});
    ASSERT_EQ(result.code, 0) << result.err;
    std::set<std::string> values;  // of the factor with two values
    for (const fs::path& pilot : results(out)) {
      const std::string text = read_bytes(pilot.parent_path() / "run.toml");
      std::string both;
      for (const char* key : {"\nduration", "\ndensity"}) {
        const std::size_t line = text.find(key);
        ASSERT_NE(line, std::string::npos) << text;
        both += text.substr(line, text.find('\n', line + 1) - line);
      }
      values.insert(both);
    }
    EXPECT_EQ(values.size(), 2U) << grids[i];
  }
}

TEST_F(SweepCommandTest, RefusesBadFilesAndOptions) {
  write("sweep.toml", "case = \"base.toml\"\n[factors]\n\"contact.frictoin\" = { list = [0.1] }\n");
  const Result result = weft({"sweep", "sweep.toml"});
  EXPECT_EQ(result.code, exit_code::bad_case);
  EXPECT_EQ(result.err,
            "sweep.toml:3:1: unknown key \"frictoin\" in [contact]\n  did you mean "
            "\"friction\"?\n");
  EXPECT_FALSE(exists("out"));
  EXPECT_EQ(weft({"sweep"}).code, exit_code::bad_case);
  EXPECT_EQ(weft({"sweep", "absent.toml"}).code, exit_code::bad_case);
  EXPECT_EQ(weft({"sweep", "status", "absent"}).code, exit_code::input_output);
  write("good.toml", densities);
  const Result jobs = weft({"sweep", "good.toml", "-j", "100000"});
  EXPECT_EQ(jobs.code, exit_code::bad_case);
  EXPECT_TRUE(contains(jobs.err, "-j 100000: more runs at a time than cores")) << jobs.err;
  for (const char* name : {"run", "hash", "reason", "cpu_s", "weft_version"}) {
    write("named.toml", std::string(densities) + "[outputs]\n" + name + " = \"last(time)\"\n");
    const Result named = weft({"sweep", "named.toml"});
    EXPECT_EQ(named.code, exit_code::bad_case);
    EXPECT_TRUE(contains(named.err, std::string("the output \"") + name +
                                        "\" has the name of a column of every summary\n"
                                        "  expected another name\n"))
        << named.err;
    EXPECT_TRUE(contains(named.err, "named.toml:5:")) << named.err;
  }
  EXPECT_FALSE(exists("out"));
}

TEST_F(SweepCommandTest, PrintsTheReferencePageOfTheDocumentation) {
  const Result page = weft({"schema", "--sweep", "--markdown"});
  EXPECT_EQ(page.code, 0);
  EXPECT_EQ(page.out, read_bytes(WEFT_SOURCE_DIR "/docs/sweep_reference.md"));
  const Result schema = weft({"schema", "--sweep"});
  EXPECT_EQ(schema.out, sweep_json_schema());
  EXPECT_EQ(Json::parse(schema.out).at("properties").at("sample").at("type"), "object");
}

}  // namespace
}  // namespace weft::sim::sweep_command_test
