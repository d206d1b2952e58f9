// Runs that go on from a checkpoint have the bits of runs that were never stopped.
#include "sim/run/resumption.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

#include "sim/case/case_error.h"
#include "sim/run/recorded_run.h"
#include "sim/simulation/checkpoint_schedule.h"
#include "sim/simulation/simulation.h"
#include "sim/trajectory/trajectory.h"
#include "tests/sim/same_datasets.h"
#include "tests/sim/simulated_case.h"
#include "tests/temporary_folder.h"

namespace weft::sim::resume_test {
namespace {

// A sheet falls on a ball, slides on it and folds over it.
constexpr const char* sheet_on_ball = R"(
[time]
duration = 0.12
frames_per_second = 150
[contact]
friction = 0.3
[output]
velocity = true
checkpoint_every = 0.03
[material.cloth]
bending_stiffness = 1e-5
stiffness_damping = 1e-3
[[body]]
name = "sheet"
position = [0.02, 0, 0.106]
velocity = [0, 0, -0.4]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [9, 9] }
[[obstacle]]
name = "ball"
shape = { type = "sphere", radius = 0.1, resolution = [9] }
)";

// A strip that stands on its edge falls to the floor and folds on itself.
constexpr const char* folding_strip = R"(
[time]
duration = 0.3
frames_per_second = 100
[output]
checkpoint_every = 0.06
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

// Two small sheets: one comes to rest on a table and sleeps until the other falls on it.
constexpr const char* sleeping_sheets = R"(
[time]
duration = 1.3
frames_per_second = 20
[output]
checkpoint_every = 0.2
[material.cloth]
mass_damping = 20
stiffness_damping = 1e-3
[[body]]
name = "lower"
position = [0, 0, 0.003]
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [4, 4] }
[[body]]
name = "upper"
position = [0.01, 0.01, 0.6]
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [4, 4] }
[[obstacle]]
name = "table"
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3] }
)";

// Balls that fall into each other on a floor, and roll apart.
constexpr const char* rolling_balls = R"(
[time]
method = "impulses"
duration = 0.6
[contact]
friction = 0.3
[output]
velocity = true
checkpoint_every = 0.1
[[particles]]
name = "balls"
radius = 0.02
positions = { type = "grid", count = [3, 3, 3], centre = [0, 0, 0.15], jitter = 0.001 }
[[obstacle]]
name = "floor"
shape = { type = "plane", size = [9, 9] }
)";

// Balls that fall into a sheet, which hangs by two edges.
constexpr const char* balls_in_a_sheet = R"(
[time]
duration = 0.15
frames_per_second = 100
[contact]
friction = 0.3
[output]
velocity = true
checkpoint_every = 0.03
[material.cloth]
stiffness_damping = 1e-3
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [9, 9] }
[[body.pin]]
edges = ["first_row", "last_row"]
[[particles]]
name = "balls"
radius = 0.02
density = 200
velocity = [0, 0, -1]
positions = { type = "grid", count = [2, 2, 2], centre = [0, 0, 0.08], jitter = 0.001 }
)";

// A sheet falls on a tie to a plate, which breaks.
constexpr const char* torn_sheet = R"(
[time]
duration = 0.2
frames_per_second = 100
[contact]
enabled = false
[output]
channels = ["reactions"]
checkpoint_every = 1e-9
[material.cloth]
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [4, 4] }
[[obstacle]]
name = "plate"
position = [0, 0, 1]
shape = { type = "rectangle", size = [1, 1], resolution = [2, 2] }
[[tie]]
body = "sheet"
to = "plate"
rows = [0, -1]
stiffness = 80
break_force = 2
)";

const Overrides often{"output.checkpoint_every=0.02"};

