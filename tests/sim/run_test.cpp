// Whole runs by the library: their files while they go on, and their costs.
#include <gtest/gtest.h>

#include <thread>

#include "sim/base/stopwatch.h"
#include "sim/run/recorded_run.h"
#include "sim/trajectory/trajectory.h"
#include "tests/sim/simulated_case.h"
#include "tests/temporary_folder.h"

namespace weft::sim::run_test {
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
  std::string trajectory() const { return folder_.path("run.h5"); }
  int frames_on_disk() const { return TrajectoryReader(trajectory()).frames(); }

 private:
  TemporaryFolder folder_;
};

// Each step contains several frames; a kill within the next step would lose those not on disk.
TEST_F(WholeRun, FramesOfASlowRunDoNotWaitForTheNextStep) {
  const auto scene = make_scene(method("euler", {"time.step=0.02", "time.frames_per_second=200"}));
  RunOptions slow = options();
  int steps = 0;
  slow.progress = [&](double time) {
    const int frames = 1 + static_cast<int>(time * 200 + 1e-6);
    EXPECT_TRUE(++steps == 1 || frames_on_disk() == frames) << time;
    std::this_thread::sleep_for(std::chrono::milliseconds(260));
  };
  EXPECT_EQ(run_simulation(*scene, slow).frames, 21);
  EXPECT_EQ(steps, 5);
}

// The series of a run stay the same while ties break and clamps let go.
TEST_F(WholeRun, KeepsItsEnergiesWhileJointsLetGo) {
  const auto scene = build_scene(parse_case(
      std::string(hanging_sheet) +
          "clamp = true\nrelease_time = 0.04\n[[obstacle]]\nname = \"bar\"\nposition = [0, 0.6, "
          "0]\n"
          "shape = { type = \"rectangle\", size = [1, 1], resolution = [2, 2] }\n[[tie]]\nbody = "
          "\"sheet\"\nto = \"bar\"\nedges = [\"first_row\"]\nstiffness = 10\nbreak_force = 0.05\n",
      "test.toml", {"body.sheet.pin.0.edges=[\"last_row\"]", "output.step_energies=true"}));
  const RunReport report = run_simulation(*scene, options());
  EXPECT_EQ(report.status, RunReport::Status::done) << report.reason;
  const TrajectoryReader reader(trajectory());
  EXPECT_EQ(reader.frames(), 6);
  const std::vector<double> ties = reader.series_values("energy_ties"),
                            clamp = reader.series_values("energy_clamp"),
                            membrane = reader.series_values("energy_membrane");
  ASSERT_EQ(membrane.size(), 6);
  EXPECT_GT(clamp[1], 0);
  EXPECT_GT(ties[1], 0);
  EXPECT_EQ(ties[5], 0);
  EXPECT_EQ(clamp[5], 0);
  EXPECT_GT(membrane[5], 0);
}

// The parts of a bill add up to its total, and no phase counts the time of another.
TEST_F(WholeRun, NothingIsPaidTwice) {
  const auto scene = make_scene({"time.duration=0.02", "time.frames_per_second=10000"});
  RunOptions run = options();
  run.estimate_error = true;
  run.earlier.setup = {0.5, 0.25};
  run.earlier.pilot = {2, 1};
  run.earlier.total = {2.5, 1.25};
  const Stopwatch stopwatch;
  const RunReport report = run_simulation(*scene, run);
  const Cost spent = stopwatch.elapsed();
  const Bill& bill = report.bill;
  for (const double Cost::*clock : {&Cost::wall, &Cost::cpu}) {
    for (const Cost Bill::*part : {&Bill::run, &Bill::record, &Bill::error_estimate}) {
      EXPECT_GT(bill.*part.*clock, 0);
    }
    EXPECT_GT(bill.setup.*clock, run.earlier.setup.*clock);
    EXPECT_EQ(bill.pilot.*clock, run.earlier.pilot.*clock);
    EXPECT_LE(bill.total.*clock, spent.*clock + run.earlier.total.*clock);
    const Cost sum = bill.setup + bill.pilot + bill.run + bill.record + bill.error_estimate;
    EXPECT_NEAR(sum.*clock, bill.total.*clock, 1e-9);
  }
  const PhaseTimes& phases = report.statistics.phases;
  EXPECT_GT(phases.forces, 0);
  EXPECT_GT(phases.energies, 0);
  EXPECT_GT(phases.record, 0);
  EXPECT_LE(phases.record, bill.record.wall);
  // The set-up evaluates forces and energies of the start.
  const double most = bill.run.wall + bill.setup.wall - run.earlier.setup.wall;
  EXPECT_LE(phases.forces + phases.linear_solve + phases.energies, most);
}

TEST(PhaseTimer, StandsStillWhileAnotherRuns) {
  using Clock = std::chrono::steady_clock;
  double outer = 0, inner = 0;
  const auto wait = [] { std::this_thread::sleep_for(std::chrono::milliseconds(5)); };
  const Clock::time_point start = Clock::now();
  {
    const PhaseTimer timer(outer);
    wait();
    for (int i = 0; i < 3; ++i) {
      const PhaseTimer nested(inner);
      wait();
      const PhaseTimer same(inner);
      wait();
    }
    wait();
  }
  const std::chrono::duration<double> all = Clock::now() - start;
  EXPECT_GE(outer, 0.01);
  EXPECT_GE(inner, 0.03);
  EXPECT_LE(outer + inner, all.count());
}

// A fast run writes its frames together.
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
  EXPECT_LE(writings, 8 * wall.count());
}

}  // namespace
}  // namespace weft::sim::run_test
