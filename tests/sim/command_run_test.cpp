// `weft run`: its report, its file, how it stops, and that it uses no OpenGL.
#include <sys/ioctl.h>
#include <sys/resource.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "sim/command/run_command.h"
#include "sim/trajectory/trajectory.h"
#include "tests/sim/weft_process.h"

namespace weft::sim::command_run_test {
namespace {

constexpr const char* sheet_case = R"(title = "A sheet hangs from two corners"
[time]
duration = 0.1
[contact]
enabled = false
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [5, 5] }
[[body.pin]]
corners = ["last_first", "last_last"]
)";

// A plate comes down on a sheet held by its corners, faster than even the shortest step can
// resolve.
constexpr const char* squeeze_case = R"(
[time]
duration = 1.0
minimum_step = 5e-3
[world]
gravity = [0, 0, 0]
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [5, 5] }
[[body.pin]]
corners = ["all"]
[[obstacle]]
name = "press"
position = [0.001, 0.002, 0.01]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [5, 5] }
motion = { velocity = [0, 0, -1] }
[[obstacle]]
name = "table"
position = [0.003, 0.001, -0.005]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [5, 5] }
)";

class CommandRun : public WeftCommand {
 protected:
  // Returns the times of all frames; checks that positions are finite.
  static std::vector<double> frame_times(const std::filesystem::path& file) {
    const TrajectoryReader reader(file.string());
    std::vector<double> times;
    for (int frame = 0; frame < reader.frames(); ++frame) {
      times.push_back(reader.time(frame));
      for (const Vec3& position : reader.positions(0, frame)) EXPECT_TRUE(position.allFinite());
    }
    return times;
  }

  void expect_stop(int signal, int code) {
    write("sheet.toml", sheet_case);
    WeftProcess process(folder(), {"run", "sheet.toml", "--json", "--quiet", "--set",
                                   "time.duration=1e4", "--set", "time.frames_per_second=2000"});
    wait_for_file("out/sheet.h5");
    process.send(signal);
    EXPECT_EQ(process.wait(), code);
    const nlohmann::json report = nlohmann::json::parse(process.out());
    EXPECT_EQ(report.at("status"), "interrupted");
    const std::vector<double> times = frame_times(path("out/sheet.h5"));
    ASSERT_FALSE(times.empty());
    EXPECT_EQ(report.at("frames"), times.size());
    EXPECT_LE(times.back(), report.at("simulated_s").get<double>());
    EXPECT_LT(report.at("simulated_s"), 1e4);
  }
};

// libgomp reads how long its threads wait from the environment that the program is started with.
TEST_F(CommandRun, ThreadsThatWaitSoonGiveTheirProcessorAway) {
  write("sheet.toml", sheet_case);
  const auto environment = [&](const char* name, const char* value, const std::string& out) {
    WeftProcess process(folder(),
                        {"run", "sheet.toml", "--quiet", "-o", out, "--set", "time.duration=1e4",
                         "--set", "time.frames_per_second=2000"},
                        [&] {
                          unsetenv("OMP_WAIT_POLICY");
                          unsetenv("GOMP_SPINCOUNT");
                          setenv(name, value, 1);
                        });
    wait_for_file(out + "/sheet.h5");
    return process.environment();
  };
  for (const char* threads : {"1", "2"}) {
    EXPECT_NE(environment("OMP_NUM_THREADS", threads, threads).find("GOMP_SPINCOUNT=1000"),
              std::string::npos);
  }
  for (const auto& [name, value] :
       {std::pair("OMP_WAIT_POLICY", "active"), {"GOMP_SPINCOUNT", "77"}}) {
    EXPECT_EQ(environment(name, value, value).find("GOMP_SPINCOUNT=1000"), std::string::npos)
        << name;
  }
}

