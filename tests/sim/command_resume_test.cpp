// `weft run --resume`: runs that are killed, stopped, out of disk space or over their limit go on.
#include <sys/resource.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <random>

#include "sim/command/run_command.h"
#include "sim/run/numerics_version.h"
#include "sim/trajectory/trajectory.h"
#include "tests/sim/same_datasets.h"
#include "tests/sim/weft_process.h"

namespace weft::sim::command_resume_test {
namespace {

constexpr const char* contact_case = R"(
[time]
duration = 0.4
frames_per_second = 500
[contact]
friction = 0.3
[output]
checkpoint_every = 0.02
[[body]]
name = "sheet"
position = [0.01, 0.02, 0.02]
rotation_deg = [5, 8, 0]
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [7, 7] }
[[obstacle]]
name = "ball"
position = [0, 0, -0.05]
shape = { type = "sphere", radius = 0.05, resolution = [7] }
)";

constexpr const char* self_contact_case = R"(
[time]
duration = 0.35
frames_per_second = 300
[output]
checkpoint_every = 0.05
[material.cloth]
bending_stiffness = 1e-6
stiffness_damping = 1e-3
[[body]]
name = "strip"
position = [0, 0, 0.11]
rotation_deg = [80, 0, 0]
shape = { type = "rectangle", size = [0.05, 0.2], resolution = [5, 17] }
[[obstacle]]
name = "floor"
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3] }
)";

// A sheet that hangs by two corners, for a method without contact.
std::string hanging_case(const std::string& options) {
  return "[time]\nframes_per_second = 300\n" + options + R"(
[contact]
enabled = false
[material.cloth]
bending_stiffness = 1e-5
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [17, 17] }
[[body.pin]]
corners = ["last_first", "last_last"]
)";
}

class CommandResume : public WeftCommand {
 protected:
  using Arguments = WeftProcess::Arguments;

  static Arguments run_arguments(const std::string& out, const Arguments& more = {}) {
    Arguments all{"run", "test.toml", "--json", "--quiet", "-o", out};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  // Runs `more` in the folder `out`, and returns its report.
  nlohmann::json run(const std::string& out, int code, const Arguments& more = {},
                     const std::function<void()>& prepare = {}) const {
    const Result result = weft(run_arguments(out, more), prepare);
    EXPECT_EQ(result.code, code) << result.err;
    return nlohmann::json::parse(result.out);
  }
  std::vector<std::string> differing(const std::string& one, const std::string& other) const {
    return differing_datasets(path(one + "/test.h5").string(), path(other + "/test.h5").string());
  }
  void expect_equal_after_kills(const std::string& text, unsigned seed) const;
};

// Number of kills per case. The variable of the environment is that of the test with the label
// resume (tests/sim/CMakeLists.txt).
int kills_per_case() {
  const char* given = std::getenv("WEFT_KILLS");
  return given == nullptr ? 2 : std::atoi(given);
}

// Kills a run at random moments and resumes it, until it has ended; then another run, until so many
// kills as wanted have hit. A kill that comes after the end of a run does not count.
void CommandResume::expect_equal_after_kills(const std::string& text, unsigned seed) const {
  using Clock = std::chrono::steady_clock;
  write("test.toml", text);
  const Clock::time_point start = Clock::now();
  run("whole", exit_code::done);
  const std::chrono::duration<double> whole_run = Clock::now() - start;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> fraction(0.0, 1.0);
  int kills = 0;
  for (int runs = 0; kills < kills_per_case(); ++runs) {
    const std::string out = "out" + std::to_string(runs);
    for (bool has_ended = false; !has_ended;) {
      WeftProcess process(folder(), run_arguments(out, {"--resume"}));
      if (kills < kills_per_case()) {
        std::this_thread::sleep_for(fraction(random) * whole_run);
        process.send(SIGKILL);
      }
      const int code = process.wait();
      ASSERT_TRUE(code == exit_code::done || code == -SIGKILL) << process.err();
      has_ended = code == exit_code::done;
      kills += has_ended ? 0 : 1;
    }
    EXPECT_EQ(differing("whole", out), std::vector<std::string>{}) << "after " << kills << " kills";
    // Nothing is left but the trajectory, its sidecar and its checkpoint.
    int files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(path(out))) {
      ++files;
      EXPECT_NE(entry.path().extension(), ".tmp") << entry.path();
    }
    EXPECT_EQ(files, 3);
  }
}

