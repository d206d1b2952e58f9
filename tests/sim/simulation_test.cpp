// Simulations: the same bits however they are driven, saved states that continue elsewhere, new
// velocities.
#include "sim/simulation/simulation.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "sim/integrator/integrator.h"
#include "sim/run/make_simulation.h"
#include "sim/run/recorded_run.h"
#include "sim/trajectory/trajectory.h"
#include "tests/sim/simulated_case.h"
#include "tests/temporary_folder.h"

namespace weft::sim::simulation_test {
namespace {

// A sheet falls on a ball and slides on it.
constexpr const char* sheet_on_ball = R"(
[time]
duration = 0.1
frames_per_second = 60
[contact]
friction = 0.3
[material.cloth]
bending_stiffness = 1e-5
stiffness_damping = 1e-3
[[body]]
name = "sheet"
position = [0.02, 0, 0.106]
velocity = [0, 0, -0.4]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [13, 13] }
[[obstacle]]
name = "ball"
shape = { type = "sphere", radius = 0.1, resolution = [9] }
)";

Simulation simulation_of(const std::string& text, const Overrides& overrides = {}) {
  return make_simulation(parse_case(text, "test.toml", overrides));
}

std::vector<Vec3> positions_at(Simulation& simulation, double time) {
  if (const auto failure = simulation.advance(time - simulation.time()))
    ADD_FAILURE() << failure->text;
  EXPECT_EQ(simulation.time(), time);
  return simulation.position("sheet");
}

void take_steps(Simulation& simulation, int count) {
  for (int i = 0; i < count; ++i) {
    if (const auto failure = simulation.step()) ADD_FAILURE() << failure->text;
  }
}

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

// Rounds positions to float32, as trajectories store them.
std::vector<Vec3> rounded(std::vector<Vec3> positions) {
  for (Vec3& p : positions) p = p.cast<float>().cast<double>();
  return positions;
}

TEST(Simulation, HasTheSameBitsByEveryDoor) {
  const std::vector<std::pair<std::string, Overrides>> cases{
      {hanging_sheet, {}},
      {hanging_sheet, {"time.accuracy=1e-3"}},
      {hanging_sheet, {"time.accuracy=1e-3", "time.method=cvode"}},
      {hanging_sheet, method("verlet")},
      {sheet_on_ball, {}},
      {sheet_on_ball, method("euler", {"time.step=0.004"})}};
  for (const auto& [text, overrides] : cases) {
    SCOPED_TRACE(overrides.empty() ? "defaults" : overrides.front());
    const TemporaryFolder folder;
    Case source = parse_case(text, "test.toml", overrides);
    correct_accuracy(source);
    RunOptions options;
    options.trajectory = folder.path("run.h5");
    const RunReport report = run_simulation(*build_scene(source), options);
    ASSERT_EQ(report.status, RunReport::Status::done);
    const TrajectoryReader recorded(options.trajectory);
    Simulation in_frames = simulation_of(text, overrides);
    for (int frame = 1; frame < recorded.frames(); ++frame) {
      EXPECT_EQ(rounded(positions_at(in_frames, recorded.time(frame))),
                recorded.positions(0, frame));
    }
    EXPECT_EQ(in_frames.counts().steps, report.counts.steps);
    Simulation at_once = simulation_of(text, overrides);
    EXPECT_EQ(positions_at(at_once, source.time.duration), in_frames.position("sheet"));
    EXPECT_EQ(at_once.velocity("sheet"), in_frames.velocity("sheet"));
    Simulation by_steps = simulation_of(text, overrides);
    take_steps(by_steps, static_cast<int>(report.counts.steps));
    EXPECT_EQ(by_steps.time(), at_once.integrator().time());
    const std::span<const double> last = by_steps.state(), same = at_once.integrator().state();
    EXPECT_TRUE(std::equal(last.begin(), last.end(), same.begin(), same.end()));
  }
}