Overrides with(const Overrides& some, const Overrides& more) {
  Overrides all = some;
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

struct Variant {
  std::string text;
  Overrides overrides;
  bool estimates_error = false;
};

// Returns all methods and features whose state a checkpoint holds.
std::vector<Variant> variants() {
  return {
      {hanging_sheet, with(method("cvode"), often)},
      {hanging_sheet, with(method("arkode"), often)},
      {hanging_sheet, with(method("arkode", {"time.position_tolerance=1e-7"}), often)},
      {hanging_sheet, with(method("euler"), often)},
      {hanging_sheet,
       with(method("euler", {"time.step=0.004", "time.newton=1", "time.preconditioner=multigrid"}),
            often)},
      {hanging_sheet, with(method("implicit_midpoint", {"time.step=0.003"}), often)},
      {hanging_sheet, with(method("verlet"), often)},
      {hanging_sheet, with(method("verlet", {"time.step=2e-4"}), often)},
      {hanging_sheet, with(method("static", {"time.frames_per_second=200"}), often)},
      {hanging_sheet,
       with(method("static", {"time.frames_per_second=200", "static.loading=\"in_time\""}), often)},
      {hanging_sheet, with(method("cvode", {"time.accuracy=1e-3"}), often)},
      {hanging_sheet, with(method("cvode"), often), true},
      {hanging_sheet,
       with(method("cvode", {"output.precision=float64", "output.compression=bounded",
                             "output.channels=[\"membrane_strain\", \"reactions\", "
                             "\"body_energy\", \"largest_stretch_place\"]",
                             "output.step_energies=true", "output.frame_times=[0.01, 0.055]"}),
            often)},
      {hanging_sheet, with(method("cvode", {"body.sheet.pin.0.release_time=0.05"}), often)},
      {hanging_sheet, with(method("cvode", {"material.cloth.yield_curvature=1"}), often)},
      // An obstacle that moves without contact.
      {std::string(hanging_sheet) +
           "[[obstacle]]\nname = \"plate\"\nmotion = { velocity = [0, 0, 1] }\n"
           "shape = { type = \"rectangle\", size = [1, 1], resolution = [2, 2] }\n",
       with(method("cvode"), often)},
      {sheet_on_ball, method("cvode")},
      {sheet_on_ball, method("cvode"), true},
      {sheet_on_ball, method("arkode")},
      {sheet_on_ball, method("euler", {"time.step=0.002"})},
      {folding_strip, {}},
      {sleeping_sheets, {}},
      {torn_sheet, {}},
      {torn_sheet, method("euler")},
      {rolling_balls, {}},
      {balls_in_a_sheet, {}},
      {balls_in_a_sheet, method("euler")},
  };
}

std::string title_of(const Variant& variant) {
  std::string title = variant.text.substr(0, 40);
  for (const std::string& each : variant.overrides) title += ' ' + each;
  return title + (variant.estimates_error ? " with an estimate of its error" : "");
}

class Resume : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_.path(name); }
  const TemporaryFolder& folder() const { return folder_; }

  struct Outcome {
    RunReport report;
    std::int64_t steps = 0;  // steps that this call took
  };
  // Runs a case. Stops after `most_steps` steps, if that is positive.
  Outcome run(const Variant& variant, const std::string& file, bool resume,
              std::int64_t most_steps = 0) const {
    Outcome outcome;
    std::atomic<int> stop{0};
    RunOptions options;
    options.trajectory = path(file);
    options.resume = resume;
    options.estimate_error = variant.estimates_error;
    options.stop_signal = &stop;
    const Case source = parse_case(variant.text, "test.toml", variant.overrides);
    // The steps of a pilot do not count.
    bool is_pilot = source.time.accuracy.has_value();
    options.notice = [&](const std::string& text) {
      is_pilot = text.starts_with("pilot of time.accuracy");
    };
    options.progress = [&](double) {
      if (is_pilot) return;
      if (++outcome.steps == most_steps) stop = SIGTERM;
    };
    outcome.report = run_simulation(source, options);
    return outcome;
  }
  static void expect_equal_reports(const RunReport& one, const RunReport& other) {
    EXPECT_EQ(one.status, RunReport::Status::done) << one.reason;
    EXPECT_EQ(one.simulated_time, other.simulated_time);
    EXPECT_EQ(one.frames, other.frames);
    EXPECT_EQ(one.counts.steps, other.counts.steps);
    EXPECT_EQ(one.counts.linear_iterations, other.counts.linear_iterations);
    EXPECT_EQ(one.statistics.counters.bound_tests, other.statistics.counters.bound_tests);
    EXPECT_EQ(one.smallest_gap, other.smallest_gap);
    EXPECT_EQ(one.largest_stretch, other.largest_stretch);
    EXPECT_EQ(one.energies, other.energies);
    EXPECT_EQ(one.decision, other.decision);
    ASSERT_EQ(one.error_estimate.has_value(), other.error_estimate.has_value());
    if (!one.error_estimate) return;
    EXPECT_EQ(one.error_estimate->bodies[0].largest, other.error_estimate->bodies[0].largest);
    EXPECT_EQ(one.error_estimate->parted_time, other.error_estimate->parted_time);
  }

 private:
  TemporaryFolder folder_;
};

TEST(CheckpointSchedule, CountsStepsUnlessATimeIsGiven) {
  CheckpointSchedule steps(parse_case(hanging_sheet, "test.toml", method("cvode")));
  for (int i = 0; i < 500; ++i) {
    EXPECT_FALSE(steps.is_due(0.1 * i)) << i;
    steps.add_step();
  }
  EXPECT_TRUE(steps.is_due(50));
  steps.start(50);
  EXPECT_FALSE(steps.is_due(50));
  const std::pair<const char*, int> counts[] = {
      {"arkode", 500}, {"euler", 500}, {"verlet", 5000}, {"static", 10}};
  for (const auto& [name, count] : counts) {
    CheckpointSchedule other(parse_case(hanging_sheet, "test.toml", method(name)));
    for (int i = 1; i < count; ++i) other.add_step();
    EXPECT_FALSE(other.is_due(1)) << name;
    other.add_step();
    EXPECT_TRUE(other.is_due(1)) << name;
  }
  CheckpointSchedule times(parse_case(hanging_sheet, "test.toml", often));
  for (int i = 0; i < 1000; ++i) times.add_step();
  EXPECT_FALSE(times.is_due(0.019));
  EXPECT_TRUE(times.is_due(0.021));
  EXPECT_TRUE(times.is_due(0.2));
  times.start(0.0399);
  EXPECT_FALSE(times.is_due(0.0399));
  EXPECT_TRUE(times.is_due(0.0401));
}

