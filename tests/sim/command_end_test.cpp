// The exit code, --json and the file report how a command ends.
#include <fcntl.h>

#include <array>
#include <csignal>
#include <nlohmann/json.hpp>
#include <set>

#include "sim/command/run_command.h"
#include "tests/sim/weft_process.h"

namespace weft::sim::command_end_test {
namespace {

using Json = nlohmann::json;

constexpr const char* sheet_case = R"(title = "A sheet hangs"
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

class CommandEnd : public WeftCommand {
 protected:
  void SetUp() override { write("sheet.toml", sheet_case); }
  Json info(const std::string& file = "out/sheet.h5") const {
    return Json::parse(weft({"info", file, "--json"}).out);
  }
  std::string info_text() const { return weft({"info", "out/sheet.h5"}).out; }
  // Its steps are short: long ones gain energy, which would end the run within 0.3 s.
  WeftProcess endless_run() const {
    return {folder(),
            {"run", "sheet.toml", "--json", "--quiet", "--set", "time.duration=1e4", "--set",
             "time.maximum_step=1e-5"}};
  }
};

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST_F(CommandEnd, DoneIsInTheFile) {
  const Json report =
      Json::parse(weft({"run", "sheet.toml", "--json", "--quiet", "--set", "time.duration=0.05",
                        "--set", "body.sheet.shape.resolution=[4, 4]"})
                      .out);
  EXPECT_EQ(report.at("exit_code"), 0);
  EXPECT_TRUE(report.at("reason").is_null());
  EXPECT_TRUE(report.at("reason_kind").is_null());
  EXPECT_EQ(report.at("case"), "sheet.toml");
  EXPECT_EQ(report.at("title"), "A sheet hangs");
  EXPECT_EQ(report.at("overrides"),
            Json({"time.duration=0.05", "body.sheet.shape.resolution=[4, 4]"}));
  EXPECT_EQ(report.at("weft_version"), WEFT_VERSION);

  const Json file = info();
  EXPECT_EQ(file.at("status"), "done");
  EXPECT_EQ(file.at("reason"), "");
  for (const char* part : {"", "setup_", "run_", "record_"}) {
    for (const char* clock : {"wall_s", "cpu_s"}) {
      const std::string name = std::string(part) + clock;
      EXPECT_GT(file.at(name), 0) << name;
      // The file's costs leave out the time to write them and to close it.
      EXPECT_LE(file.at(name), report.at(name)) << name;
    }
  }
  EXPECT_TRUE(contains(info_text(), "\nrun       done\n")) << info_text();
}

// Numbers of the report that are also series have the series' names, and energies their values.
TEST_F(CommandEnd, ReportsByTheNamesOfSeries) {
  const Json report = Json::parse(weft({"run", "sheet.toml", "--json", "--quiet"}).out);
  const Json file = info();
  int energies = 0;
  bool has_gap = false, has_stretch = false;
  std::set<std::string> names;
  for (const Json& series : file.at("series")) {
    const std::string name = series.at("name");
    names.insert(name);
    has_gap = has_gap || name == "smallest_gap";
    has_stretch = has_stretch || name == "largest_stretch";
    if (name == "largest_stretch") {
      EXPECT_EQ(report.at(name), series.at("maximum"));
    }
    if (!name.starts_with("energy_")) continue;
    EXPECT_EQ(report.at("energies").at(name), series.at("last")) << name;
    ++energies;
  }
  EXPECT_TRUE(has_gap && has_stretch);
  EXPECT_TRUE(report.contains("smallest_gap"));
  EXPECT_GE(energies, 5);
  EXPECT_EQ(report.at("energies").size(), energies);
  EXPECT_EQ(report.at("phases_s").size(), 7);
  for (const auto& phase : report.at("phases_s").items())
    EXPECT_TRUE(names.contains(phase.key())) << phase.key();
}

TEST_F(CommandEnd, AFailureIsInTheFileWithItsReason) {
  const Result result = weft({"run", "sheet.toml", "--json", "--quiet", "--set",
                              "time.duration=1e4", "--set", "compute.cpu_limit=0.02"});
  EXPECT_EQ(result.code, exit_code::numerical_failure);
  const Json report = Json::parse(result.out);
  EXPECT_EQ(report.at("exit_code"), result.code);
  EXPECT_TRUE(contains(report.at("reason"), "compute.cpu_limit"));
  EXPECT_EQ(report.at("reason_kind"), "cpu_limit");
  const Json file = info();
  EXPECT_EQ(file.at("status"), "failed");
  EXPECT_EQ(file.at("reason"), report.at("reason"));
  EXPECT_TRUE(contains(info_text(), "\nrun       failed: the limit of 0.02 s")) << info_text();
}

TEST_F(CommandEnd, AStopIsInTheFile) {
  for (const auto& [signal, code, name] :
       {std::tuple(SIGINT, 130, "SIGINT"), std::tuple(SIGTERM, 143, "SIGTERM")}) {
    WeftProcess run = endless_run();
    wait_for_file("out/sheet.h5");
    run.send(signal);
    EXPECT_EQ(run.wait(), code);
    const Json report = Json::parse(run.out());
    EXPECT_EQ(report.at("status"), "interrupted");
    EXPECT_EQ(report.at("exit_code"), code);
    const Json file = info();
    EXPECT_EQ(file.at("status"), "interrupted");
    EXPECT_TRUE(contains(file.at("reason"), name)) << file.at("reason");
    EXPECT_EQ(file.at("reason"), report.at("reason"));
    std::filesystem::remove_all(path("out"));
  }
}

// The test holds a lease on the case, so that the command waits where it opens it.
TEST_F(CommandEnd, AStopBeforeTheCaseIsReadIsReported) {
  std::signal(SIGIO, SIG_IGN);  // which the kernel sends to ask for the lease
  const int file = open(path("sheet.toml").c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_GE(file, 0);
  if (fcntl(file, F_SETLEASE, F_WRLCK) != 0) GTEST_SKIP() << "this file system has no leases";
  WeftProcess run = endless_run();
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (fcntl(file, F_GETLEASE) == F_WRLCK) {
    ASSERT_LT(std::chrono::steady_clock::now(), end);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  run.send(SIGTERM);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  fcntl(file, F_SETLEASE, F_UNLCK);
  close(file);
  EXPECT_EQ(run.wait(), 143);
  const Json report = Json::parse(run.out());
  EXPECT_EQ(report.at("status"), "interrupted");
  EXPECT_TRUE(contains(report.at("reason"), "SIGTERM")) << report.at("reason");
}

TEST_F(CommandEnd, AStopWithinThePilotHasItsReason) {
  WeftProcess run(folder(), {"run", "sheet.toml", "--json", "--set", "time.duration=4", "--set",
                             "time.accuracy=1e-2", "--set", "time.method=cvode", "--set",
                             "body.sheet.shape.resolution=[33, 33]"});
  wait_for_file("stderr.txt");
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (!contains(run.err(), "pilot of time.accuracy")) {
    ASSERT_LT(std::chrono::steady_clock::now(), end) << run.err();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  run.send(SIGINT);
  EXPECT_EQ(run.wait(), 130);
  const Json report = Json::parse(run.out());
  EXPECT_EQ(report.at("status"), "interrupted");
  EXPECT_TRUE(contains(report.at("reason"), "SIGINT")) << report.at("reason");
  EXPECT_GT(report.at("pilot_cpu_s"), 0);
  EXPECT_EQ(report.at("run_cpu_s"), 0);
  EXPECT_TRUE(report.at("trajectory").is_null());
  EXPECT_FALSE(exists("out"));
}

TEST_F(CommandEnd, ARunThatGoesOnIsToldFromOneThatWasKilled) {
  WeftProcess run = endless_run();
  wait_for_file("out/sheet.h5");
  WeftProcess look(folder(), {"info", "out/sheet.h5", "--json"},
                   [] { dup2(open("info.json", O_WRONLY | O_CREAT, 0644), STDOUT_FILENO); });
  EXPECT_EQ(look.wait(), exit_code::done);
  EXPECT_EQ(Json::parse(read_bytes(path("info.json"))).at("status"), "running");
  run.send(SIGKILL);
  run.wait();
  EXPECT_EQ(info().at("status"), "killed");
  EXPECT_TRUE(contains(info_text(), "\nrun       killed: ")) << info_text();
}

TEST_F(CommandEnd, JsonIsAnObjectWhateverIsWrong) {
  write("bad.toml", "[time]\n  duratoin = 2.0\n");
  write("text.h5", "no HDF5");
  write("file", "");
  struct Mistake {
    WeftProcess::Arguments arguments;
    int code;
    std::string status, reason;
  };
  const Mistake mistakes[] = {
      {{"run", "bad.toml"}, exit_code::bad_case, "refused", "did you mean \"duration\"?"},
      {{"run", "none.toml"}, exit_code::bad_case, "refused", "none.toml"},
      {{"run", "sheet.toml", "--set", "time.duration=-1"}, exit_code::bad_case, "refused", "time"},
      {{"run", "sheet.toml", "--froce"}, exit_code::bad_case, "refused", "\"--force\"?"},
      {{"run", "sheet.toml", "-o", "file/out"}, exit_code::input_output, "failed", "file/out"},
      {{"info", "text.h5"}, exit_code::input_output, "failed", "text.h5: "}};
  for (Mistake mistake : mistakes) {
    mistake.arguments.push_back("--json");
    const Result result = weft(mistake.arguments);
    EXPECT_EQ(result.code, mistake.code) << mistake.reason;
    const Json object = Json::parse(result.out);
    EXPECT_EQ(object.at("exit_code"), mistake.code);
    EXPECT_EQ(object.at("status"), mistake.status);
    EXPECT_TRUE(contains(object.at("reason"), mistake.reason)) << object.at("reason");
    EXPECT_TRUE(object.at("reason_kind").is_null());
    EXPECT_TRUE(contains(result.err, mistake.reason)) << result.err;
  }
}

TEST_F(CommandEnd, ARefusedCaseThatWasReadHasItsTitle) {
  const auto refused = [&](const WeftProcess::Arguments& more) {
    WeftProcess::Arguments arguments{"run", "sheet.toml", "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Result result = weft(arguments);
    EXPECT_EQ(result.code, exit_code::bad_case);
    return Json::parse(result.out);
  };
  EXPECT_EQ(refused({"--estimate-error", "--set", "time.method=\"static\""}).at("title"),
            "A sheet hangs");
  // The sheet starts in a circle whose ends nearly meet.
  EXPECT_EQ(refused({"--set", "contact.enabled=true", "--set", "body.sheet.thickness=0.01", "--set",
                     "body.sheet.start={ bend_radius = 0.017 }"})
                .at("title"),
            "A sheet hangs");
  EXPECT_FALSE(refused({"--set", "time.duration=-1"}).contains("title"));
}

// While the process is stopped, both signals wait: it gets them before it can end its step.
TEST_F(CommandEnd, ASecondSignalEndsTheRunAtOnceWhicheverItIs) {
  WeftProcess run = endless_run();
  wait_for_file("out/sheet.h5");
  run.send(SIGSTOP);
  run.send(SIGINT);
  run.send(SIGTERM);
  run.send(SIGCONT);
  EXPECT_LT(run.wait(), 0) << run.out();  // a signal ended it
  EXPECT_EQ(run.out(), "");
}

// `weft info FILE | head -1` ends like any other command of a pipe, and calls no file damaged.
TEST_F(CommandEnd, ACommandThatReadsAFileEndsWithItsPipe) {
  ASSERT_EQ(weft({"run", "sheet.toml", "--quiet"}).code, exit_code::done);
  const auto close_reader = [] {
    std::signal(SIGPIPE, SIG_DFL);
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) _exit(125);
    dup2(ends[1], STDOUT_FILENO);
    close(ends[0]);
    close(ends[1]);
  };
  for (const WeftProcess::Arguments& arguments :
       {WeftProcess::Arguments{"info", "out/sheet.h5"},
        {"info", "out/sheet.h5", "--json"},
        {"outputs", "out/sheet.h5", "last = last(time)"}}) {
    const Result result = weft(arguments, close_reader);
    EXPECT_EQ(result.code, -SIGPIPE) << arguments[0];
    EXPECT_EQ(result.err, "") << arguments[0];
  }
}

// The help of --set shows one override, and --set takes exactly one.
TEST_F(CommandEnd, EachOverrideHasASetOfItsOwn) {
  const std::string help = weft({"run", "--help"}).out;
  EXPECT_TRUE(contains(help, "--set KEY=VALUE")) << help;
  EXPECT_FALSE(contains(help, "KEY=VALUE ...")) << help;
  const Result two = weft({"run", "--set", "time.duration=0.02", "--set", "title=\"other\"",
                           "sheet.toml", "--json", "--quiet"});
  ASSERT_EQ(two.code, exit_code::done) << two.err;
  EXPECT_EQ(Json::parse(two.out).at("title"), "other");
  EXPECT_EQ(weft({"run", "sheet.toml", "--set", "time.duration=0.02", "title=\"other\""}).code,
            exit_code::bad_case);
}

}  // namespace
}  // namespace weft::sim::command_end_test
