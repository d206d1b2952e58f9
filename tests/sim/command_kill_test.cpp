// A run that is killed, or still goes on, has written frames that equal those of a whole run.
#include <random>

#include "sim/trajectory/trajectory.h"
#include "tests/sim/weft_process.h"

namespace weft::sim::command_kill_test {
namespace {

constexpr const char* falling_case = R"(
[time]
duration = 0.15
frames_per_second = 4000
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

struct Frame {
  double time = 0;
  std::vector<std::vector<Vec3>> positions;  // by body
  bool operator==(const Frame&) const = default;
};

class CommandKill : public WeftCommand {
 protected:
  static std::vector<Frame> read_frames(const std::filesystem::path& file) {
    const TrajectoryReader reader(file.string());
    std::vector<Frame> frames;
    for (int f = 0; f < reader.frames(); ++f) {
      Frame& frame = frames.emplace_back();
      frame.time = reader.time(f);
      for (int body = 0; body < static_cast<int>(reader.bodies().size()); ++body) {
        frame.positions.push_back(reader.positions(body, f));
      }
    }
    return frames;
  }
};

TEST_F(CommandKill, LeavesWholeFramesOfTheSameRun) {
  using Clock = std::chrono::steady_clock;
  write("fall.toml", falling_case);
  const Clock::time_point start = Clock::now();
  ASSERT_EQ(weft({"run", "fall.toml", "--quiet", "-o", "whole"}).code, 0);
  const auto whole_run = std::chrono::duration<double>(Clock::now() - start);
  const std::vector<Frame> whole = read_frames(path("whole/fall.h5"));
  ASSERT_EQ(whole.size(), 601U);

  std::mt19937 random(20240229);
  std::uniform_real_distribution<double> fraction(0.0, 0.9);
  int cut_short = 0;
  for (int trial = 0; trial < 10; ++trial) {
    const std::string out = "out" + std::to_string(trial);
    WeftProcess process(folder(), {"run", "fall.toml", "--quiet", "-o", out});
    wait_for_file(out + "/fall.h5");
    std::this_thread::sleep_for(fraction(random) * whole_run);
    const std::string file = path(out + "/fall.h5").string();
    const int seen = TrajectoryReader(file).frames();
    process.send(SIGKILL);
    process.wait();
    const std::vector<Frame> left = read_frames(file);
    ASSERT_GE(left.size(), static_cast<std::size_t>(seen)) << "trial " << trial;
    ASSERT_LE(left.size(), whole.size());
    cut_short += left.size() < whole.size() ? 1 : 0;
    for (std::size_t f = 0; f < left.size(); ++f) {
      ASSERT_EQ(left[f], whole[f]) << "trial " << trial << ", frame " << f;
    }
  }
  EXPECT_GE(cut_short, 1);  // at least one kill came before the end
}

// Without retries, HDF5 takes the file for broken in about every fifth of these readings.
TEST_F(CommandKill, CanBeReadWhileItGoesOn) {
  write("fall.toml", falling_case);
  WeftProcess process(folder(), {"run", "fall.toml", "--quiet"});
  wait_for_file("out/fall.h5");
  int readings = 0;
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  for (std::size_t frames = 0; frames < 601; ++readings) {
    ASSERT_LT(std::chrono::steady_clock::now(), end);
    const std::vector<Frame> read = read_frames(path("out/fall.h5"));
    ASSERT_GE(read.size(), frames);
    frames = read.size();
  }
  EXPECT_EQ(process.wait(), 0);
  EXPECT_GT(readings, 1);  // at least one came before the end
}

}  // namespace
}  // namespace weft::sim::command_kill_test