// A line longer than this terminal's 40 columns would wrap and leave remains on the screen.
TEST_F(CommandRun, ShowsItsProgressOnOneLineOfTheTerminal) {
  write("sheet.toml", sheet_case);
  const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
  ASSERT_TRUE(terminal >= 0 && grantpt(terminal) == 0 && unlockpt(terminal) == 0);
  const winsize size{24, 40, 0, 0};
  ASSERT_EQ(ioctl(terminal, TIOCSWINSZ, &size), 0);
  const std::string line = ptsname(terminal);
  WeftProcess process(folder(), {"run", "sheet.toml", "--set", "time.duration=1"},
                      [&] { dup2(open(line.c_str(), O_RDWR | O_NOCTTY), STDERR_FILENO); });
  std::string shown;
  std::array<char, 4096> part{};
  // read() fails once the last writer has closed the terminal.
  for (ssize_t count; (count = read(terminal, part.data(), part.size())) > 0;)
    shown.append(part.data(), static_cast<std::size_t>(count));
  close(terminal);
  EXPECT_EQ(process.wait(), exit_code::done);
  EXPECT_EQ(shown.find('\n'), std::string::npos) << shown;
  EXPECT_EQ(shown.rfind("\r[", 0), 0U) << shown;
  int lines = 0;
  for (std::size_t at = 0; (at = shown.find('\r', at)) != std::string::npos; ++lines) {
    const std::size_t end = shown.find('\033', ++at);
    ASSERT_NE(end, std::string::npos) << shown;
    EXPECT_LE(end - at, 39U) << shown;
  }
  EXPECT_GT(lines, 1);
}

TEST_F(CommandRun, ReportsInJson) {
  write("sheet.toml", sheet_case);
  const Result result = weft({"run", "sheet.toml", "--json"});
  EXPECT_EQ(result.code, exit_code::done);
  EXPECT_NE(result.err.find("100 %"), std::string::npos) << result.err;  // progress
  const nlohmann::json report = nlohmann::json::parse(result.out);       // and nothing else
  EXPECT_EQ(report.at("status"), "done");
  EXPECT_EQ(report.at("simulated_s"), 0.1);
  EXPECT_EQ(report.at("trajectory"), "out/sheet.h5");
  for (const char* key : {"wall_s", "cpu_s", "steps", "newton_iterations", "linear_iterations"}) {
    EXPECT_GT(report.at(key), 0) << key;
  }
  EXPECT_EQ(report.at("vetoed_steps"), 0);
  std::int64_t by_length = 0, by_limit = 0;
  for (const auto& part : report.at("step_lengths")) {
    EXPECT_LT(part.at("from_s"), part.at("to_s"));
    by_length += part.at("steps").get<std::int64_t>();
  }
  for (const auto& part : report.at("step_limits")) by_limit += part.get<std::int64_t>();
  EXPECT_EQ(by_length, report.at("steps"));
  EXPECT_EQ(by_limit, report.at("steps"));
  EXPECT_EQ(report.at("step_limits").at("contact_velocity_error"), 0);  // contact is off
  EXPECT_TRUE(report.at("smallest_gap").is_null());                     // no pair came into reach
  EXPECT_TRUE(report.at("largest_stretch").is_number());
  for (const char* key :
       {"rebuilds", "bound_tests", "candidate_pairs", "narrow_phase_calls", "ccd_calls"}) {
    EXPECT_EQ(report.at("counters").at(key), 0) << key;  // contact is off
  }
  for (const char* key : {"wall_rebuild", "wall_traverse", "wall_narrow_phase"}) {
    EXPECT_EQ(report.at("phases_s").at(key), 0) << key;
  }
  for (const char* key : {"wall_forces", "wall_linear_solve", "wall_energies", "wall_record"}) {
    EXPECT_GT(report.at("phases_s").at(key), 0) << key;
    EXPECT_LT(report.at("phases_s").at(key), report.at("wall_s")) << key;
  }
  EXPECT_EQ(frame_times(path("out/sheet.h5")).size(), report.at("frames"));
}