TEST_F(CommandResume, EqualsAfterKillsInContact) { expect_equal_after_kills(contact_case, 1); }

TEST_F(CommandResume, EqualsAfterKillsInSelfContact) {
  expect_equal_after_kills(self_contact_case, 2);
}

TEST_F(CommandResume, EqualsAfterKillsWithArkode) {
  expect_equal_after_kills(hanging_case("method = \"arkode\"\nduration = 1\n[output]\n"
                                        "checkpoint_every = 0.05"),
                           3);
}

TEST_F(CommandResume, EqualsAfterKillsWithVerlet) {
  expect_equal_after_kills(hanging_case("method = \"verlet\"\nduration = 2\n[output]\n"
                                        "checkpoint_every = 0.1"),
                           4);
}

TEST_F(CommandResume, EqualsAfterKillsWithStatic) {
  expect_equal_after_kills(hanging_case("method = \"static\"\nduration = 0.2"), 5);
}

TEST_F(CommandResume, GoesOnAfterATerminationALimitAndAFullDisk) {
  write("test.toml", contact_case);
  const nlohmann::json whole = run("whole", exit_code::done);
  EXPECT_TRUE(whole.at("resumed_at_s").is_null());
  {
    WeftProcess process(folder(), run_arguments("out"));
    wait_for_file("out/test.h5");
    process.send(SIGTERM);
    EXPECT_EQ(process.wait(), 143);
  }
  const std::string limit =
      "compute.cpu_limit=" + std::to_string(whole.at("cpu_s").get<double>() / 6);
  run("out", exit_code::numerical_failure, {"--resume", "--set", limit});
  const auto most = static_cast<rlim_t>(
      0.7 * static_cast<double>(std::filesystem::file_size(path("whole/test.h5"))));
  const auto limit_files = [&] {
    const rlimit size{most, most};
    setrlimit(RLIMIT_FSIZE, &size);
    std::signal(SIGXFSZ, SIG_IGN);  // writing fails instead
  };
  const Result full = weft(run_arguments("out", {"--resume"}), limit_files);
  EXPECT_EQ(full.code, exit_code::input_output) << full.out;
  EXPECT_NE(full.err.find("out/test."), std::string::npos) << full.err;
  EXPECT_GT(TrajectoryReader(path("out/test.h5").string()).frames(), 0);
  write("out/test.h5.999999999.tmp", "left by a killed run");
  const nlohmann::json rest = run("out", exit_code::done, {"--resume"});
  EXPECT_GT(rest.at("resumed_at_s"), 0);
  EXPECT_EQ(rest.at("steps"), whole.at("steps"));
  EXPECT_EQ(rest.at("counters"), whole.at("counters"));
  EXPECT_EQ(differing("whole", "out"), std::vector<std::string>{});
  // Leftovers of killed runs go away.
  EXPECT_FALSE(exists("out/test.h5.999999999.tmp"));
  // A complete run is not run again, and its file is left as it is.
  const std::string bytes = read_bytes(path("out/test.h5"));
  const nlohmann::json again = run("out", exit_code::done, {"--resume"});
  for (const char* key : {"steps", "frames", "energies", "largest_stretch", "smallest_gap",
                          "simulated_s", "counters"})
    EXPECT_EQ(again.at(key), rest.at(key)) << key;
  // The bill adds up the parts.
  EXPECT_GT(again.at("cpu_s"), 0.9 * rest.at("cpu_s").get<double>());
  EXPECT_EQ(read_bytes(path("out/test.h5")), bytes);
}

TEST_F(CommandResume, RefusesOtherCases) {
  write("test.toml", contact_case);
  run("out", exit_code::done, {"--set", "time.duration=0.05"});
  const auto refusal = [&](const Arguments& more) {
    Arguments all{"--resume"};
    all.insert(all.end(), more.begin(), more.end());
    return run("out", exit_code::bad_case, all).at("reason").get<std::string>();
  };
  EXPECT_EQ(
      refusal({"--set", "time.duration=0.05", "--set", "contact.friction=0.4"}),
      "--resume: out/test.h5 was made by another case: it has \"friction = 0.3\", not "
      "\"friction = 0.4\"\n  expected the case of that run; --force begins anew, -o writes to "
      "another folder");
  EXPECT_NE(refusal({"--set", "time.duration=0.06"})
                .find("has a time.duration of 0.05 s, not 0.06 s\n  expected the same; --extend "
                      "makes it longer"),
            std::string::npos);
  EXPECT_NE(refusal({"--set", "time.duration=0.05", "--estimate-error"})
                .find("has no estimate of its error"),
            std::string::npos);
  const Result both = weft({"run", "test.toml", "--resume", "--force"});
  EXPECT_EQ(both.code, exit_code::bad_case) << both.err;
}

