// Options of `weft sweep`, its limits, its summary and its live table, on real runs.
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <termios.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "sim/command/run_command.h"
#include "sim/sweep/local_engine.h"
#include "sim/sweep/plan_file.h"
#include "sim/sweep/to_do_list.h"
#include "tests/sim/weft_process.h"

namespace weft::sim::sweep_options_test {
namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

constexpr const char* base_case = R"(
[time]
duration = 0.02
[contact]
enabled = false
[material.cotton]
density = 0.2
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [4, 4] }
[[body.pin]]
corners = ["first_first"]
)";

class SweepOptions : public WeftCommand {
 protected:
  SweepOptions() { write("base.toml", base_case); }

  // Returns the results of the sweep in the folder `out`, by the names of their folders.
  std::vector<Json> results(const std::string& out = "out") const {
    std::vector<Json> found;
    if (!exists(out + "/runs")) return found;
    for (const fs::directory_entry& entry : fs::directory_iterator(path(out) / "runs")) {
      if (fs::exists(entry.path() / "result.json"))
        found.push_back(Json::parse(read_bytes(entry.path() / "result.json")));
    }
    return found;
  }
  // Returns the arguments and the environment of the process of a run in the folder `out` of this
  // test. Waits until there is one.
  std::pair<std::string, std::string> wait_for_run() const {
    const std::string runs = (path("out") / "runs").string();
    for (int i = 0; i < 6000; ++i) {
      for (const pid_t process : processes_with(runs))
        return {read_process_file(process, "cmdline"), read_process_file(process, "environ")};
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ADD_FAILURE() << "no run";
    return {};
  }
  std::string summary() const {
    return exists("out/summary.csv") ? read_bytes(path("out/summary.csv")) : "";
  }
};

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; ++at) ++count;
  return count;
}

TEST_F(SweepOptions, SetHasTheLastWordInAllRuns) {
  write("sweep.toml", R"(case = "base.toml"
[set]
"time.duration" = 1e6
"contact.friction" = 0.2
[factors]
"material.cotton.density" = { list = [0.1, 0.4] }
)");
  const Result result = weft(
      {"sweep", "sweep.toml", "--quiet", "--set", "time.duration=0.03", "--set", "title=both"});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  const std::vector<Json> all = results("out/sweep");
  ASSERT_EQ(all.size(), 2U);
  for (const Json& each : all) {
    EXPECT_EQ(each.at("report").at("simulated_s"), 0.03);
    EXPECT_EQ(each.at("report").at("title"), "both");
  }
  const Result varies =
      weft({"sweep", "sweep.toml", "--set", "material.cotton.density=0.3", "-o", "other"});
  EXPECT_EQ(varies.code, exit_code::bad_case);
  EXPECT_EQ(varies.err,
            "--set material.cotton.density=0.3: \"material.cotton.density\" varies in this sweep\n"
            "  expected a key that is no factor\n");
  EXPECT_FALSE(exists("other"));
}

TEST_F(SweepOptions, PrintsOneObjectInJson) {
  // Runs look at their CPU time at most once per millisecond. Undamped, they gain energy within
  // seconds, by rounding errors sooner or later.
  write("sweep.toml", R"(case = "base.toml"
[set]
"time.duration" = 0.5
[factors]
"compute.cpu_limit" = { list = [1e-6, 100] }
)");
  const Result result = weft({"sweep", "sweep.toml", "-o", "out", "--json", "--quiet"});
  EXPECT_EQ(result.code, exit_code::some_runs_failed);
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json.at("exit_code"), exit_code::some_runs_failed);
  EXPECT_EQ(json.at("counts").at("done"), 1);
  EXPECT_EQ(json.at("counts").at("failed"), 1);
  ASSERT_EQ(json.at("runs").size(), 1U);
  EXPECT_EQ(json.at("runs")[0].at("failure"), "numerical_failure");
  EXPECT_EQ(json.at("runs")[0].at("values").at("compute.cpu_limit"), 1e-6);
}