TEST_F(CommandRun, ReportsTheSmallestGap) {
  write("fall.toml", R"(
time.duration = 0.1
[[body]]
name = "sheet"
position = [0, 0, 0.012]
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [5, 5] }
[[obstacle]]
name = "floor"
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [3, 3] }
)");
  const Result result = weft({"run", "fall.toml", "--json", "--quiet"});
  EXPECT_EQ(result.err, "");
  const nlohmann::json report = nlohmann::json::parse(result.out);
  EXPECT_GT(report.at("smallest_gap"), 0);
  EXPECT_LT(report.at("smallest_gap"), 2e-3);  // contact.range: the floor carries the sheet
  for (const char* key : {"rebuilds", "bound_tests", "candidate_pairs", "narrow_phase_calls"}) {
    EXPECT_GT(report.at("counters").at(key), 0) << key;
  }
  EXPECT_TRUE(report.at("counters").at("ccd_calls").is_number_integer());
}

// Warnings say that a run is not what its case seems to ask for.
TEST_F(CommandRun, QuietHidesNoWarning) {
  write("sheet.toml", sheet_case);
  const WeftProcess::Arguments run{"run",     "sheet.toml", "--quiet",
                                   "--force", "--set",      "body.sheet.pin.0.hold_time=2"};
  const Result text = weft(run);
  EXPECT_EQ(text.code, exit_code::done);
  const std::string warning =
      R"(hold_time, 2 s, of a pin of body "sheet" is not within the run of 0.1 s: the pin never holds)";
  EXPECT_EQ(text.err, "weft: " + warning + '\n');

  WeftProcess::Arguments in_json = run;
  in_json.push_back("--json");
  const Result json = weft(in_json);
  EXPECT_EQ(json.err, text.err);
  EXPECT_EQ(nlohmann::json::parse(json.out).at("warnings"), nlohmann::json::array({warning}));
  const Result none = weft({"run", "sheet.toml", "--quiet", "--force", "--json"});
  EXPECT_EQ(none.err, "");
  EXPECT_EQ(nlohmann::json::parse(none.out).at("warnings"), nlohmann::json::array());
}

TEST_F(CommandRun, MeasuresItsError) {
  write("sheet.toml", sheet_case);
  const Result text = weft({"run", "sheet.toml", "--quiet", "--estimate-error"});
  EXPECT_EQ(text.code, exit_code::done);
  EXPECT_EQ(text.err, "");
  EXPECT_NE(text.out.find("estimated error (RMS)"), std::string::npos) << text.out;

  const Result result =
      weft({"run", "sheet.toml", "--quiet", "--json", "--estimate-error", "--force"});
  const nlohmann::json estimate = nlohmann::json::parse(result.out).at("error_estimate");
  EXPECT_EQ(estimate.at("bodies").at(0).at("body"), "sheet");
  EXPECT_GT(estimate.at("bodies").at(0).at("largest_m"), 0);
  EXPECT_EQ(estimate.at("last_time_s"), 0.1);
  EXPECT_TRUE(estimate.at("parted_time_s").is_null());
  EXPECT_GT(estimate.at("cpu_s"), 0);
}

TEST_F(CommandRun, WarnsWhereItsErrorMeansNothing) {
  write("sheet.toml", sheet_case);
  const Result result =
      weft({"run", "sheet.toml", "--quiet", "--estimate-error", "--set", "time.method=euler",
            "--set", "time.step=0.01", "--set", "time.newton=1", "--set", "time.duration=0.5"});
  EXPECT_EQ(result.code, exit_code::done);
  EXPECT_NE(result.err.find("weft: from t = "), std::string::npos) << result.err;
}