// Steps are taken before and after the save; multigrid is used so that its coarse matrices age.
TEST(Simulation, GoesOnElsewhereWithTheSameBits) {
  const Overrides multigrid{"time.preconditioner=multigrid"};
  const auto with = [&](const std::string& name, Overrides more, bool by_multigrid) {
    if (by_multigrid) more.insert(more.end(), multigrid.begin(), multigrid.end());
    return method(name, more);
  };
  const std::vector<std::pair<std::string, Overrides>> cases{
      {hanging_sheet, method("euler")},
      {hanging_sheet, with("euler", {"time.step=0.004"}, true)},
      {hanging_sheet, with("euler", {"time.step=0.004", "time.newton=1"}, true)},
      {hanging_sheet, with("implicit_midpoint", {"time.step=0.003"}, true)},
      {hanging_sheet, method("verlet")},
      {hanging_sheet, method("verlet", {"material.cloth.stiffness_damping=1e-4"})},
      {hanging_sheet, method("verlet", {"time.step=2e-4"})},
      {hanging_sheet, method("static", {"time.frames_per_second=200"})},
      {sheet_on_ball, method("euler")},
      {sheet_on_ball, with("euler", {"time.step=0.002"}, true)},
      {sheet_on_ball, with("euler", {"time.step=0.002", "time.newton=1"}, true)},
      {sheet_on_ball, method("implicit_midpoint", {"time.step=5e-4"})}};
  for (const auto& [text, overrides] : cases) {
    std::string title;
    for (const std::string& each : overrides) title += each + ' ';
    SCOPED_TRACE(title);
    Simulation whole = simulation_of(text, overrides), elsewhere = simulation_of(text, overrides);
    take_steps(whole, 8);
    const std::string bytes = whole.save();
    EXPECT_EQ(bytes, whole.save());
    elsewhere.restore(bytes);
    EXPECT_EQ(elsewhere.time(), whole.time());
    EXPECT_EQ(elsewhere.position("sheet"), whole.position("sheet"));
    take_steps(whole, 8);
    take_steps(elsewhere, 8);
    EXPECT_EQ(elsewhere.time(), whole.time());
    EXPECT_EQ(elsewhere.position("sheet"), whole.position("sheet"));
    EXPECT_EQ(elsewhere.velocity("sheet"), whole.velocity("sheet"));
    EXPECT_EQ(elsewhere.counts().linear_iterations, whole.counts().linear_iterations);
    EXPECT_EQ(elsewhere.counts().steps, 16);
  }
}

// Coarse matrices formed beside contact depend on more than the state: on friction at earlier
// iterates, and on stops. They are formed at some of these steps, and kept at others.
TEST(Simulation, GoesOnElsewhereFromEveryStepBesideContact) {
  for (const char* newton : {"time.newton=1", "time.newton=2"}) {
    SCOPED_TRACE(newton);
    const Overrides overrides =
        method("euler", {"time.step=0.004", newton, "time.preconditioner=multigrid"});
    Simulation whole = simulation_of(sheet_on_ball, overrides);
    constexpr int steps_after = 3;
    std::vector<std::vector<Vec3>> at_step, elsewhere;
    for (int step = 0; step < 25; ++step) {
      Simulation other = simulation_of(sheet_on_ball, overrides);
      other.restore(whole.save());
      take_steps(other, steps_after);
      elsewhere.push_back(other.position("sheet"));
      take_steps(whole, 1);
      at_step.push_back(whole.position("sheet"));
    }
    for (int step = 0; step + steps_after <= std::ssize(at_step); ++step)
      EXPECT_EQ(elsewhere[step], at_step[step + steps_after - 1]) << step;
  }
}

// A save between the ends of a step keeps the time between them.
TEST(Simulation, IsSavedWhereItStands) {
  const Overrides steps = method("euler", {"time.step=0.004"});
  Simulation whole = simulation_of(hanging_sheet, steps),
             elsewhere = simulation_of(hanging_sheet, steps);
  const std::vector<Vec3> there = positions_at(whole, 0.01);
  elsewhere.restore(whole.save());
  EXPECT_EQ(elsewhere.time(), 0.01);
  EXPECT_EQ(elsewhere.position("sheet"), there);
  EXPECT_EQ(positions_at(elsewhere, 0.0111), positions_at(whole, 0.0111));
}