// Each run may use the cores that the number of runs leaves it.
TEST_F(SweepOptions, SharesTheCoresAmongRuns) {
  write("sweep.toml", "case = \"base.toml\"\n[factors]\n\"time.duration\" = { list = [1e6] }\n");
  const int cores = usable_cores();
  WeftProcess sweep(folder(), {"sweep", "sweep.toml", "-o", path("out").string(), "-j", "1"});
  const auto [arguments, environment] = wait_for_run();
  EXPECT_NE(environment.find("OMP_THREAD_LIMIT=" + std::to_string(cores)), std::string::npos);
  sweep.send(SIGTERM);
  EXPECT_EQ(sweep.wait(), 143) << sweep.err();
  const std::string text = "1 process of " + std::to_string(cores) + " thread";
  EXPECT_NE(sweep.out().find(text), std::string::npos) << sweep.out();
}

// A disk that is full for the trajectories, though not for the small files beside them.
TEST_F(SweepOptions, RetriesRunsThatCannotWrite) {
  write("sweep.toml", R"(case = "base.toml"
[set]
"time.frames_per_second" = 1000
"time.duration" = 0.1
[factors]
"body.sheet.shape.resolution" = { list = [[33, 33]] }
)");
  const auto limit_files = [] {
    const rlimit limit{300'000, 300'000};
    setrlimit(RLIMIT_FSIZE, &limit);
    std::signal(SIGXFSZ, SIG_IGN);  // writing fails instead
  };
  const Result full = weft({"sweep", "sweep.toml", "-o", "out", "--retry", "1"}, limit_files);
  EXPECT_EQ(full.code, exit_code::some_runs_failed);
  EXPECT_NE(full.err.find("attempt 2"), std::string::npos) << full.err;
  EXPECT_NE(full.out.find("input_output: "), std::string::npos) << full.out;
  ASSERT_EQ(results().size(), 1U);
  EXPECT_EQ(results()[0].at("failure"), "input_output");
  EXPECT_EQ(results()[0].at("attempts"), 2);
  const Result again = weft({"sweep", "sweep.toml", "-o", "out", "--rerun", "failed"});
  EXPECT_EQ(again.code, exit_code::done) << again.err;
  EXPECT_EQ(results()[0].at("status"), "done");
}

// A short run ends before the engine has looked at it.
TEST_F(SweepOptions, LimitsHoldForShortRuns) {
  const auto run_within = [&](const std::string& limit) {
    write("sweep.toml",
          "case = \"base.toml\"\n[factors]\n\"time.duration\" = { list = [0.001] }\n[limits]\n" +
              limit + "\n");
    const Result result =
        weft({"sweep", "sweep.toml", "-o", "out", "--quiet", "--rerun", "failed"});
    EXPECT_EQ(result.code, exit_code::some_runs_failed) << result.err;
    EXPECT_EQ(results().size(), 1U);
    return results().at(0);
  };
  const Json large = run_within("memory = 1");
  EXPECT_EQ(large.at("failure"), "over_memory");
  EXPECT_NE(large.at("reason").get<std::string>().find("more than limits.memory = 1 MiB"),
            std::string::npos)
      << large;
  const Json slow = run_within("time = 1e-9");
  EXPECT_EQ(slow.at("failure"), "over_time");
  EXPECT_EQ(slow.at("reason"), "took longer than limits.time = 1e-09 s");
}

// Limits are no part of a run's hash: with a longer one it goes on from its checkpoint.
TEST_F(SweepOptions, GoesOnWithARunThatWasOverItsTime) {
  const auto run_within = [&](const std::string& seconds) {
    write("sweep.toml",
          "case = \"base.toml\"\n[set]\n\"output.checkpoint_every\" = 0.01\n[factors]\n"
          "\"time.duration\" = { list = [1e6] }\n[limits]\ntime = " +
              seconds + "\n");
    const Result result =
        weft({"sweep", "sweep.toml", "-o", "out", "--quiet", "--rerun", "failed"});
    EXPECT_EQ(result.code, exit_code::some_runs_failed) << result.err;
    EXPECT_EQ(results().size(), 1U);
    return results().at(0);
  };
  const Json first = run_within("2");
  EXPECT_EQ(first.at("reason"), "took longer than limits.time = 2 s");
  EXPECT_TRUE(first.at("report").at("resumed_at_s").is_null());
  const Json second = run_within("4");
  EXPECT_EQ(second.at("reason"), "took longer than limits.time = 4 s");
  EXPECT_EQ(second.at("hash"), first.at("hash"));
  EXPECT_GT(second.at("report").at("resumed_at_s"), 0);
  EXPECT_GT(second.at("report").at("steps"), first.at("report").at("steps"));
  // Times are those of both attempts.
  EXPECT_EQ(second.at("wall_s"), second.at("report").at("wall_s"));
  EXPECT_GT(second.at("wall_s"), 4);
}