TEST_F(CommandRun, SaysThatAStepIsLongerThanAFrame) {
  write("sheet.toml", sheet_case);
  const std::vector<std::string> options{"sheet.toml",     "--set", "time.method=euler", "--set",
                                         "time.step=0.05", "--set", "time.newton=1"};
  for (const char* command : {"check", "run"}) {
    std::vector<std::string> arguments{command};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const Result result = weft(arguments);
    EXPECT_NE((result.out + result.err)
                  .find("time.step, 0.05 s, is longer than the time between frames, 0.0166667 s"),
              std::string::npos)
        << result.out << result.err;
  }
}

TEST_F(CommandRun, CountsAndLimitsThePilotOfAnAccuracy) {
  write("sheet.toml", sheet_case);
  const std::vector<std::string> run{
      "run", "sheet.toml", "--json", "--set", "time.accuracy=1e-3", "--set", "time.method=cvode"};
  const Result done = weft(run);
  EXPECT_EQ(done.code, exit_code::done) << done.err;
  EXPECT_NE(done.err.find("weft: pilot of time.accuracy: runs with"), std::string::npos);
  const nlohmann::json report = nlohmann::json::parse(done.out);
  for (const std::string clock : {"wall_s", "cpu_s"}) {
    double sum = 0;
    for (const char* part : {"setup_", "pilot_", "run_", "record_"}) {
      EXPECT_GT(report.at(part + clock), 0) << part;
      sum += report.at(part + clock).get<double>();
    }
    EXPECT_LE(sum, report.at(clock).get<double>() * (1 + 1e-12));
  }
  // RUSAGE_CHILDREN counts processes that have ended: only the command.
  rusage used;
  ASSERT_EQ(getrusage(RUSAGE_CHILDREN, &used), 0);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  EXPECT_LE(report.at("cpu_s"), seconds(used.ru_utime) + seconds(used.ru_stime) + 1e-4);
  std::vector<std::string> limited = run;
  limited.insert(limited.end(), {"--set", "compute.cpu_limit=1e-3", "-o", "limited"});
  const Result failed = weft(limited);
  EXPECT_EQ(failed.code, exit_code::numerical_failure);
  EXPECT_NE(failed.err.find("in the pilot run of time.accuracy: the limit of 0.001 s"),
            std::string::npos)
      << failed.err;
  EXPECT_FALSE(std::filesystem::exists(path("limited")));
}

// Linearly implicit steps of twice that length make the sheet gain energy.
TEST_F(CommandRun, StopsWhereTheMotionGainsEnergy) {
  write("sheet.toml", sheet_case);
  const Result result =
      weft({"run", "sheet.toml", "--json", "--quiet", "--set", "time.method=euler", "--set",
            "time.step=0.02", "--set", "time.newton=1", "--set", "time.duration=0.5"});
  EXPECT_EQ(result.code, exit_code::numerical_failure);
  const nlohmann::json report = nlohmann::json::parse(result.out);
  EXPECT_EQ(report.at("reason_kind"), "energy");
  const std::string reason = report.at("reason");
  EXPECT_NE(reason.find("gained energy"), std::string::npos) << reason;
  EXPECT_NE(reason.find("body \"sheet\""), std::string::npos) << reason;
  EXPECT_NE(reason.find("time.step is too long"), std::string::npos) << reason;
  // All recorded frames are from before the failure.
  const std::vector<double> times = frame_times(path("out/sheet.h5"));
  ASSERT_FALSE(times.empty());
  EXPECT_EQ(times.back(), report.at("simulated_s"));
  EXPECT_LT(times.back(), 0.04);
}

TEST_F(CommandRun, RefusesToMeasureTheErrorOfAnEquilibrium) {
  write("sheet.toml", sheet_case);
  const Result result =
      weft({"run", "sheet.toml", "--quiet", "--estimate-error", "--set", "time.method=static"});
  EXPECT_EQ(result.code, exit_code::bad_case);
  EXPECT_NE(result.err.find("--estimate-error: time.method"), std::string::npos) << result.err;
  EXPECT_FALSE(exists("out"));
}

