// Whole runs, by the library: what is on disk while they go on.
#include <gtest/gtest.h>

#include <thread>

#include "sim/simulation.h"
#include "sim/trajectory/trajectory.h"
#include "tests/sim/simulated_case.h"
#include "tests/temporary_folder.h"

namespace weft::sim {
namespace {

class WholeRun : public testing::Test {
 protected:
  static std::unique_ptr<const Scene> make_scene(const Overrides& overrides) {
    return build_scene(parse_case(hanging_sheet, "test.toml", overrides));
  }
  RunOptions options() const {
    RunOptions result;
    result.trajectory = folder_.path("run.h5");
    return result;
  }
  int frames_on_disk() const { return TrajectoryReader(folder_.path("run.h5")).frames(); }

 private:
  TemporaryFolder folder_;
};

// Each step holds several frames; a kill within the next would lose what is not on disk.
TEST_F(WholeRun, FramesOfASlowRunDoNotWaitForTheNextStep) {
  const auto scene = make_scene(method("euler", {"time.step=0.02", "time.frames_per_second=200"}));
  RunOptions slow = options();
  int steps = 0;
  slow.progress = [&](double time) {
    const int frames = 1 + static_cast<int>(time * 200 + 1e-6);
    EXPECT_TRUE(++steps == 1 || frames_on_disk() == frames);
    std::this_thread::sleep_for(std::chrono::milliseconds(260));
  };
  EXPECT_EQ(run_simulation(*scene, slow).frames, 21);
  EXPECT_EQ(steps, 5);
}

// A quick one writes its first frame at once, and the others together.
TEST_F(WholeRun, FramesOfAQuickRunAreWrittenTogether) {
  const auto scene = make_scene({"time.duration=0.02", "time.frames_per_second=10000"});
  RunOptions quick = options();
  int writings = 0, before = 0;
  const auto start = std::chrono::steady_clock::now();
  quick.progress = [&](double) {
    const int now = frames_on_disk();
    writings += now != before ? 1 : 0;
    before = now;
  };
  EXPECT_EQ(run_simulation(*scene, quick).frames, 201);
  EXPECT_EQ(frames_on_disk(), 201);
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
  EXPECT_LE(writings, 2 + 8 * wall.count());
  EXPECT_LT(before, 201);
}

}  // namespace
}  // namespace weft::sim
