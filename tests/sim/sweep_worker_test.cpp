// Several workers on one sweep: what each of them takes, who ends whose run, and how they stop.
#include <hdf5.h>
#include <sys/resource.h>

#include <atomic>
#include <nlohmann/json.hpp>
#include <set>

#include "sim/base/file_error.h"
#include "sim/command/run_command.h"
#include "sim/sweep/run_folder.h"
#include "sim/sweep/stop_schedule.h"
#include "sim/sweep/to_do_list.h"
#include "tests/sim/same_datasets.h"
#include "tests/sim/weft_process.h"

namespace weft::sim::sweep_worker_test {
namespace {

using Json = nlohmann::json;
using std::chrono::seconds;
namespace fs = std::filesystem;

constexpr const char* base_case = R"(
[time]
duration = 0.02
[output]
checkpoint_every = 0.02
[material.cotton]
density = 0.2
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [9, 9] }
[[body.pin]]
corners = ["first_first"]
)";

constexpr const char* densities = R"(case = "base.toml"
[factors]
"material.cotton.density" = { range = [0.1, 0.4], count = 4 }
)";

// One run, of some seconds.
constexpr const char* long_run = R"(case = "base.toml"
[factors]
"time.duration" = { list = [3] }
)";

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// A case whose shape is in a file beside it.
constexpr const char* case_of_file = R"(
[time]
duration = 0.02
[output]
checkpoint_every = 0.02
[[body]]
name = "sheet"
shape = { type = "file", path = "shape.h5", dataset = "p" }
[[body.pin]]
corners = ["first_first"]
)";

constexpr const char* long_run_of_file = R"_(case = "of_file.toml"
[factors]
"time.duration" = { list = [3] }
[outputs]
width = "first(size('sheet').x)"
)_";

