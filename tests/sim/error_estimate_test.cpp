// Errors measured by a second run, against those from a converged reference.
#include "sim/accuracy/error_monitor.h"

#include <cmath>
#include <fstream>
#include <sstream>

#include "sim/run/recorded_run.h"
#include "sim/trajectory/trajectory.h"
#include "simulated_case.h"
#include "tests/temporary_folder.h"

namespace weft::sim::error_estimate_test {
namespace {

const std::string swinging_sheet = R"(
[time]
duration = 0.2
[contact]
enabled = false
[material.cloth]
density = 0.2
membrane_stiffness = 300
stiffness_damping = 1e-3
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [9, 9] }
[[body.pin]]
corners = ["last_first", "last_last"]
)";

const std::string struck_drum = R"(
[time]
duration = 0.1
[contact]
enabled = false
[material.cloth]
membrane_stiffness = 1000
stiffness_damping = 1e-3
[[body]]
name = "drum"
velocity = [0, 0, 1]
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [9, 9] }
[[body.pin]]
edges = ["first_row", "last_row", "first_col", "last_col"]
)";

const std::string sheet_on_floor = R"(
[time]
duration = 0.1
[contact]
range = 4e-3
[material.cloth]
membrane_stiffness = 100
stiffness_damping = 1e-2
[[body]]
name = "sheet"
position = [0.01, 0.02, 0.03]
rotation_deg = [0, 8, 0]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [5, 5] }
[[obstacle]]
name = "floor"
shape = { type = "rectangle", size = [0.6, 0.6], resolution = [3, 3] }
)";

struct Errors {
  double largest = 0, last = 0;
};

constexpr int last_frame = 20;

// Returns the states at all frames, from cvode at a small tolerance.
std::vector<std::vector<double>> exact_frames(const std::string& text, const Overrides& exactly) {
  SimulatedCase exact(text, exactly);
  std::vector<std::vector<double>> frames;
  for (int frame = 0; frame <= last_frame; ++frame)
    frames.push_back(exact.advance_to(exact.scene().source.time.duration * frame / last_frame));
  return frames;
}

// Returns, over all frames, the errors by the monitor and the true ones.
std::pair<Errors, Errors> estimated_and_true(const std::string& text, const Overrides& overrides,
                                             const std::vector<std::vector<double>>& exact) {
  SimulatedCase run(text, overrides);
  ErrorMonitor monitor(run.scene(), nullptr);
  Errors truth;
  for (int frame = 0; frame <= last_frame; ++frame) {
    const double time = run.scene().source.time.duration * frame / last_frame;
    const std::vector<double> y = run.advance_to(time);
    monitor.compare(time, y);
    truth.last = position_difference(y, exact[static_cast<std::size_t>(frame)]);
    truth.largest = std::max(truth.largest, truth.last);
  }
  EXPECT_EQ(monitor.estimate().failure, "");
  const BodyError body = monitor.estimate().bodies.at(0);
  return {{body.largest, body.last}, truth};
}

TEST(ErrorEstimate, IsWithinAFactorTwoOfTheTruth) {
  const Overrides methods[] = {
      {"time.method=cvode", "time.position_tolerance=1e-4"},
      {"time.method=arkode", "time.position_tolerance=1e-4"},
      {"time.method=euler", "time.position_tolerance=1e-3"},
      {"time.method=euler", "time.step=5e-3"},
      {"time.method=euler", "time.step=5e-3", "time.newton=1"},
      {"time.method=implicit_midpoint", "time.step=2e-3"},
      {"time.method=verlet", "time.step=8e-4"},
  };
  for (const std::string& scene : {swinging_sheet, struck_drum, sheet_on_floor}) {
    const auto exact =
        exact_frames(scene, {"time.position_tolerance=1e-10", "time.relative_tolerance=1e-9"});
    for (Overrides overrides : methods) {
      if (scene == sheet_on_floor) overrides.emplace_back("time.position_tolerance=1e-6");
      // Stiffness and damping limit explicit steps.
      if (overrides[0] == "time.method=verlet" && scene != swinging_sheet) {
        overrides[1] = scene == struck_drum ? "time.step=2e-4" : "time.step=5e-5";
      }
      SCOPED_TRACE(scene.substr(scene.find("name")) + overrides[0] + ' ' + overrides[1]);
      const auto [estimate, truth] = estimated_and_true(scene, overrides, exact);
      EXPECT_GT(truth.largest, 1e-7);
      EXPECT_GT(estimate.largest, truth.largest / 2);
      EXPECT_LT(estimate.largest, truth.largest * 2);
      // Contact cuts fixed steps at different places in the two runs.
      if (scene == sheet_on_floor && overrides[1] == "time.step=5e-3") continue;
      EXPECT_GT(estimate.last, truth.last / 2);
      EXPECT_LT(estimate.last, truth.last * 2);
    }
  }
}