// Checkpoints are written at most four times per second.
TEST_F(Resume, CheckpointsWaitUntilTheLastOneIsAQuarterOfASecondOld) {
  using Clock = std::chrono::steady_clock;
  const auto seconds_since = [](Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
  };
  Clock::time_point start = Clock::now();
  WaitingCheckpoint waiting(path("run.h5"));
  EXPECT_FALSE(waiting.is_due(100));  // there is none
  for (int i = 0; i < 2; ++i) {
    waiting.keep({});
    const bool is_due = waiting.is_due(0);
    EXPECT_TRUE(!is_due || seconds_since(start) >= 0.25);
    EXPECT_TRUE(waiting.is_due(0.25));  // before work that takes so long
    std::this_thread::sleep_for(std::chrono::milliseconds(250));
    EXPECT_TRUE(waiting.is_due(0));
    start = Clock::now();
    waiting.write();
    EXPECT_TRUE(std::filesystem::exists(path("run.checkpoint")));
    EXPECT_FALSE(waiting.is_due(100));
  }
}

// A simulation that is renewed goes on like another one that is restored, with the same counts.
TEST_F(Resume, RenewedSimulationsEqualRestoredOnes) {
  for (const Variant& variant : variants()) {
    SCOPED_TRACE(title_of(variant));
    Case source = parse_case(variant.text, "test.toml", variant.overrides);
    if (source.time.accuracy) continue;
    const auto scene = build_scene(source);
    Simulation whole(*scene), elsewhere(*scene);
    const int steps = source.time.method == TimeMethod::static_loads ? 4 : 25;
    for (int i = 0; i < steps; ++i) ASSERT_FALSE(whole.step());
    elsewhere.restore(whole.renew());
    for (int i = 0; i < steps; ++i) {
      ASSERT_FALSE(whole.step());
      ASSERT_FALSE(elsewhere.step());
    }
    EXPECT_EQ(elsewhere.time(), whole.time());
    EXPECT_TRUE(std::ranges::equal(elsewhere.state(), whole.state()));
    EXPECT_EQ(elsewhere.counts().steps, whole.counts().steps);
    EXPECT_EQ(elsewhere.counts().linear_iterations, whole.counts().linear_iterations);
    EXPECT_EQ(elsewhere.statistics().counters.candidate_pairs,
              whole.statistics().counters.candidate_pairs);
    EXPECT_EQ(elsewhere.statistics().counters.rebuilds, whole.statistics().counters.rebuilds);
  }
}

// Older versions wrote a patch of loads on areas, which case files must not have.
TEST_F(Resume, KnowsTheCaseOfAnOlderVersion) {
  Case source = parse_case(std::string(hanging_sheet) +
                               "[[load]]\nbody = \"sheet\"\ntype = \"pressure\"\npressure = 1\n",
                           "test.toml");
  std::string older = source.resolved_text;
  const std::string pressure = "pressure = 1.0\n";
  older.insert(older.find(pressure) + pressure.size(), "patch = 0\n");
  const bsi::Surface surface = bsi::make_rectangle(1, 1, 3, 3);
  TrajectoryWriter(path("older.h5"), {{"cloth", surface.atlas, true, false, 0}}, {},
                   {.case_text = older}, {surface.positions});
  EXPECT_FALSE(find_resumption(path("older.h5"), source, {}).checkpoint);
}

// A run that is stopped twice and resumed equals one that was never stopped, and takes again no
// step from before its last checkpoint.
TEST_F(Resume, EqualsARunThatWasNeverStopped) {
  int number = 0, resumed = 0;
  for (const Variant& variant : variants()) {
    SCOPED_TRACE(title_of(variant));
    const std::string name = std::to_string(++number);
    const Outcome whole = run(variant, name + "_whole.h5", false);
    ASSERT_EQ(whole.report.status, RunReport::Status::done) << whole.report.reason;
    const std::int64_t all = whole.steps;
    const std::string file = name + "_parts.h5";
    run(variant, file, false, all / 2);
    for (const std::int64_t more : {all / 4 + 1, std::int64_t{0}}) {
      const auto checkpoint = read_checkpoint(path(file));
      const std::int64_t before = checkpoint ? checkpoint->steps : 0;
      const Outcome part = run(variant, file, true, more);
      EXPECT_EQ(part.report.resumed_at.has_value(), checkpoint.has_value());
      resumed += checkpoint ? 1 : 0;
      if (more != 0) continue;
      expect_equal_reports(part.report, whole.report);
      EXPECT_EQ(part.steps, all - before);
    }
    std::vector<std::string> differing = differing_datasets(path(name + "_whole.h5"), path(file));
    // The case tells the CPU time of a pilot.
    if (title_of(variant).find("time.accuracy") != std::string::npos) std::erase(differing, "case");
    EXPECT_EQ(differing, std::vector<std::string>{});
  }
  EXPECT_GE(resumed, 2 * number - 6);
}

}  // namespace
}  // namespace weft::sim::resume_test