TEST_F(SweepOptions, RewritesTheSummaryAsRunsEnd) {
  write("sweep.toml", R"(case = "base.toml"
[set]
"material.cotton.mass_damping" = 5
[factors]
"time.duration" = { list = [0.02, 0.03, 1e6] }
[outputs]
end = "duration"
)");
  WeftProcess sweep(folder(),
                    {"sweep", "sweep.toml", "-o", path("out").string(), "-j", "2", "--quiet"});
  // The longest run begins first and does not end. Of the others, which go beside it, the last one
  // ends within the pause after the first summary.
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (count_of(summary(), ",done,") < 2 && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(count_of(summary(), ",done,"), 2U) << summary();
  EXPECT_EQ(count_of(summary(), ",running,"), 1U) << summary();
  EXPECT_EQ(count_of(summary(), ",0.03,0.03,"), 1U) << summary();  // factor and output
  sweep.send(SIGINT);
  EXPECT_EQ(sweep.wait(), 130);
  EXPECT_EQ(count_of(summary(), ",interrupted,"), 1U) << summary();
}

// On a terminal of 60 columns. The second run takes steps so short that it is at 0 % for a long
// time.
TEST_F(SweepOptions, ShowsALiveTable) {
  write("sweep.toml", R"(case = "base.toml"
[set]
"material.cotton.mass_damping" = 5
"time.maximum_step" = 1e-5
[factors]
"time.duration" = { list = [0.02, 1e3] }
)");
  const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
  ASSERT_TRUE(terminal >= 0 && grantpt(terminal) == 0 && unlockpt(terminal) == 0);
  const winsize size{24, 60, 0, 0};
  ASSERT_EQ(ioctl(terminal, TIOCSWINSZ, &size), 0);
  const std::string line = ptsname(terminal);
  WeftProcess sweep(folder(), {"sweep", "sweep.toml", "-o", path("out").string(), "-j", "2"},
                    [&] { dup2(open(line.c_str(), O_RDWR | O_NOCTTY), STDERR_FILENO); });
  std::string shown;
  std::array<char, 4096> part{};
  bool is_stopped = false;
  // read() fails once the last writer has closed the terminal.
  for (ssize_t count; (count = read(terminal, part.data(), part.size())) > 0;) {
    shown.append(part.data(), static_cast<std::size_t>(count));
    if (is_stopped || count_of(shown, "1 done, 1 running, remaining ") < 3) continue;
    sweep.send(SIGINT);
    is_stopped = true;
  }
  close(terminal);
  EXPECT_EQ(sweep.wait(), 130);
  EXPECT_NE(shown.find("(time.duration = 0.02) done in "), std::string::npos) << shown;
  EXPECT_NE(shown.find("  [2]   0 %  0:0"), std::string::npos) << shown;
  EXPECT_NE(shown.find("\033[2A\033[J"), std::string::npos) << "the table is not drawn anew";
  // Lines of the table are cut at the width, so that the next drawing erases all of them.
  for (std::size_t at = 0; (at = shown.find("  [2] ", at)) != std::string::npos; ++at) {
    const std::size_t last = shown.find_first_of("\r\n", at);
    EXPECT_LE(std::min(last, shown.size()) - at, 59U);
  }
}

// The error of each run is a quantity of the summary.
TEST_F(SweepOptions, MeasuresTheErrorOfItsRuns) {
  write("sweep.toml", R"_(case = "base.toml"
estimate_error = true
[factors]
"time.position_tolerance" = { list = [1e-4, 1e-6] }
[outputs]
error = "max(error_estimate_sheet)"
)_");
  const Result result = weft({"sweep", "sweep.toml", "-o", "out", "--quiet"});
  ASSERT_EQ(result.code, 0) << result.err;
  const Result direct = weft({"run", "base.toml", "--quiet", "--json", "--estimate-error", "--set",
                              "time.position_tolerance=1e-4"});
  const Json estimate = Json::parse(direct.out).at("error_estimate").at("bodies")[0];
  EXPECT_GT(estimate.at("largest_m"), 0);
  std::ifstream file(path("out/summary.csv"));
  std::vector<double> errors;
  for (std::string line; std::getline(file, line);) {
    if (line.find(",done,") == std::string::npos) continue;
    for (int i = 0; i < 4; ++i) line.erase(line.rfind(','));
    errors.push_back(std::stod(line.substr(line.rfind(',') + 1)));
  }
  ASSERT_EQ(errors.size(), 2U);
  EXPECT_EQ(errors[0], estimate.at("largest_m").get<double>());
  EXPECT_LT(errors[1], errors[0]);
}

// The plan, which the engine holds, is no part of the memory of its runs.
TEST_F(SweepOptions, MeasuresTheMemoryOfTheRunAlone) {
  write("sweep.toml", R"(case = "base.toml"
[factors]
"material.cotton.density" = { list = [0.1] }
)");
  ASSERT_EQ(weft({"sweep", "sweep.toml", "-o", "small", "--quiet"}).code, 0);
  const double alone = results("small").at(0).at("peak_memory_mib");
  SweepPlan plan = read_plan(path("small"));
  PlannedRun& refused = plan.runs.emplace_back(plan.runs[0]);
  refused.hash = std::string(64, '0');
  refused.refusal = std::string(60'000'000, 'x');
  write_plan(path("large"), plan);
  write_to_do_list(to_do_path(path("large")), plan, runs_to_do(path("large"), plan, false));
  const Result result = weft({"sweep", "work", "large", "--quiet", "--json"});
  EXPECT_EQ(result.code, exit_code::done) << result.err;
  const double beside_plan = results("large").at(0).at("peak_memory_mib");
  EXPECT_GT(alone, 1);
  EXPECT_LT(beside_plan, 1.5 * alone);
}

// Runs of unequal cost: their duration varies by a factor of five.
TEST_F(SweepOptions, EstimatesTheCostWithinAFactorOfTwo) {
  write("sweep.toml", R"(case = "base.toml"
[set]
"body.sheet.shape.resolution" = [17, 17]
"body.sheet.shape.size" = [1, 1]
[factors]
"time.duration" = { uniform = [0.1, 0.5] }
"material.cotton.density" = { log_uniform = [0.1, 0.4] }
[sample]
method = "sobol"
runs = 10
)");
  const Result first = weft({"sweep", "estimate", "sweep.toml", "-o", "out", "--json"});
  ASSERT_EQ(first.code, 0) << first.err;
  const Json estimate = Json::parse(first.out);
  EXPECT_EQ(estimate.at("pilots"), 3);
  ASSERT_EQ(weft({"sweep", "sweep.toml", "-o", "out", "--quiet"}).code, 0);
  double cpu = 0, memory = 0, disk = 0;
  for (const Json& each : results()) {
    cpu += each.at("cpu_s").get<double>() / 3600;
    memory = std::max(memory, each.at("peak_memory_mib").get<double>());
  }
  for (const auto& file : fs::recursive_directory_iterator(path("out/runs"))) {
    if (file.is_regular_file()) disk += static_cast<double>(file.file_size());
  }
  const auto expect_within_two = [&](const char* name, double measured) {
    const double ratio = estimate.at(name).get<double>() / measured;
    EXPECT_TRUE(0.5 < ratio && ratio < 2) << name << ": " << ratio;
  };
  expect_within_two("cpu_hours", cpu);
  expect_within_two("peak_memory_mib", memory);
  expect_within_two("disk_bytes", disk);
}

// A result that cannot be read is none: the run is computed again.
TEST_F(SweepOptions, ComputesARunWithADamagedResultAgain) {
  write("sweep.toml", R"(case = "base.toml"
[factors]
"material.cotton.density" = { list = [0.1, 0.2] }
)");
  ASSERT_EQ(weft({"sweep", "sweep.toml", "-o", "out", "--quiet"}).code, 0);
  const std::string hash = results().at(0).at("hash").get<std::string>().substr(0, 16);
  const std::string file = "out/runs/" + hash + "/result.json";
  const std::string whole = read_bytes(path(file));
  for (const std::string& damaged :
       {whole.substr(0, whole.size() / 2), std::string("{}"), std::string("[1]"), std::string()}) {
    write(file, damaged);
    const Result status = weft({"sweep", "status", "out"});
    EXPECT_EQ(status.out, "2 runs: 1 done, 1 not begun\n") << damaged;
  }
  const Result again = weft({"sweep", "sweep.toml", "-o", "out"});
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_EQ(count_of(again.err, "done in"), 1U) << again.err;
  EXPECT_EQ(results().size(), 2U);
}

}  // namespace
}  // namespace weft::sim::sweep_options_test