TEST_F(CommandResume, RefusesDamagedCheckpoints) {
  write("test.toml", contact_case);
  run("out", exit_code::done, {"--set", "time.duration=0.05"});
  const std::string file = path("out/test.checkpoint").string();
  const std::string good = read_bytes(file);
  const auto refusal = [&](const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
    return run("out", exit_code::input_output, {"--resume", "--set", "time.duration=0.05"})
        .at("reason")
        .get<std::string>();
  };
  std::string changed = good;
  changed[good.size() / 2] ^= 1;
  EXPECT_EQ(refusal(changed), "out/test.checkpoint: is damaged");
  EXPECT_EQ(refusal(good.substr(0, good.size() / 2)), "out/test.checkpoint: is damaged");
  std::string other_numerics = good;
  const std::string number = "numerics " + std::to_string(numerics_version);
  ASSERT_NE(good.find(number), std::string::npos);
  other_numerics.insert(good.find(number) + number.size(), "0");
  EXPECT_EQ(refusal(other_numerics),
            "out/test.checkpoint: is not a checkpoint of this version of Weft");
  EXPECT_EQ(refusal("weft"), "out/test.checkpoint: is not a checkpoint of this version of Weft");
  EXPECT_EQ(refusal(""), "out/test.checkpoint: is not a checkpoint of this version of Weft");
  // A checkpoint of another trajectory of the same case.
  std::ofstream(file, std::ios::binary) << good;
  run("short", exit_code::numerical_failure,
      {"--set", "time.duration=0.05", "--set", "compute.cpu_limit=1e-3"});
  std::filesystem::copy_file(path("short/test.h5"), path("out/test.h5"),
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_NE(refusal(good).find("out/test.h5: is not the trajectory of out/test.checkpoint"),
            std::string::npos);
}

TEST_F(CommandResume, ReplacesNoFileThatIsNoCheckpoint) {
  write("test.toml", contact_case);
  const Arguments brief{"--set", "time.duration=0.01"};
  std::filesystem::create_directory(path("out"));
  write("out/test.checkpoint", "mine");
  const nlohmann::json refused = run("out", exit_code::input_output, brief);
  EXPECT_EQ(
      refused.at("reason"),
      "out/test.checkpoint: is no checkpoint of Weft, and is only overwritten by force (--force)");
  EXPECT_EQ(read_bytes(path("out/test.checkpoint")), "mine");
  EXPECT_FALSE(exists("out/test.h5"));
  // One of an earlier version, whose trajectory is gone, may go too.
  write("out/test.checkpoint", "weft checkpoint 0, and so on");
  run("out", exit_code::done, brief);
  EXPECT_NE(read_bytes(path("out/test.checkpoint")).find("numerics"), std::string::npos);
  std::filesystem::create_directory(path("forced"));
  write("forced/test.checkpoint", "mine");
  run("forced", exit_code::done, {brief[0], brief[1], "--force"});
  EXPECT_NE(read_bytes(path("forced/test.checkpoint")).find("numerics"), std::string::npos);
  std::filesystem::create_directories(path("folder/test.checkpoint"));
  EXPECT_EQ(run("folder", exit_code::input_output, brief).at("reason"),
            "folder/test.checkpoint: is not a regular file");
}

TEST_F(CommandResume, ReplacesNoSidecarThatWeftHasNotWritten) {
  write("test.toml", contact_case);
  std::filesystem::create_directory(path("out"));
  write("out/test.xdmf", "mine");
  const Arguments brief{"--set", "time.duration=0.01"};
  for (const Arguments& how : {Arguments{"--resume"}, {"--extend", "0.02"}}) {
    Arguments more = brief;
    more.insert(more.end(), how.begin(), how.end());
    EXPECT_EQ(run("out", exit_code::input_output, more).at("reason"),
              "out/test.xdmf: was not written by Weft, and is only overwritten by force (--force)");
    EXPECT_EQ(read_bytes(path("out/test.xdmf")), "mine");
    EXPECT_FALSE(exists("out/test.h5"));
  }
  run("out", exit_code::done, {brief[0], brief[1], "--force"});
  // A sidecar of Weft may go where its trajectory is gone.
  std::filesystem::remove(path("out/test.h5"));
  std::filesystem::remove(path("out/test.checkpoint"));
  run("out", exit_code::done, {brief[0], brief[1], "--resume"});
  EXPECT_NE(read_bytes(path("out/test.xdmf")).find("test.h5:/"), std::string::npos);
}

// HDF5 crashes on some of these files. The run ends with a message, or goes on where the damage is
// in parts that it does not read.
TEST_F(CommandResume, SurvivesDamagedTrajectories) {
  write("test.toml", contact_case);
  run("out", exit_code::done, {"--set", "time.duration=0.05"});
  const std::string file = path("out/test.h5").string();
  const std::string good = read_bytes(file), checkpoint = read_bytes(path("out/test.checkpoint"));
  std::mt19937 random(6);
  for (int trial = 0; trial < 20; ++trial) {
    std::string bytes = good;
    if (trial == 0) bytes.resize(good.size() / 2);
    // Most metadata lies near the start of the file.
    const std::size_t range = trial % 2 == 0 ? 8192 : good.size();
    for (int i = 0; i < 30 && trial > 0; ++i) {
      char& byte = bytes[random() % range];
      byte = static_cast<char>(byte ^ (1 << (random() % 8)));
    }
    std::ofstream(file, std::ios::binary) << bytes;
    std::ofstream(path("out/test.checkpoint"), std::ios::binary) << checkpoint;
    const int code = weft(run_arguments("out", {"--extend", "0.06"})).code;
    EXPECT_TRUE(code == exit_code::done || code == exit_code::input_output ||
                code == exit_code::bad_case)
        << code << " in trial " << trial;
    if (trial == 0) {
      EXPECT_EQ(code, exit_code::input_output);
    }
  }
}

// A run that ends within a quarter of a second writes its first checkpoint at its end. If it is
// stopped there, here by a name that is taken, the trajectory must not call itself complete.
TEST_F(CommandResume, GoesOnWhereTheFirstCheckpointFailed) {
  write("test.toml", contact_case);
  for (const std::string interval : {"0.02", "1"}) {
    const std::string whole = "whole" + interval, out = "out" + interval;
    Arguments more{"--set", "time.duration=0.05", "--set", "output.checkpoint_every=" + interval};
    run(whole, exit_code::done, more);
    std::filesystem::create_directories(path(out + "/test.checkpoint.tmp"));
    EXPECT_EQ(weft(run_arguments(out, more)).code, exit_code::input_output);
    std::filesystem::remove(path(out + "/test.checkpoint.tmp"));
    more.emplace_back("--resume");
    EXPECT_EQ(weft(run_arguments(out, more)).code, exit_code::done) << interval;
    EXPECT_EQ(differing(whole, out), std::vector<std::string>{}) << interval;
  }
}

// The run does not write through a link of that name, either. It overwrites what a killed run has
// left there.
TEST_F(CommandResume, KeepsAForeignFileWithTheNameOfAnUnfinishedCheckpoint) {
  write("test.toml", contact_case);
  const Arguments brief{"--set", "time.duration=0.02"};
  std::filesystem::create_directories(path("out"));
  const std::string name = "out/test.checkpoint.tmp";
  write(name, "my own file, which is precious");
  EXPECT_EQ(weft(run_arguments("out", brief)).code, exit_code::input_output);
  EXPECT_EQ(read_bytes(path(name)), "my own file, which is precious");
  std::filesystem::rename(path(name), path("mine"));
  std::filesystem::create_symlink("../mine", path(name));
  EXPECT_EQ(weft(run_arguments("out", brief)).code, exit_code::input_output);
  EXPECT_EQ(weft(run_arguments("out", {"--force", "--set", "time.duration=0.02"})).code,
            exit_code::done);
  EXPECT_EQ(read_bytes(path("mine")), "my own file, which is precious");
  std::filesystem::remove_all(path("out"));
  for (const std::string left : {"", "weft checkpoint 1, ver"}) {
    std::filesystem::create_directories(path("out"));
    write(name, left);
    EXPECT_EQ(weft(run_arguments("out", brief)).code, exit_code::done) << left;
    std::filesystem::remove_all(path("out"));
  }
}

TEST_F(CommandResume, ForceBeginsAnewWithoutTheOldCheckpoint) {
  write("test.toml", contact_case);
  run("out", exit_code::done, {"--set", "time.duration=0.05"});
  ASSERT_TRUE(exists("out/test.checkpoint"));
  run("out", exit_code::numerical_failure,
      {"--force", "--set", "compute.cpu_limit=1e-6", "--set", "output.checkpoint_every=1"});
  EXPECT_FALSE(exists("out/test.checkpoint"));
}

TEST_F(CommandResume, BeginsWhereThereIsNothing) {
  write("test.toml", contact_case);
  const nlohmann::json report =
      run("out", exit_code::done, {"--resume", "--set", "time.duration=0.05"});
  EXPECT_TRUE(report.at("resumed_at_s").is_null());
  EXPECT_EQ(report.at("status"), "done");
}

TEST_F(CommandResume, IsRefusedWhileTheRunGoesOn) {
  write("test.toml", contact_case);
  WeftProcess process(folder(), run_arguments("out", {"--set", "time.duration=1e4"}));
  wait_for_file("out/test.h5");
  TemporaryFolder elsewhere;
  WeftProcess second(elsewhere.path(),
                     {"run", path("test.toml").string(), "--quiet", "-o", path("out").string(),
                      "--resume", "--set", "time.duration=1e4"});
  EXPECT_EQ(second.wait(), exit_code::input_output);
  EXPECT_NE(second.err().find("is being written by a run that has not ended"), std::string::npos)
      << second.err();
}

// A case begins in the state of another run, on a finer image; what is killed goes on by the same
// command, which reads the first run again.
TEST_F(CommandResume, RestartsFromAnotherRun) {
  write("test.toml", contact_case);
  run("first", exit_code::done, {"--set", "time.duration=0.05", "--set", "output.velocity=true"});
  const auto restarted = [&](Arguments more) {
    for (const char* word : {"--restart-from", "first/test.h5", "--set", "time.duration=0.1",
                             "--set", "body.sheet.shape.resolution=[13, 13]"})
      more.emplace_back(word);
    return more;
  };
  run("whole", exit_code::done, restarted({"--time", "0.02"}));
  EXPECT_EQ(TrajectoryReader(path("whole/test.h5").string()).time(0), 0);
  const std::vector<Vec3> coarse =
      TrajectoryReader(path("first/test.h5").string()).positions(0, 10);
  const std::vector<Vec3> fine = TrajectoryReader(path("whole/test.h5").string()).positions(0, 0);
  ASSERT_EQ(fine.size(), 169U);
  for (int row = 0; row < 7; ++row) {
    for (int col = 0; col < 7; ++col) EXPECT_EQ(fine[26 * row + 2 * col], coarse[7 * row + col]);
  }
  {
    WeftProcess process(folder(), run_arguments("parts", restarted({"--time", "0.02"})));
    wait_for_file("parts/test.checkpoint");
    process.send(SIGKILL);
    process.wait();
  }
  const nlohmann::json rest =
      run("parts", exit_code::done, restarted({"--time", "0.02", "--resume"}));
  EXPECT_GT(rest.at("resumed_at_s"), 0);
  EXPECT_EQ(differing("whole", "parts"), std::vector<std::string>{});
  const std::string refusal = run("other", exit_code::bad_case, restarted({"--time", "0.0205"}))
                                  .at("reason")
                                  .get<std::string>();
  EXPECT_NE(refusal.find("has no frame at t = 0.0205 s"), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("the nearest is 0.02"), std::string::npos) << refusal;
  EXPECT_EQ(weft({"run", "test.toml", "--restart-from", "first/test.h5"}).code,
            exit_code::bad_case);  // without --time
  // A run does not overwrite the run from which it starts.
  const std::string first = read_bytes(path("first/test.h5"));
  const std::string own =
      run("first", exit_code::bad_case, restarted({"--time", "0.02", "--force"}))
          .at("reason")
          .get<std::string>();
  EXPECT_NE(own.find("the case reads this file, which weft run never changes"), std::string::npos)
      << own;
  EXPECT_EQ(read_bytes(path("first/test.h5")), first);
}

// The folder above a linked folder is that of its target. A file beside the link is another one.
TEST_F(CommandResume, RestartsFromAFileAboveALinkedFolder) {
  write("test.toml", hanging_case("duration = 0.02\n[output]\nvelocity = true"));
  std::filesystem::create_directories(path("store/cases"));
  std::filesystem::create_directory(path("project"));
  std::filesystem::create_directory_symlink("../store/cases", path("project/cases"));
  run("store/run", exit_code::done);
  run("out", exit_code::done, {"--restart-from", "project/cases/../run/test.h5", "--time", "0.02"});
  const TrajectoryReader first(path("store/run/test.h5").string());
  EXPECT_EQ(TrajectoryReader(path("out/test.h5").string()).positions(0, 0),
            first.positions(0, first.frames() - 1));
}

// Steps of a given length lose nothing at a checkpoint, so that the longer run equals a whole one.
TEST_F(CommandResume, ExtendsACompleteRun) {
  write("test.toml", contact_case);
  const Arguments euler{"--set", "time.method=euler", "--set", "time.step=1e-3"};
  const auto run_with = [&](const std::string& out, Arguments more) {
    more.insert(more.end(), euler.begin(), euler.end());
    return run(out, exit_code::done, more);
  };
  run_with("out", {"--set", "time.duration=0.0511"});
  const nlohmann::json longer = run_with("out", {"--extend", "0.1"});
  EXPECT_EQ(longer.at("simulated_s"), 0.1);
  const nlohmann::json whole = run_with("whole", {"--set", "time.duration=0.1"});
  EXPECT_EQ(longer.at("steps"), whole.at("steps"));
  const TrajectoryReader reader(path("out/test.h5").string());
  const TrajectoryReader expected(path("whole/test.h5").string());
  // The frame at the former end stays.
  ASSERT_EQ(reader.frames(), 52);
  ASSERT_EQ(expected.frames(), 51);
  EXPECT_EQ(reader.time(26), 0.0511);
  for (int frame = 0; frame < 51; ++frame) {
    const int same = frame < 26 ? frame : frame + 1;
    EXPECT_EQ(reader.time(same), expected.time(frame));
    EXPECT_EQ(reader.positions(0, same), expected.positions(0, frame)) << frame;
  }
  const auto refusal = [&](Arguments more) {
    more.insert(more.end(), euler.begin(), euler.begin() + 2);
    return run("out", exit_code::bad_case, more).at("reason").get<std::string>();
  };
  EXPECT_NE(refusal({"--set", "time.step=1e-3", "--extend", "0.09"}).find("expected a longer one"),
            std::string::npos);
  EXPECT_NE(run("out", exit_code::bad_case, {"--extend", "0.2", "--set", "time.method=static"})
                .at("reason")
                .get<std::string>()
                .find("--extend: the loads of time.method = \"static\" grow"),
            std::string::npos);
  EXPECT_NE(refusal({"--extend", "0.2", "--set", "time.accuracy=1e-3"})
                .find("--extend: time.accuracy is chosen for the duration"),
            std::string::npos);
  EXPECT_EQ(weft({"run", "test.toml", "--extend", "nan"}).code, exit_code::bad_case);
  EXPECT_NE(run("new", exit_code::bad_case, {"--extend", "0.05", "--set", "time.duration=0.1"})
                .at("reason")
                .get<std::string>()
                .find("--extend: 0.05 s is not beyond time.duration, 0.1 s"),
            std::string::npos);
}

// The end of a run has no frame unless output.frame_times lists it.
TEST_F(CommandResume, TellsThatWhatIsAddedHasNoFrame) {
  write("test.toml", hanging_case("duration = 0.02\n[output]\nframe_times = [0, 0.01]"));
  run("out", exit_code::done);
  const Result longer = weft(run_arguments("out", {"--extend", "0.03"}));
  EXPECT_EQ(longer.code, exit_code::done) << longer.err;
  EXPECT_NE(longer.err.find("output.frame_times has no time after 0.01 s"), std::string::npos)
      << longer.err;
  EXPECT_EQ(TrajectoryReader(path("out/test.h5").string()).frames(), 2);

  const Result more = weft(
      run_arguments("out", {"--extend", "0.05", "--set", "output.frame_times=[0, 0.01, 0.04]"}));
  EXPECT_EQ(more.code, exit_code::done) << more.err;
  EXPECT_EQ(more.err.find("has no time after"), std::string::npos) << more.err;
  EXPECT_EQ(TrajectoryReader(path("out/test.h5").string()).time(2), 0.04);
  // Times that the run has passed already cannot have a frame any more.
  run("out", exit_code::bad_case,
      {"--extend", "0.06", "--set", "output.frame_times=[0, 0.01, 0.02, 0.04]"});
}

}  // namespace
}  // namespace weft::sim::command_resume_test