TEST_F(CommandRun, OverwritesOnlyWhenTold) {
  write("sheet.toml", sheet_case);
  const WeftProcess::Arguments arguments = {"run", "sheet.toml", "--quiet", "-o", "deep/folder"};
  ASSERT_EQ(weft(arguments).code, exit_code::done);
  EXPECT_FALSE(exists("out"));
  const std::string trajectory = read_bytes(path("deep/folder/sheet.h5"));
  const std::string sidecar = read_bytes(path("deep/folder/sheet.xdmf"));

  const Result again = weft(arguments);
  EXPECT_EQ(again.code, exit_code::input_output);
  EXPECT_NE(again.err.find("deep/folder/sheet.h5"), std::string::npos) << again.err;
  EXPECT_NE(again.err.find("--force"), std::string::npos) << again.err;
  EXPECT_EQ(again.out, "");
  EXPECT_EQ(read_bytes(path("deep/folder/sheet.h5")), trajectory);
  EXPECT_EQ(read_bytes(path("deep/folder/sheet.xdmf")), sidecar);

  WeftProcess::Arguments forced = arguments;
  forced.insert(forced.end(), {"--force", "--set", "time.duration=0.05"});
  EXPECT_EQ(weft(forced).code, exit_code::done);
  EXPECT_EQ(frame_times(path("deep/folder/sheet.h5")).back(), 0.05);
}

TEST_F(CommandRun, OverridesAreTakenInAnyPlace) {
  write("sheet.toml", sheet_case);
  const Result result = weft({"run", "--set", "time.duration=0.03", "--set",
                              "time.frames_per_second=100", "sheet.toml", "--quiet", "--json"});
  ASSERT_EQ(result.code, exit_code::done) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out).at("frames"), 4);
}

// Root ignores permission bits, so the folder is an impossible one: below a file.
TEST_F(CommandRun, RefusesAFolderThatCannotBeMade) {
  write("sheet.toml", sheet_case);
  write("file", "");
  const Result result = weft({"run", "sheet.toml", "-o", "file/out"});
  EXPECT_EQ(result.code, exit_code::input_output);
  EXPECT_NE(result.err.find("file/out"), std::string::npos) << result.err;
}

// Frames that were committed before stay (Trajectory.KeepsWhatIsThereWhenTheDiskIsFull).
TEST_F(CommandRun, EndsWhereTheDiskIsFull) {
  write("sheet.toml", sheet_case);
  const auto limit_files = [] {
    const rlimit limit{400'000, 400'000};
    setrlimit(RLIMIT_FSIZE, &limit);
  };
  const Result result = weft({"run", "sheet.toml", "--json", "--quiet", "--set",
                              "time.frames_per_second=10000", "--set", "time.duration=10"},
                             limit_files);
  EXPECT_EQ(result.code, exit_code::input_output) << result.err;
  EXPECT_NE(result.err.find("out/sheet.h5"), std::string::npos) << result.err;
  EXPECT_NO_THROW(frame_times(path("out/sheet.h5")));
}

TEST_F(CommandRun, StopsAfterTheStepWhenInterrupted) { expect_stop(SIGINT, 130); }

TEST_F(CommandRun, StopsAfterTheStepWhenTerminated) { expect_stop(SIGTERM, 143); }

TEST_F(CommandRun, KeepsTheLastGoodStateOfAFailure) {
  write("squeeze.toml", squeeze_case);
  const Result result = weft({"run", "squeeze.toml", "--json", "--quiet"});
  EXPECT_EQ(result.code, exit_code::numerical_failure);
  const nlohmann::json report = nlohmann::json::parse(result.out);
  EXPECT_EQ(report.at("status"), "failed");
  const std::string reason = report.at("reason");
  for (const char* part : {"\"press\"", "at t = 0.001"}) {
    EXPECT_NE(reason.find(part), std::string::npos) << part << " is not in: " << reason;
  }
  EXPECT_EQ(result.err, "weft: " + reason + "\n");
  const std::vector<double> times = frame_times(path("out/squeeze.h5"));
  ASSERT_EQ(times.size(), 2U);  // the state at 0, and the last good one before the next frame
  EXPECT_EQ(times.back(), report.at("simulated_s"));
  EXPECT_NEAR(times.back(), 0.001, 1e-6);
}