TEST(Simulation, RefusesBytesThatAreNotItsOwn) {
  const Overrides steps = method("euler", {"time.step=0.004"});
  Simulation one = simulation_of(hanging_sheet, steps);
  const std::string bytes = one.save();
  Simulation other = simulation_of(hanging_sheet, method("euler", {"time.step=0.005"}));
  EXPECT_EQ(message_of([&] { other.restore(bytes); }), "the saved state of another case");
  EXPECT_EQ(message_of([&] { other.restore("nonsense"); }),
            "a saved state that has been cut short");
  for (const std::size_t size : {bytes.size() / 2, bytes.size() - 1}) {
    EXPECT_EQ(message_of([&] { one.restore(std::string_view(bytes).substr(0, size)); }),
              "a saved state that has been cut short");
  }
  EXPECT_EQ(message_of([&] { one.restore(bytes + "x"); }), "a saved state with too many bytes");
  for (const std::string name : {"cvode", "arkode"}) {
    const Simulation history = simulation_of(hanging_sheet, method(name));
    EXPECT_NE(message_of([&] { static_cast<void>(history.save()); }).find("a run by " + name),
              std::string::npos);
  }
}

class Listener final : public StepObserver {
 public:
  void after_step(const Simulation& simulation) override { times.push_back(simulation.time()); }
  void after_decision(const std::string& text) override { decisions.push_back(text); }
  std::vector<double> times;
  std::vector<std::string> decisions;
};

TEST(Simulation, TellsObserversOfEveryStep) {
  Simulation simulation = simulation_of(hanging_sheet);
  Listener listener;
  simulation.add_observer(listener);
  positions_at(simulation, 0.05);
  EXPECT_EQ(static_cast<std::int64_t>(listener.times.size()), simulation.counts().steps);
  EXPECT_TRUE(std::is_sorted(listener.times.begin(), listener.times.end()));
  EXPECT_GE(listener.times.back(), 0.05);
}

// In free fall, without air, every vertex follows the parabola of its new velocity.
TEST(Simulation, TakesNewVelocities) {
  const std::string falling = R"(
[contact]
enabled = false
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [5, 5] }
)";
  const std::vector<Overrides> methods{method("cvode"),
                                       method("arkode"),
                                       method("euler", {"time.position_tolerance=1e-8"}),
                                       method("implicit_midpoint", {"time.step=0.01"}),
                                       method("verlet"),
                                       method("verlet", {"time.step=0.002"})};
  for (const Overrides& overrides : methods) {
    SCOPED_TRACE(overrides[0]);
    Simulation simulation = simulation_of(falling, overrides);
    Listener listener;
    simulation.add_observer(listener);
    const std::vector<Vec3> start = positions_at(simulation, 0.123);
    const Vec3 velocity(0.3, -0.2, 2.5), gravity(0, 0, -9.81);
    simulation.set_velocity("sheet", std::vector<Vec3>(start.size(), velocity));
    EXPECT_EQ(simulation.counts().restarts, 1);
    ASSERT_FALSE(listener.decisions.empty());
    EXPECT_EQ(listener.decisions.back(),
              "new velocities of \"sheet\" at t = 0.123 s: the method starts anew");
    EXPECT_EQ(simulation.time(), 0.123);
    EXPECT_EQ(simulation.position("sheet"), start);
    EXPECT_EQ(simulation.velocity("sheet"), std::vector<Vec3>(start.size(), velocity));
    const std::vector<Vec3> end = positions_at(simulation, 0.4);
    const double t = 0.4 - 0.123;
    for (std::size_t i = 0; i < end.size(); ++i) {
      const Vec3 expected = start[i] + t * velocity + 0.5 * t * t * gravity;
      EXPECT_LT((end[i] - expected).norm(), 2e-4) << i;
    }
  }
}