// Waits until the condition holds, at most half a minute.
void wait_until(const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + seconds(30);
  while (!condition()) {
    ASSERT_LT(std::chrono::steady_clock::now(), end);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

class SweepWorkerTest : public WeftCommand {
 protected:
  SweepWorkerTest() { write("base.toml", base_case); }

  // Returns the files of a name in the folders of runs and of their attempts.
  std::vector<fs::path> files(const std::string& out, const std::string& name) const {
    std::vector<fs::path> found;
    if (!exists(out + "/runs")) return found;
    std::error_code vanished;  // workers move files at the same time
    for (fs::recursive_directory_iterator each(path(out) / "runs", vanished), end; each != end;
         each.increment(vanished)) {
      if (each->path().filename() == name) found.push_back(each->path());
    }
    return found;
  }
  // Writes a square of that side into a file, which replaces a former one at once.
  void write_shape(const std::string& name, double side) const {
    constexpr int rows = 9;
    std::vector<double> points;
    for (int i = 0; i < rows * rows; ++i)
      points.insert(points.end(),
                    {side * (i % rows) / (rows - 1), side * (i / rows) / (rows - 1), 0});
    const std::string aside = path(name + ".new").string();
    const hsize_t sizes[] = {rows, rows, 3};
    const hid_t file = H5Fcreate(aside.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t space = H5Screate_simple(3, sizes, nullptr);
    const hid_t dataset =
        H5Dcreate2(file, "p", H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, points.data());
    H5Dclose(dataset);
    H5Sclose(space);
    H5Fclose(file);
    fs::rename(aside, path(name));
  }
  // Starts a command, and stops it once its run has written a checkpoint and `bytes` of frames.
  void interrupt(const std::vector<std::string>& words, const std::string& out,
                 std::uintmax_t bytes = 0) const {
    const auto size = [&] {
      std::error_code vanished;
      const std::vector<fs::path> found = files(out, "run.h5");
      const auto result = found.empty() ? 0 : fs::file_size(found[0], vanished);
      return vanished ? 0 : result;
    };
    WeftProcess sweep(folder(), words);
    wait_until([&] { return !files(out, "run.checkpoint").empty() && size() >= bytes; });
    sweep.send(SIGTERM);
    EXPECT_EQ(sweep.wait(), 128 + SIGTERM) << sweep.err();
    ASSERT_EQ(files(out, "run.checkpoint").size(), 1U);
  }
  // Returns the time at which the only run of a folder went on, or null.
  Json resumed_at(const std::string& out) const {
    const Json result = Json::parse(read_bytes(files(out, "result.json").at(0)));
    return result.at("report").at("resumed_at_s");
  }
  std::string lasting_summary(const std::string& out) const {
    std::ifstream file(path(out) / "summary.csv");
    std::string all;
    for (std::string line; std::getline(file, line);) {
      for (int i = 0; i < 4; ++i) line.erase(line.rfind(','));
      all += line + '\n';
    }
    return all;
  }
  void expect_same_trajectories(const std::string& one, const std::string& other) const {
    const std::vector<fs::path> all = files(one, "run.h5");
    EXPECT_FALSE(all.empty());
    for (const fs::path& each : all) {
      const fs::path twin = path(other) / "runs" / each.parent_path().filename() / "run.h5";
      EXPECT_EQ(differing_datasets(each.string(), twin.string()), std::vector<std::string>());
    }
  }
  // Kills a command, but not its run, once that has written a checkpoint. Then the next command
  // goes on with the run.
  void kill_and_go_on(const std::vector<std::string>& words, const std::string& out) const {
    {
      WeftProcess worker(folder(), words);
      wait_until([&] { return !files(out, "run.checkpoint").empty(); });
      worker.send(SIGKILL);
      EXPECT_EQ(worker.wait(), -SIGKILL);
    }
    wait_until([&] { return processes_with(path(out).string() + "/runs/").empty(); });
    ASSERT_EQ(files(out, "run.checkpoint").size(), 1U);
    EXPECT_TRUE(files(out, "result.json").empty());
    const Json report = Json::parse(read_bytes(files(out, "report.json").at(0)));
    EXPECT_EQ(report.at("status"), "interrupted");
    EXPECT_EQ(report.at("reason"), "stopped by SIGTERM");
    const Result next = weft(words);
    EXPECT_EQ(next.code, 0) << next.err;
    EXPECT_TRUE(contains(read_bytes(files(out, "log.txt").at(0)), "goes on from the checkpoint"));
  }
};

TEST_F(SweepWorkerTest, RunsEndWithACheckpointWhenTheirWorkerIsKilled) {
  write("sweep.toml", long_run);
  ASSERT_EQ(weft({"sweep", "sweep.toml", "-o", "whole", "--quiet"}).code, 0);
  const std::string out = path("swept").string(), worked = path("worked").string();
  kill_and_go_on({"sweep", "sweep.toml", "-o", out, "--quiet"}, "swept");
  expect_same_trajectories("whole", "swept");
  ASSERT_EQ(weft({"sweep", "plan", "sweep.toml", "-o", worked}).code, 0);
  kill_and_go_on({"sweep", "work", worked, "--quiet"}, "worked");
  expect_same_trajectories("whole", "worked");
}

// On a full disk nothing more can be written. What was there stays, and a later call goes on.
TEST_F(SweepWorkerTest, AFullDiskCostsNoCheckpoint) {
  write("sweep.toml",
        std::string(long_run) + R"("body.sheet.shape.resolution" = { list = [[17, 17]] }
)");
  const std::vector<std::string> words{"sweep", "sweep.toml", "-o", path("out").string(),
                                       "--quiet"};
  constexpr rlim_t most_bytes = 1 << 17;
  interrupt(words, "out", 2 * most_bytes);
  const std::string checkpoint = read_bytes(files("out", "run.checkpoint").at(0));
  const Result full = weft(words, [] {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{most_bytes, RLIM_INFINITY};
    setrlimit(RLIMIT_FSIZE, &limit);
  });
  EXPECT_EQ(full.code, exit_code::some_runs_failed) << full.err;
  EXPECT_TRUE(contains(full.out, "input_output") && contains(full.out, "cannot write")) << full.out;
  ASSERT_EQ(files("out", "run.checkpoint").size(), 1U);
  EXPECT_EQ(read_bytes(files("out", "run.checkpoint")[0]), checkpoint);
  EXPECT_GE(fs::file_size(files("out", "run.h5").at(0)), most_bytes);
  std::vector<std::string> again = words;
  again.insert(again.end(), {"--rerun", "failed"});
  const Result roomy = weft(again);
  EXPECT_EQ(roomy.code, 0) << roomy.err;
  EXPECT_GT(resumed_at("out"), 0);
}

// A checkpoint from which no run can go on is given up, with a word.
TEST_F(SweepWorkerTest, ADamagedOrForeignCheckpointIsGivenUp) {
  write("sweep.toml", long_run);
  const std::vector<std::string> words{"sweep", "sweep.toml", "-o", path("out").string()};
  const auto give_up = [&](const std::string& bytes, const std::string& reason) {
    interrupt(words, "out");
    std::ofstream(files("out", "run.checkpoint").at(0), std::ios::binary) << bytes;
    const Result next = weft(words);
    EXPECT_EQ(next.code, 0) << next.err;
    EXPECT_TRUE(contains(next.err, "begins anew, since it cannot go on from its checkpoint: "))
        << next.err;
    EXPECT_TRUE(contains(next.err, reason)) << next.err;
    EXPECT_EQ(resumed_at("out"), nullptr);
    fs::remove_all(path("out"));
  };
  ASSERT_EQ(weft({"run", "base.toml", "--quiet"}).code, 0);
  const std::string foreign = read_bytes(path("out/base.checkpoint"));
  fs::remove_all(path("out"));
  give_up(foreign, "--resume: ");
  give_up("weft checkpoint 0", "is not a checkpoint of this version of Weft");
  give_up(foreign.substr(0, foreign.size() - 1), "run.checkpoint: is damaged");
}

// The shape of a run may be on a disk that is not there. Its run waits for it.
TEST_F(SweepWorkerTest, AMissingShapeCostsNoCheckpoint) {
  write("of_file.toml", case_of_file);
  write("sweep.toml", long_run_of_file);
  write_shape("shape.h5", 0.125);
  const std::vector<std::string> words{"sweep", "sweep.toml", "-o", path("out").string(),
                                       "--quiet"};
  interrupt(words, "out");
  const std::string checkpoint = read_bytes(files("out", "run.checkpoint").at(0));
  fs::rename(path("shape.h5"), path("away.h5"));
  const Result without = weft({"sweep", "work", path("out").string(), "--json"});
  EXPECT_EQ(without.code, exit_code::some_runs_failed);
  const std::string reason =
      path("shape.h5").string() + ": cannot be read: No such file or directory";
  EXPECT_TRUE(contains(without.err, "weft: " + reason + '\n')) << without.err;
  const Json json = Json::parse(without.out);
  EXPECT_EQ(json.at("input_faults"), Json({reason}));
  EXPECT_EQ(json.at("counts").at("interrupted"), 1);
  EXPECT_EQ(read_bytes(files("out", "run.checkpoint").at(0)), checkpoint);
  fs::rename(path("away.h5"), path("shape.h5"));
  EXPECT_EQ(weft(words).code, 0);
  EXPECT_GT(resumed_at("out"), 0);
}

// Results are those of the files that their hashes know: a run whose shape changes has none.
TEST_F(SweepWorkerTest, AChangedShapeGivesNoResult) {
  write("of_file.toml", case_of_file);
  write("sweep.toml", R"_(case = "of_file.toml"
[factors]
"time.duration" = { list = [0.02, 0.04] }
[outputs]
width = "first(size('sheet').x)"
)_");
  write_shape("shape.h5", 0.125);
  const std::string out = path("out").string();
  ASSERT_EQ(weft({"sweep", "plan", "sweep.toml", "-o", out}).code, 0);
  write_shape("shape.h5", 0.25);
  const Result work = weft({"sweep", "work", out});
  EXPECT_EQ(work.code, exit_code::some_runs_failed);
  const std::string reason =
      path("shape.h5").string() + " has changed since the sweep was planned; call weft sweep again";
  EXPECT_TRUE(contains(work.err, "not begun: " + reason)) << work.err;
  EXPECT_TRUE(contains(work.err, "weft: " + reason)) << work.err;
  EXPECT_TRUE(contains(work.out, "2 runs: 2 not begun")) << work.out;
  EXPECT_EQ(weft({"sweep", "sweep.toml", "-o", out}).code, 0);
  EXPECT_TRUE(contains(lasting_summary("out"), ",done,,,0.04,0.25\n")) << lasting_summary("out");
  // A file that is written anew with the bytes it had is as planned.
  ASSERT_EQ(weft({"sweep", "plan", "sweep.toml", "-o", path("new").string()}).code, 0);
  fs::copy_file(path("shape.h5"), path("copy.h5"));
  fs::rename(path("copy.h5"), path("shape.h5"));
  EXPECT_EQ(weft({"sweep", "work", path("new").string()}).code, 0);
}

// The shape changes after the run has begun, with the shape of before or that of after.
TEST_F(SweepWorkerTest, AShapeThatChangesDuringARunGivesNoResult) {
  write("of_file.toml", case_of_file);
  write("sweep.toml", long_run_of_file);
  write_shape("shape.h5", 0.125);
  const std::string out = path("out").string();
  {
    WeftProcess sweep(folder(), {"sweep", "sweep.toml", "-o", out});
    wait_until([&] { return !files("out", "run.checkpoint").empty(); });
    write_shape("shape.h5", 0.25);
    sweep.send(SIGINT);
    EXPECT_EQ(sweep.wait(), 128 + SIGINT);
    EXPECT_TRUE(contains(sweep.out(), "1 run: 1 not begun")) << sweep.out();
  }
  EXPECT_TRUE(files("out", "run.checkpoint").empty());
  write("sweep.toml", R"(case = "of_file.toml"
[factors]
"time.duration" = { list = [10] }
)");
  WeftProcess whole(folder(), {"sweep", "sweep.toml", "-o", out});
  wait_until([&] { return !files("out", "run.checkpoint").empty(); });
  write_shape("shape.h5", 0.125);
  EXPECT_EQ(whole.wait(), exit_code::some_runs_failed);
  EXPECT_TRUE(contains(whole.err(), "has changed since the sweep was planned")) << whole.err();
  EXPECT_TRUE(files("out", "result.json").empty());
}

// A sweep that is killed leaves its run for a moment. The next one waits for it, and goes on.
TEST_F(SweepWorkerTest, WaitsForARunThatAnotherWorkerHolds) {
  write("sweep.toml", long_run);
  const std::string out = path("out").string();
  WeftProcess first(folder(), {"sweep", "sweep.toml", "-o", out, "--quiet"});
  wait_until([&] { return !files("out", "run.checkpoint").empty(); });
  fs::create_directory(path("elsewhere"));
  write("elsewhere/base.toml", base_case);
  write("elsewhere/sweep.toml", long_run);
  WeftProcess second(path("elsewhere"), {"sweep", "sweep.toml", "-o", out});
  wait_until([&] {
    return exists("elsewhere/stderr.txt") && contains(second.err(), "another worker is at it");
  });
  first.send(SIGTERM);
  EXPECT_EQ(first.wait(), 128 + SIGTERM);
  EXPECT_EQ(second.wait(), 0) << second.err();
  EXPECT_TRUE(contains(second.err(), "done in")) << second.err();
}

TEST_F(SweepWorkerTest, SlicesGoOverTheRunsStillToDo) {
  write("sweep.toml", densities);
  write("first.toml", R"(case = "base.toml"
[factors]
"material.cotton.density" = { list = [0.1, 0.3] }
)");
  ASSERT_EQ(weft({"sweep", "first.toml", "-o", "out", "--quiet"}).code, 0);
  const Result plan = weft({"sweep", "plan", "sweep.toml", "-o", "out"});
  EXPECT_EQ(plan.code, 0) << plan.err;
  EXPECT_TRUE(contains(plan.out, "4 runs: 2 done, 2 not begun")) << plan.out;
  EXPECT_TRUE(contains(plan.out, "2 runs to do, longest first, in out/to_do.json")) << plan.out;
  const auto work = [&](const std::string& slice) {
    return weft({"sweep", "work", "out", "--slice", slice, "--only-slice"});
  };
  // The list stays while its runs end: each slice has one of the two.
  const Result first = work("0/2");
  EXPECT_EQ(first.code, 0) << first.err;
  EXPECT_TRUE(contains(first.err, "[2/4]") && contains(first.err, "done")) << first.err;
  EXPECT_EQ(files("out", "result.json").size(), 3U);
  EXPECT_EQ(work("0/2").err, "");
  const Result second = work("1/2");
  EXPECT_TRUE(contains(second.err, "[4/4]")) << second.err;
  EXPECT_TRUE(contains(second.out, "4 runs: 4 done")) << second.out;
}

TEST_F(SweepWorkerTest, HelpsWithOtherSlicesWhenItsOwnIsDone) {
  write("sweep.toml", densities);
  ASSERT_EQ(weft({"sweep", "sweep.toml", "-o", "whole", "--quiet"}).code, 0);
  ASSERT_EQ(weft({"sweep", "plan", "sweep.toml", "-o", "out"}).code, 0);
  const Result worker = weft({"sweep", "work", "out", "--slice", "2/4", "-j", "1"});
  EXPECT_EQ(worker.code, 0) << worker.err;
  EXPECT_EQ(files("out", "result.json").size(), 4U);
  EXPECT_LT(worker.err.find("[3/4]"), worker.err.find("[1/4]")) << worker.err;
  EXPECT_EQ(lasting_summary("out"), lasting_summary("whole"));
}

TEST_F(SweepWorkerTest, RefusesAListOfAnotherPlan) {
  write("sweep.toml", densities);
  ASSERT_EQ(weft({"sweep", "plan", "sweep.toml", "-o", "out"}).code, 0);
  fs::copy_file(path("out/to_do.json"), path("list.json"));
  write("sweep.toml", long_run);
  ASSERT_EQ(weft({"sweep", "plan", "sweep.toml", "-o", "out"}).code, 0);
  const Result worker = weft({"sweep", "work", "out", "--list", "list.json"});
  EXPECT_EQ(worker.code, exit_code::input_output);
  EXPECT_TRUE(contains(worker.err, "which plan.json lacks")) << worker.err;
  write("list.json", "{\"to_do_format\": 1, \"runs\": 3}");
  const Result damaged = weft({"sweep", "work", "out", "--list", "list.json"});
  EXPECT_EQ(damaged.code, exit_code::input_output);
}

TEST_F(SweepWorkerTest, PutsLongRunsFirstAndInterruptedOnesBefore) {
  write("sweep.toml", R"(case = "base.toml"
[factors]
"time.duration" = { list = [0.01, 0.03, 0.02] }
"body.sheet.shape.resolution" = { list = [[3, 3], [5, 5]] }
)");
  ASSERT_EQ(weft({"sweep", "plan", "sweep.toml", "-o", "out"}).code, 0);
  const Json plan = Json::parse(read_bytes(path("out/plan.json"))).at("runs");
  const auto order = [&] {
    std::vector<std::size_t> indices;
    const Json list = Json::parse(read_bytes(path("out/to_do.json")));
    for (const Json& each : list.at("runs")) {
      for (std::size_t i = 0; i < plan.size(); ++i) {
        if (plan[i].at("hash") == each.at("hash")) indices.push_back(i);
      }
    }
    return indices;
  };
  // Vertices times seconds: 0.09, 0.25; 0.27, 0.75; 0.18, 0.5.
  EXPECT_EQ(order(), (std::vector<std::size_t>{3, 5, 2, 1, 4, 0}));
  const std::string hash = plan[4].at("hash");
  fs::create_directories(path("out/runs/" + hash.substr(0, 16) + "/attempt_of_another"));
  ASSERT_EQ(weft({"sweep", "plan", "sweep.toml", "-o", "out"}).code, 0);
  EXPECT_EQ(order(), (std::vector<std::size_t>{4, 3, 5, 2, 1, 0}));
}

// Failed runs are computed again once for each list, whoever comes to them.
TEST_F(SweepWorkerTest, ComputesAFailedRunAgainOnce) {
  write("sweep.toml", R"(case = "base.toml"
[set]
"time.duration" = 1
[factors]
"compute.cpu_limit" = { list = [1e-6] }
)");
  EXPECT_EQ(weft({"sweep", "sweep.toml", "-o", "out"}).code, exit_code::some_runs_failed);
  const Result without = weft({"sweep", "plan", "sweep.toml", "-o", "out"});
  EXPECT_TRUE(contains(without.out, "0 runs to do")) << without.out;
  const Result plan = weft({"sweep", "plan", "sweep.toml", "-o", "out", "--rerun", "failed"});
  EXPECT_TRUE(contains(plan.out, "1 run to do")) << plan.out;
  const Result first = weft({"sweep", "work", "out", "--slice", "0/2"});
  EXPECT_EQ(first.code, exit_code::some_runs_failed);
  EXPECT_TRUE(contains(first.err, "failed in")) << first.err;
  EXPECT_EQ(weft({"sweep", "work", "out", "--slice", "1/2"}).err, "");
}

TEST_F(SweepWorkerTest, ARunStopsAtItsNextCheckpointIfAsked) {
  const std::vector<std::string> words{"run", "base.toml", "--set", "time.duration=3", "--json"};
  std::vector<std::string> whole_words = words;
  whole_words.insert(whole_words.end(), {"-o", "whole"});
  ASSERT_EQ(weft(whole_words).code, 0);
  WeftProcess run(folder(), words);
  wait_for_file("out/base.checkpoint");
  run.send(SIGUSR1);
  EXPECT_EQ(run.wait(), 128 + SIGTERM) << run.err();
  const Json stopped = Json::parse(run.out());
  EXPECT_EQ(stopped.at("reason"), "stopped at a checkpoint, as asked by SIGUSR1");
  std::vector<std::string> resumed_words = words;
  resumed_words.emplace_back("--resume");
  const Result resumed = weft(resumed_words);
  EXPECT_EQ(resumed.code, 0) << resumed.err;
  // No step is computed again.
  EXPECT_EQ(Json::parse(resumed.out).at("resumed_at_s"), stopped.at("simulated_s"));
  EXPECT_EQ(differing_datasets(path("out/base.h5").string(), path("whole/base.h5").string()),
            std::vector<std::string>());
}

// The command keeps 2 of the 3 s for stopping. A run takes longer than the second that is left.
TEST_F(SweepWorkerTest, StopsInTimeAndTheNextCallGoesOn) {
  write("sweep.toml", R"(case = "base.toml"
[set]
"time.duration" = 20
"material.cotton.stiffness_damping" = 1e-3
[factors]
"material.cotton.density" = { list = [0.1, 0.4] }
)");
  ASSERT_EQ(weft({"sweep", "sweep.toml", "-o", "whole", "--quiet"}).code, 0);
  const std::vector<std::string> words{"sweep", "sweep.toml", "-o", "out", "-j", "1"};
  std::vector<std::string> short_words = words;
  short_words.insert(short_words.end(), {"--wall-time", "3"});
  const Result first = weft(short_words);
  EXPECT_EQ(first.code, 128 + SIGTERM) << first.err;
  EXPECT_TRUE(contains(first.out, "1 interrupted")) << first.out;
  EXPECT_TRUE(contains(first.out, "not begun")) << first.out;
  const Json stopped = Json::parse(read_bytes(files("out", "report.json").at(0)));
  EXPECT_EQ(stopped.at("reason"), "stopped at a checkpoint, as asked by SIGUSR1");
  const Result second = weft(words);
  EXPECT_EQ(second.code, 0) << second.err;
  EXPECT_EQ(lasting_summary("out"), lasting_summary("whole"));
  expect_same_trajectories("whole", "out");
}

TEST_F(SweepWorkerTest, RefusesImpossibleTimesAndThreads) {
  write("sweep.toml", densities);
  const Result time = weft({"sweep", "sweep.toml", "--wall-time", "-1"});
  EXPECT_EQ(time.code, exit_code::bad_case);
  EXPECT_TRUE(contains(time.err, "expected a positive number of seconds")) << time.err;
  const Result threads = weft({"sweep", "sweep.toml", "-j", "1", "--threads", "100000"});
  EXPECT_EQ(threads.code, exit_code::bad_case);
  EXPECT_TRUE(contains(threads.err, "--threads 100000: more threads than cores")) << threads.err;
}

// Many workers want the same runs at once; each run is ended by one of them.
TEST(RunFolderWorkers, ComputeEachRunOnce) {
  const TemporaryFolder folder;
  constexpr int workers = 6, runs = 60;
  std::vector<std::atomic<int>> ended(runs);
  std::vector<std::thread> threads;
  for (int worker = 0; worker < workers; ++worker) {
    threads.emplace_back([&] {
      for (int run = 0; run < runs; ++run) {
        RunResult result;
        result.hash = std::to_string(100 + run) + std::string(61, '0');
        const RunFolder place(folder.path(), result.hash);
        while (!place.result()) {
          std::optional<RunAttempt> attempt = place.begin("case\n");
          if (!attempt) continue;
          std::this_thread::yield();
          if (place.finish(std::move(*attempt), result)) ++ended[static_cast<std::size_t>(run)];
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const auto& count : ended) EXPECT_EQ(count, 1);
}

TEST(RunFolderWorkers, ReplaceTheFailureThatTheySaw) {
  const TemporaryFolder folder;
  RunResult result;
  result.hash = std::string(64, 'a');
  result.failure = RunResult::Failure::numerical;
  const RunFolder place(folder.path(), result.hash);
  EXPECT_EQ(place.result_mark(), "");
  EXPECT_EQ(place.state_without_result(), RunState::not_begun);
  {
    std::optional<RunAttempt> attempt = place.begin("case\n");
    ASSERT_TRUE(attempt);
    EXPECT_EQ(place.state_without_result(), RunState::running);
    EXPECT_FALSE(place.begin("case\n"));
  }
  EXPECT_EQ(place.state_without_result(), RunState::interrupted);
  ASSERT_TRUE(place.finish(*place.begin("case\n"), result));
  const std::string seen = place.result_mark();
  EXPECT_FALSE(place.begin("case\n"));
  result.attempts = 2;
  ASSERT_TRUE(place.finish(*place.begin("case\n", {.replaced = seen}), result));
  EXPECT_NE(place.result_mark(), seen);
  EXPECT_FALSE(place.begin("case\n", {.replaced = seen}));
  EXPECT_EQ(place.result()->attempts, 2);
  EXPECT_FALSE(fs::exists(place.path() / "in_use"));
}

// A worker may be killed after it has moved some of the files.
TEST(RunFolderWorkers, GoOnWithFilesThatWereMovedInPart) {
  const TemporaryFolder folder;
  const RunFolder place(folder.path(), std::string(64, 'b'));
  {
    std::optional<RunAttempt> attempt = place.begin("case\n");
    ASSERT_TRUE(attempt);
    std::ofstream(place.path() / "run.h5") << "frames";
    std::ofstream(attempt->folder() / "run.checkpoint") << "state";
  }
  std::optional<RunAttempt> next = place.begin("case\n");
  ASSERT_TRUE(next);
  EXPECT_TRUE(next->resumes());
  EXPECT_EQ(read_bytes(next->folder() / "run.h5"), "frames");
  EXPECT_EQ(read_bytes(next->folder() / "run.checkpoint"), "state");
  EXPECT_FALSE(fs::exists(place.path() / "run.h5"));
}

TEST(StopSchedule, KeepsATenthOfTheTimeForStopping) {
  using Phase = StopSchedule::Phase;
  const StopSchedule::Clock::time_point start{};
  const StopSchedule minutes(start + seconds(100), start);
  EXPECT_EQ(minutes.phase(start), Phase::running);
  EXPECT_EQ(minutes.phase(start + seconds(89)), Phase::running);
  EXPECT_EQ(minutes.phase(start + seconds(90)), Phase::last_checkpoints);
  EXPECT_EQ(minutes.phase(start + seconds(95)), Phase::stopping);
  const StopSchedule hours(start + seconds(7200), start);
  EXPECT_EQ(hours.phase(start + seconds(7200 - 91)), Phase::running);
  EXPECT_EQ(hours.phase(start + seconds(7200 - 90)), Phase::last_checkpoints);
  EXPECT_EQ(hours.phase(start + seconds(7200 - 45)), Phase::stopping);
  const StopSchedule passed(start + seconds(1), start);
  EXPECT_EQ(passed.phase(start), Phase::stopping);
}

TEST(StopSchedule, HeedsANoticeWhereTheEndIsNotKnown) {
  using Phase = StopSchedule::Phase;
  const StopSchedule::Clock::time_point start{};
  StopSchedule unknown(std::nullopt, start), known(start + seconds(1000), start);
  EXPECT_EQ(unknown.phase(start + seconds(1000000)), Phase::running);
  for (StopSchedule* each : {&unknown, &known}) each->heed_notice(start + seconds(10));
  unknown.heed_notice(start + seconds(20));  // a second notice does not prolong the time
  EXPECT_EQ(unknown.phase(start + seconds(10)), Phase::last_checkpoints);
  EXPECT_EQ(unknown.phase(start + seconds(40)), Phase::stopping);
  EXPECT_EQ(known.phase(start + seconds(40)), Phase::running);
}

}  // namespace
}  // namespace weft::sim::sweep_worker_test