TEST_F(CommandRun, EndsAtItsLimit) {
  write("sheet.toml", sheet_case);
  const Result result = weft({"run", "sheet.toml", "--json", "--quiet", "--set",
                              "time.duration=1e4", "--set", "compute.cpu_limit=0.02"});
  EXPECT_EQ(result.code, exit_code::numerical_failure);
  const nlohmann::json report = nlohmann::json::parse(result.out);
  EXPECT_EQ(report.at("status"), "failed");
  EXPECT_GT(report.at("cpu_s"), 0.02);
  const std::string reason = report.at("reason");
  for (const char* part : {"0.02 s", "compute.cpu_limit", "\"sheet\"", " at t = ", " steps"}) {
    EXPECT_NE(reason.find(part), std::string::npos) << part << " is not in: " << reason;
  }
  EXPECT_EQ(frame_times(path("out/sheet.h5")).back(), report.at("simulated_s"));
  EXPECT_LT(report.at("simulated_s"), 1e4);
}

// A load of an equilibrium is one step, which may take long.
TEST_F(CommandRun, EndsAtItsLimitWithinALoad) {
  write("sheet.toml", sheet_case);
  const Result result =
      weft({"run", "sheet.toml", "--json", "--quiet", "--set", "time.method=static", "--set",
            "body.sheet.shape.resolution=[65, 65]", "--set", "compute.cpu_limit=1e-3"});
  EXPECT_EQ(result.code, exit_code::numerical_failure);
  const nlohmann::json report = nlohmann::json::parse(result.out);
  EXPECT_NE(report.at("reason").get<std::string>().find("compute.cpu_limit"), std::string::npos);
  EXPECT_EQ(report.at("simulated_s"), 0);
  EXPECT_EQ(frame_times(path("out/sheet.h5")).size(), 1U);
}

// LD_DEBUG makes the dynamic linker log the libraries that a process loads.
TEST_F(CommandRun, LoadsOpenGLOnlyToSearchOnADevice) {
#ifdef WEFT_WITHOUT_GPU
  GTEST_SKIP() << "built without gpu/";
#endif
  write("sheet.toml", sheet_case);
  const auto libraries_of = [&](const WeftProcess::Arguments& arguments) {
    const auto log_libraries = [] {
      setenv("LD_DEBUG", "files", 1);
      setenv("LD_DEBUG_OUTPUT", "libraries", 1);
    };
    EXPECT_EQ(weft(arguments, log_libraries).code, exit_code::done);
    std::string text;
    for (const auto& entry : std::filesystem::directory_iterator(folder())) {
      if (!entry.path().filename().string().starts_with("libraries.")) continue;
      text += read_bytes(entry.path());
      std::filesystem::remove(entry.path());
    }
    return text;
  };
  const std::string of_run = libraries_of({"run", "sheet.toml", "--quiet"});
  const std::string of_render =
      libraries_of({"render", "out/sheet.h5", "--every", "100", "--width", "32", "--height", "32"});
  for (const std::string& text : {of_run, of_render}) {
    EXPECT_NE(text.find("libhdf5"), std::string::npos);
    EXPECT_EQ(text.find("libOSMesa"), std::string::npos);
    EXPECT_EQ(text.find("libGL"), std::string::npos);
  }
  const std::string of_search =
      libraries_of({"run", "sheet.toml", "--quiet", "--force", "--set", "contact.enabled=true",
                    "--set", "compute.backend=osmesa"});
  EXPECT_NE(of_search.find("libOSMesa"), std::string::npos);
}

}  // namespace
}  // namespace weft::sim::command_run_test