// Pinned vertices stay, whatever velocities they are given, and the energy watch accepts the new
// energy.
TEST(Simulation, HoldsPinsWhateverTheNewVelocities) {
  Simulation simulation = simulation_of(hanging_sheet);
  const std::vector<Vec3> start = simulation.position("sheet");
  positions_at(simulation, 0.02);
  simulation.set_velocity("sheet", std::vector<Vec3>(start.size(), Vec3(0, 0, -3)));
  const std::vector<Vec3> end = positions_at(simulation, 0.05);
  EXPECT_EQ(end[72], start[72]);
  EXPECT_EQ(end[80], start[80]);
  EXPECT_LT(end[40].z(), start[40].z() - 0.05);
}

TEST(Simulation, RefusesWrongNamesAndVelocities) {
  Simulation simulation = simulation_of(sheet_on_ball);
  EXPECT_EQ(message_of([&] { static_cast<void>(simulation.position("sheat")); }),
            "no body or obstacle is named \"sheat\"; did you mean \"sheet\"?");
  for (const double seconds : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    EXPECT_EQ(message_of([&] { static_cast<void>(simulation.advance(seconds)); }),
              "a simulation advances by a positive number of seconds");
  }
  const std::vector<Vec3> few(3, Vec3::Zero());
  EXPECT_EQ(message_of([&] { simulation.set_velocity("sheet", few); }),
            "\"sheet\" has 169 vertices, not 3");
  EXPECT_EQ(message_of([&] { simulation.set_velocity("ball", few); }),
            "\"ball\" is wholly prescribed");
  const std::vector<Vec3> wrong(169, Vec3::Constant(std::nan("")));
  EXPECT_EQ(message_of([&] { simulation.set_velocity("sheet", wrong); }),
            "a velocity of \"sheet\" is not finite");
}

// The refusal names the line of the body that is at fault.
TEST(Simulation, RefusesAnObstacleThatIsTooFarAway) {
  const std::string text = std::string(hanging_sheet) +
                           "[[obstacle]]\nname = \"ball\"\n"
                           "shape = { type = \"sphere\", radius = 1e30, resolution = [3] }\n"
                           "motion = { velocity = [0, 0.1, 0] }\n";
  try {
    make_simulation(parse_case(text, "case.toml", {"contact.enabled=true"}));
    FAIL();
  } catch (const CaseError& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.find("case.toml:14:1: the initial state cannot be simulated: "), 0)
        << message;
    EXPECT_NE(message.find("more than 1e15 m from the origin"), std::string::npos) << message;
  }
}

// A scene cannot be built before its accuracy is settled: it would run with arbitrary tolerances.
TEST(Simulation, NeedsASettledAccuracy) {
  EXPECT_THROW(build_scene(parse_case(hanging_sheet, "test.toml", {"time.accuracy=1e-3"})),
               CaseError);
}

// Loads end with the duration.
TEST(Simulation, StaticGoesNoFurtherThanItsLoads) {
  Simulation simulation =
      simulation_of(hanging_sheet, method("static", {"time.frames_per_second=20"}));
  ASSERT_FALSE(simulation.advance(1));
  EXPECT_EQ(simulation.time(), 0.1);
  ASSERT_FALSE(simulation.advance(1));
  EXPECT_EQ(simulation.time(), 0.1);
}

// A failed step has a kind, a time and a place besides its text.
TEST(Simulation, FailsWithData) {
  Simulation simulation = simulation_of(hanging_sheet, method("verlet", {"time.step=0.05"}));
  const auto failure = simulation.step();
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->kind, Failure::Kind::unstable);
  EXPECT_EQ(failure->time, 0);
  EXPECT_GE(failure->particle, 0);
  EXPECT_STREQ(kind_name(failure->kind), "unstable");
}