// A plate of steel that swings far. The tolerances give errors from 1e-5 m to some 1e-3 m; the
// reference is 1e-6 m from the truth.
TEST(ErrorEstimate, IsWithinAFactorTwoOfTheTruthForShells) {
  std::ifstream file(WEFT_CASES_DIR "/plucked_plate.toml");
  std::stringstream plate;
  plate << file.rdbuf();
  const std::string duration = "time.duration=0.1";
  const auto exact = exact_frames(
      plate.str(), {duration, "time.position_tolerance=1e-8", "time.relative_tolerance=1e-7"});
  for (Overrides overrides :
       {method("cvode", {"time.position_tolerance=1e-6", "time.relative_tolerance=1e-5"}),
        method("arkode", {"time.position_tolerance=1e-4", "time.relative_tolerance=1e-3"}),
        method("euler", {"time.position_tolerance=1e-5", "time.relative_tolerance=1e-4"}),
        method("implicit_midpoint", {"time.step=1e-3"})}) {
    SCOPED_TRACE(overrides[0]);
    overrides.push_back(duration);
    const auto [estimate, truth] = estimated_and_true(plate.str(), overrides, exact);
    EXPECT_GT(truth.largest, 1e-5);
    EXPECT_GT(estimate.largest, truth.largest / 2);
    EXPECT_LT(estimate.largest, truth.largest * 2);
    EXPECT_GT(estimate.last, truth.last / 2);
    EXPECT_LT(estimate.last, truth.last * 2);
  }
}

TEST(ErrorEstimate, SaysFromWhenTheRunsHaveParted) {
  // At this step, backward Euler damps the drum's motion.
  SimulatedCase run(struck_drum, {"time.method=euler", "time.step=5e-2"});
  ErrorMonitor monitor(run.scene(), nullptr);
  for (const double time : {0.0, 0.05, 0.1}) monitor.compare(time, run.advance_to(time));
  EXPECT_EQ(monitor.estimate().parted_time, 0.05);

  SimulatedCase good(struck_drum);
  ErrorMonitor calm(good.scene(), nullptr);
  for (const double time : {0.0, 0.05, 0.1}) calm.compare(time, good.advance_to(time));
  EXPECT_FALSE(calm.estimate().parted_time);
}

TEST(ErrorEstimate, EndsWithTheSecondRun) {
  // The second run fails at its first step, since it refuses steps beyond the limit of stability.
  SimulatedCase run(swinging_sheet);
  Case source = run.scene().source;
  source.time.method = TimeMethod::verlet;
  source.time.step = 1.0;
  const auto scene = build_scene(source);
  ErrorMonitor monitor(*scene, nullptr);
  const std::vector<double> y = run.advance_to(0.1);
  EXPECT_TRUE(std::isnan(monitor.compare(0.1, y)[0]));
  EXPECT_NE(monitor.estimate().failure, "");
  EXPECT_EQ(monitor.estimate().bodies.at(0).largest, 0);
}

TEST(ErrorEstimate, StopsWhenTheRunIsStopped) {
  SimulatedCase run(swinging_sheet);
  const std::atomic<int> stop{2};
  ErrorMonitor monitor(run.scene(), &stop);
  EXPECT_TRUE(std::isnan(monitor.compare(0.1, run.advance_to(0.1))[0]));
  EXPECT_EQ(monitor.estimate().failure, "");
}

// Each of two bodies has its own series. The run is the same with and without the estimate.
TEST(ErrorEstimate, IsInTheTrajectoryByFrameAndBody) {
  const std::string second = R"(
[[body]]
name = "still"
position = [3, 0, 0]
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [3, 3] }
[[body.pin]]
rows = [0, -1]
)";
  const auto scene = build_scene(parse_case(swinging_sheet + second, "test.toml"));
  const TemporaryFolder folder;
  const std::string path = folder.path("run.h5");
  RunOptions options;
  options.trajectory = path;
  options.force = true;
  options.estimate_error = true;
  const RunReport report = run_simulation(*scene, options);
  ASSERT_TRUE(report.error_estimate);
  const ErrorEstimate& estimate = *report.error_estimate;
  const TrajectoryReader with(path);
  const std::vector<double> errors = with.series_values("error_estimate_sheet");
  ASSERT_EQ(static_cast<int>(errors.size()), with.frames());
  EXPECT_EQ(errors.front(), 0);
  EXPECT_EQ(errors.back(), estimate.bodies.at(0).last);
  EXPECT_EQ(*std::max_element(errors.begin(), errors.end()), estimate.bodies.at(0).largest);
  EXPECT_GT(estimate.bodies.at(0).largest, 0);
  // A body that pins hold as a whole has no error to estimate.
  EXPECT_THROW(with.series_values("error_estimate_still"), FileError);
  EXPECT_EQ(with.series().back().units, "m");
  const std::vector<Vec3> positions = with.positions(0, with.frames() - 1);

  options.estimate_error = false;
  EXPECT_FALSE(run_simulation(*scene, options).error_estimate);
  EXPECT_EQ(TrajectoryReader(path).positions(0, with.frames() - 1), positions);
}

}  // namespace
}  // namespace weft::sim::error_estimate_test