// Block-Jacobi takes hundreds of iterations on this shell. The function is called every sixteen.
TEST(Simulation, AStepEndsWithinALinearSolve) {
  Simulation simulation = make_simulation(parse_case(R"(
[time]
method = "euler"
step = 1e-3
preconditioner = "block_jacobi"
[contact]
enabled = false
[material.steel]
model = "shell"
youngs_modulus = 2e11
poisson_ratio = 0.3
shell_thickness = 5e-4
volume_density = 7850
[[body]]
name = "plate"
shape = { type = "rectangle", size = [0.2, 0.1], resolution = [21, 21] }
start = { bend_radius = 0.5 }
[[body.pin]]
edges = ["first_col"]
clamp = true
)",
                                                     "test.toml", {}));
  int questions = 0;
  simulation.set_reason_to_stop([&]() -> std::optional<Failure> {
    if (++questions < 4) return std::nullopt;
    return Failure{Failure::Kind::interrupted, 0, -1, "stopped"};
  });
  const std::optional<Failure> failure = simulation.step();
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->kind, Failure::Kind::interrupted);
  EXPECT_EQ(questions, 4);
  EXPECT_LT(simulation.counts().linear_iterations, 64);
  EXPECT_EQ(simulation.time(), 0);
  simulation.set_reason_to_stop({});
  EXPECT_FALSE(simulation.step());
  EXPECT_DOUBLE_EQ(simulation.time(), 1e-3);
}

// Frames are evaluated between steps, and must not change these. The towel slides over a rail in
// air, where steps take several corrections.
TEST(Simulation, StepsDoNotDependOnFrames) {
  const char* const towel = R"(
[contact]
friction = 0.4
[material.terry]
density = 0.4
membrane_stiffness = 500
bending_stiffness = 2e-5
stiffness_damping = 1e-3
bending_damping = 1e-3
normal_drag = 1.0
[[body]]
name = "towel"
position = [0.03, 0, 0.03]
thickness = 2e-3
shape = { type = "rectangle", size = [1, 0.5], resolution = [9, 17] }
[[obstacle]]
name = "rail"
rotation_deg = [90, 0, 0]
thickness = 2e-3
shape = { type = "cylinder", radius = 0.02, length = 0.7, resolution = [29, 13] }
)";
  for (const char* method : {"cvode", "arkode", "euler"}) {
    SCOPED_TRACE(method);
    const Overrides overrides{std::string("time.method=\"") + method + "\""};
    Simulation alone(build_scene(parse_case(towel, "case.toml", overrides)));
    Simulation recorded(
        build_scene(parse_case(towel, "case.toml", {overrides[0], "time.frames_per_second=1000"})));
    std::vector<double> frame(recorded.state().size());
    while (alone.time() < 0.15) {
      ASSERT_FALSE(alone.step());
      ASSERT_FALSE(recorded.step());
      ASSERT_TRUE(std::ranges::equal(alone.state(), recorded.state())) << alone.time();
      const double middle = recorded.time() - 0.5 * recorded.integrator().last_step();
      ASSERT_FALSE(recorded.state_at(middle, frame));
      static_cast<void>(recorded.summary_of(middle, frame));
    }
  }
}

// A step of backward Euler moves by its last velocity, so that the slope of a cubic through both
// ends would pass the velocities of both.
TEST(Simulation, FramesOfEulerHaveVelocitiesBetweenThoseOfTheStep) {
  Simulation simulation = simulation_of(
      sheet_on_ball, {"time.method=\"euler\"", "time.step=0.01", "contact.enabled=false"});
  ASSERT_FALSE(simulation.step());
  std::vector<double> frame(simulation.state().size());
  for (const double part : {0.25, 0.5, 0.75}) {
    ASSERT_FALSE(simulation.state_at(part * 0.01, frame));
    EXPECT_NEAR(frame.back(), -0.4 - 9.81 * part * 0.01, 1e-5) << part;
  }
}

}  // namespace
}  // namespace weft::sim::simulation_test
