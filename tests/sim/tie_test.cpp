// Ties against closed forms and conservation laws.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/sim/bad_case.h"
#include "tests/sim/joint_cases.h"

namespace weft::sim::tie_test {
namespace {

constexpr double gravity = 9.81;  // m/s^2

// Two sheets in space, a little apart, that move and spin differently; the lower row of one is tied
// to the other.
constexpr const char* tied_sheets = R"(
[time]
duration = 0.2
frames_per_second = 50
method = "verlet"
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.cloth]
bending_stiffness = 1e-4
[[body]]
name = "upper"
position = [0.01, 0.02, 0.05]
velocity = [0.1, 0, 0.3]
angular_velocity_deg = [40, 20, 90]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [7, 7] }
[[body]]
name = "lower"
shape = { type = "rectangle", size = [0.4, 0.3], resolution = [5, 9] }
[[tie]]
body = "upper"
to = "lower"
edges = ["first_row"]
stiffness = 500
)";

// A stiff sheet in an upright plane, all of whose vertices are tied to a plate: it moves along z as
// a point of its mass, 0.2 kg, on a spring.
constexpr const char* sheet_on_a_spring = R"(
[time]
duration = 0.5
position_tolerance = 1e-7
[contact]
enabled = false
[material.stiff]
density = 0.2
membrane_stiffness = 1e5
[[body]]
name = "sheet"
rotation_deg = [90, 0, 0]
shape = { type = "rectangle", size = [1, 1], resolution = [5, 5] }
[[obstacle]]
name = "plate"
position = [0, 1, 0]
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3] }
[[tie]]
body = "sheet"
to = "plate"
rows = [0, -1]
stiffness = 80
)";
constexpr double mass = 0.2;                            // kg
const double angular_frequency = std::sqrt(80 / mass);  // 1/s

// A pin holds a sheet. From 0.1 s on, a plate 1 m below pulls at it by a tie, which stretches by
// 1 m/s: after d seconds with 300 N/m d, which makes 150 J d^2.
constexpr const char* held_sheet = R"(
[time]
duration = 0.6
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.cloth]
density = 0.2
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3] }
[[body.pin]]
rows = [0, 1]
[[obstacle]]
name = "plate"
position = [0, 0, -1]
shape = { type = "rectangle", size = [2, 2], resolution = [3, 3] }
motion = { velocity = [0, 0, -1], start_time = 0.1 }
[[tie]]
body = "sheet"
to = "plate"
edges = ["first_row"]
stiffness = 300
break_force = 60
)";

double energy_of_ties(const Energies& energies) {
  for (const auto& [name, energy] : energies.elastic) {
    if (name == "ties") return energy;
  }
  ADD_FAILURE() << "no energy of ties";
  return 0;
}

// Returns the energy (J) of ties in the frame at `time`, within the last step.
double energy_of_ties_at(const Simulation& simulation, double time) {
  std::vector<double> y(simulation.state().size());
  if (const auto failure = simulation.state_at(time, y)) ADD_FAILURE() << failure->text;
  return energy_of_ties(simulation.summary_of(time, y).energies);
}

// Keeps the reports of ties that break.
class Listener final : public StepObserver {
 public:
  explicit Listener(Simulation& simulation) { simulation.add_observer(*this); }
  void after_step(const Simulation& /*simulation*/) override {}
  void after_decision(const std::string& text) override {
    if (text.starts_with("tie breaks")) breaks.push_back(text);
  }
  std::vector<std::string> breaks;
};

Vec3 momentum(Simulation& simulation) {
  const StateView state = StateView::of(simulation.state());
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < state.velocity.size(); ++i)
    sum += simulation.scene().mass[i] * state.velocity[i];
  return sum;
}

Vec3 angular_momentum(Simulation& simulation) {
  const StateView state = StateView::of(simulation.state());
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < state.velocity.size(); ++i)
    sum += simulation.scene().mass[i] * state.position[i].cross(state.velocity[i]);
  return sum;
}

}  // namespace

TEST(Tie, ForcesAreSlopesOfTheEnergy) {
  expect_consistent_forces(tied_sheets, 0);
  expect_consistent_forces(sheet_on_a_spring, 0);
}

// A vertex at the corner of a sheet has half the area of one inside its edge.
TEST(Tie, SharesItsStiffnessByArea) {
  const auto scene = build_scene(parse_case(tied_sheets, "test.toml"));
  const std::vector<TieSpring>& springs = scene->ties.at(0).springs;
  ASSERT_EQ(springs.size(), 7);
  double sum = 0;
  for (const TieSpring& spring : springs) sum += spring.share;
  EXPECT_NEAR(sum, 1, 1e-14);
  EXPECT_NEAR(springs.front().share + springs.back().share, springs[3].share, 1e-14);
}

TEST(Tie, ConservesMomentumAndAngularMomentum) {
  Simulation simulation = simulation_of(tied_sheets);
  const Vec3 start = momentum(simulation), spin = angular_momentum(simulation);
  const std::vector<Vec3> lower = simulation.position("lower");
  // Interpolated states conserve less than those at the ends of steps.
  while (simulation.time() < 0.2) {
    if (const auto failure = simulation.step()) FAIL() << failure->text;
  }
  EXPECT_LT((momentum(simulation) - start).norm(), 1e-12);
  EXPECT_LT((angular_momentum(simulation) - spin).norm(), 1e-12);
  // The tie pulls the other sheet along.
  EXPECT_GT((mean_of(simulation.position("lower")) - mean_of(lower)).norm(), 0.005);
}

TEST(Tie, SwingsASheetAsASpringDoes) {
  for (const char* name : {"cvode", "arkode", "verlet"}) {
    SCOPED_TRACE(name);
    Simulation simulation = simulation_of(sheet_on_a_spring, method(name));
    const double start = mean_of(simulation.position("sheet")).z();
    for (const double time : {0.1, 0.3, 0.5}) {
      advance_to(simulation, time);
      const double expected = -gravity / (angular_frequency * angular_frequency) *
                              (1 - std::cos(angular_frequency * time));
      EXPECT_NEAR(mean_of(simulation.position("sheet")).z() - start, expected, 2e-4) << time;
    }
  }
}

// At rest the sheet hangs m g / k below its place; carried on, it follows within that.
TEST(Tie, FollowsItsObstacleWithinTheStiffness) {
  const Overrides carried{
      "obstacle.plate.motion.keyframes=[{time=0.1},{time=0.6,translation=[0.2,0,0.3],rotation_deg="
      "[0,0,30]}]",
      "obstacle.plate.motion.centre=[0,0,0]", "material.stiff.mass_damping=20",
      "tie.0.stiffness=2e4", "time.duration=1.5"};
  for (const char* name : {"cvode", "euler"}) {
    SCOPED_TRACE(name);
    Overrides all = method(name, carried);
    Simulation simulation = simulation_of(sheet_on_a_spring, all);
    const std::vector<Vec3> start = simulation.position("sheet");
    advance_to(simulation, 1.5);
    const Eigen::Matrix3d turn = rotation_from_degrees({0, 0, 30});
    const std::vector<Vec3> places = simulation.position("sheet");
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Vec3 expected = turn * start[i] + Vec3(0.2, 0, 0.3) - Vec3(0, 0, mass * gravity / 2e4);
      EXPECT_LT((places[i] - expected).norm(), 1e-5) << i;
    }
  }
}

// Steps end at the keyframes of an obstacle to which something is tied, without contact, too.
TEST(Tie, StepsEndAtTheKeyframesOfItsObstacle) {
  Simulation simulation = simulation_of(
      sheet_on_a_spring,
      {"obstacle.plate.motion.velocity=[0,0,1]", "obstacle.plate.motion.start_time=0.0371"});
  bool ends = false;
  while (simulation.time() < 0.1) {
    if (const auto failure = simulation.step()) FAIL() << failure->text;
    ends = ends || simulation.time() == 0.0371;
  }
  EXPECT_TRUE(ends);
}

// The load is m g (1 - cos w t), 1.5 m g at w t = 2 pi / 3; from then on the sheet falls freely.
TEST(Tie, BreaksAtItsForce) {
  const double breaking = 2 * std::numbers::pi / 3 / angular_frequency;
  const double below = 1.5 * gravity / (angular_frequency * angular_frequency);
  const double speed = gravity / angular_frequency * std::sin(2 * std::numbers::pi / 3);
  const Overrides breaks{"tie.0.break_force=" + std::to_string(1.5 * mass * gravity)};
  for (const char* name : {"cvode", "arkode", "euler", "verlet"}) {
    SCOPED_TRACE(name);
    const double error = std::string_view(name) == "euler" ? 4e-3 : 4e-4;
    Simulation simulation = simulation_of(sheet_on_a_spring, method(name, breaks));
    const double start = mean_of(simulation.position("sheet")).z();
    advance_to(simulation, breaking + 0.2);
    EXPECT_NEAR(mean_of(simulation.position("sheet")).z() - start,
                -below - 0.2 * speed - 0.5 * gravity * 0.04, error);
    EXPECT_NEAR(mean_of(simulation.velocity("sheet")).z(), -speed - 0.2 * gravity, 20 * error);
  }
}

TEST(Tie, HoldsUpToItsForce) {
  Simulation simulation = simulation_of(
      sheet_on_a_spring, {"tie.0.break_force=" + std::to_string(2.1 * mass * gravity)});
  const double start = mean_of(simulation.position("sheet")).z();
  advance_to(simulation, 0.5);
  EXPECT_GT(mean_of(simulation.position("sheet")).z() - start, -0.06);
}

// Frames of the step in which a tie breaks show it up to the time at which it breaks.
TEST(Tie, IsInFramesUntilItBreaks) {
  for (const char* name : {"cvode", "arkode", "euler", "verlet"}) {
    SCOPED_TRACE(name);
    Simulation simulation = simulation_of(held_sheet, method(name));
    Listener listener(simulation);
    double start = 0;
    while (simulation.time() < 0.6) {
      if (const auto failure = simulation.step()) FAIL() << failure->text;
      const double end = simulation.time();
      const bool is_broken = !listener.breaks.empty();
      EXPECT_TRUE(is_broken || end < 0.3 + 1e-6) << end;
      for (const double part : {0.3, 0.7, 1.0}) {
        const double time = std::lerp(start, end, part), pulled = std::max(time - 0.1, 0.0);
        const bool is_there = time < 0.3 - 1e-6 || !is_broken;
        const double expected = is_there ? 150 * pulled * pulled : 0;
        EXPECT_NEAR(energy_of_ties_at(simulation, time), expected, 1e-3) << time;
      }
      const double last = energy_of_ties(simulation.energies());
      EXPECT_NEAR(last, energy_of_ties_at(simulation, end), 1e-9) << end;
      start = end;
    }
    ASSERT_EQ(listener.breaks.size(), 1U);
    EXPECT_EQ(listener.breaks.front(), "tie breaks at t = 0.3 s: \"sheet\" to \"plate\"");
  }
}

// The steps of a held sheet are long: the last one may end far beyond the run.
TEST(Tie, BreaksNotBeforeTheEndOfItsStep) {
  Simulation simulation = simulation_of(held_sheet, {"tie.0.break_force=600"});
  Listener listener(simulation);
  while (simulation.time() < 0.6) {
    if (const auto failure = simulation.step()) FAIL() << failure->text;
  }
  EXPECT_GT(simulation.time(), 1);
  EXPECT_EQ(listener.breaks, std::vector<std::string>{});
  EXPECT_NEAR(energy_of_ties_at(simulation, 0.6), 150 * 0.25, 1e-3);
}

// A body sleeps while the tie of another one breaks.
TEST(Tie, BreaksBesideASleepingBody) {
  const std::string other = R"([[body]]
name = "other"
position = [5, 0, 0]
rotation_deg = [90, 0, 0]
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [4, 4] }
[[body.pin]]
edges = ["last_row"]
)";
  Simulation simulation = simulation_of(
      held_sheet + other,
      {"time.duration=4", "obstacle.plate.motion.start_time=3", "body.sheet.pin.0.rows=[0,0]",
       "tie.0.edges=[\"last_row\"]", "world.gravity=[0,0,-9.81]", "material.cloth.mass_damping=20",
       "material.cloth.membrane_stiffness=2000"});
  Listener listener(simulation);
  double energy = 0;
  while (listener.breaks.empty()) {
    ASSERT_LT(simulation.time(), 3.9);
    energy = energy_of_ties(simulation.energies());
    const auto summary = simulation.summary_of(simulation.time(), simulation.state());
    EXPECT_NEAR(energy_of_ties(summary.energies), energy, 1e-9);
    EXPECT_TRUE(simulation.time() < 2.9 || summary.sleeping_bodies == 1);
    if (const auto failure = simulation.step()) FAIL() << failure->text;
  }
  // k d = 60 N where all springs are stretched alike.
  EXPECT_NEAR(energy, 60.0 * 60 / (2 * 300), 0.01);
  EXPECT_EQ(energy_of_ties(simulation.energies()), 0);
}

// A simulation that is saved after any step goes on with the same bits, also after the step at
// whose end a tie breaks.
TEST(Tie, ContinuesFromBytesWhereItBreaks) {
  for (const char* name : {"euler", "verlet"}) {
    SCOPED_TRACE(name);
    const Overrides overrides =
        method(name, {"tie.0.break_force=" + std::to_string(1.5 * mass * gravity)});
    Simulation simulation = simulation_of(sheet_on_a_spring, overrides);
    Simulation again = simulation_of(sheet_on_a_spring, overrides);
    Listener listener(simulation);
    std::string bytes;
    while (listener.breaks.empty()) {
      ASSERT_LT(simulation.time(), 0.2);
      bytes = simulation.save();
      if (const auto failure = simulation.step()) FAIL() << failure->text;
    }
    again.restore(bytes);
    EXPECT_GT(energy_of_ties(again.energies()), 0);
    EXPECT_GT(energy_of_ties_at(again, again.time() - 0.5 * again.integrator().last_step()), 0);
    if (const auto failure = again.step()) FAIL() << failure->text;
    EXPECT_EQ(again.time(), simulation.time());
    EXPECT_TRUE(std::ranges::equal(again.state(), simulation.state()));
  }
}

// New velocities at the end of the step in which a tie breaks do not mend it.
TEST(Tie, StaysBrokenWhateverTheNewVelocities) {
  Simulation simulation = simulation_of(
      sheet_on_a_spring,
      method("verlet", {"tie.0.break_force=" + std::to_string(1.5 * mass * gravity)}));
  const double most = 1.5 * mass * gravity * 1.5 * mass * gravity / (2 * 80);  // J
  while (energy_of_ties(simulation.energies()) < 0.999999 * most) {
    ASSERT_LT(simulation.time(), 0.2);
    if (const auto failure = simulation.step()) FAIL() << failure->text;
  }
  const double start = mean_of(simulation.position("sheet")).z(), time = simulation.time();
  const std::vector<Vec3> up(simulation.position("sheet").size(), Vec3(0, 0, 1));
  simulation.set_velocity("sheet", up);
  advance_to(simulation, time + 0.1);
  EXPECT_NEAR(mean_of(simulation.position("sheet")).z() - start, 0.1 - 0.5 * gravity * 0.01, 1e-5);
}

TEST(Tie, ContinuesFromBytesAfterBreaking) {
  const Overrides overrides =
      method("verlet", {"tie.0.break_force=" + std::to_string(1.5 * mass * gravity)});
  Simulation simulation = simulation_of(sheet_on_a_spring, overrides);
  Simulation again = simulation_of(sheet_on_a_spring, overrides);
  advance_to(simulation, 0.2);
  again.restore(simulation.save());
  advance_to(simulation, 0.4);
  advance_to(again, 0.4);
  EXPECT_EQ(simulation.position("sheet"), again.position("sheet"));
}

// The work of the obstacle counts as energy put in: no step is refused, though the sheet gains it.
TEST(Tie, AnObstacleThatPullsDoesWork) {
  Simulation simulation = simulation_of(
      sheet_on_a_spring, {"world.gravity=[0,0,0]", "obstacle.plate.motion.velocity=[0,0,3]",
                          "obstacle.plate.motion.start_time=0.05"});
  const double start = mean_of(simulation.position("sheet")).z();
  advance_to(simulation, 0.5);
  const double since = angular_frequency * 0.45;
  EXPECT_NEAR(mean_of(simulation.position("sheet")).z() - start,
              3 * 0.45 - 3 / angular_frequency * std::sin(since), 1e-3);
}

// Neither of two tied sheets sleeps while the other moves.
TEST(Tie, TiedBodiesSleepTogether) {
  const std::string text = R"(
[time]
duration = 8
[contact]
enabled = false
[material.cloth]
mass_damping = 8
[[body]]
name = "held"
rotation_deg = [90, 0, 0]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [5, 5] }
[[body.pin]]
edges = ["last_row"]
[[body]]
name = "tied"
position = [0, 0.01, -0.3]
rotation_deg = [90, 0, 0]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [5, 5] }
[[body]]
name = "free"
position = [2, 0, 0]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [5, 5] }
[[body.pin]]
corners = ["first_first"]
[[tie]]
body = "tied"
to = "held"
edges = ["last_row"]
)";
  Simulation simulation =
      simulation_of(text, {"body.free.pin.0.motion.angular_velocity_deg=[0,0,90]"});
  int most = 0;
  while (simulation.time() < 8) {
    if (const auto failure = simulation.step()) FAIL() << failure->text;
    const int asleep = simulation.summary_of(simulation.time(), simulation.state()).sleeping_bodies;
    EXPECT_NE(asleep, 1);
    most = std::max(most, asleep);
  }
  EXPECT_EQ(most, 2);
}

TEST(Tie, GivesTheSameBitsOnAnyNumberOfThreads) {
  Simulation one = simulation_of(tied_sheets, method("cvode", {"compute.threads=1"}));
  Simulation four = simulation_of(tied_sheets, method("cvode", {"compute.threads=4"}));
  advance_to(one, 0.05);
  advance_to(four, 0.05);
  EXPECT_EQ(one.position("upper"), four.position("upper"));
}

namespace {

const std::string two_sheets = sheet +
                               "[[body]]\nname = \"other\"\nposition = [0, 0, 1]\nshape = " +
                               "{ type = \"rectangle\", size = [1, 1], resolution = [3, 3] }\n";

BadCase bad(const std::string& name, const std::string& tie, const std::string& what,
            const Overrides& overrides = {}) {
  return {name, two_sheets + "[[tie]]\n" + tie, "case.toml:" + what, overrides};
}

}  // namespace

class BadTie : public testing::TestWithParam<BadCase> {};
TEST_P(BadTie, IsRefused) { expect_refused(GetParam()); }
INSTANTIATE_TEST_SUITE_P(
    Cases, BadTie,
    testing::Values(
        bad("unknown_body", "body = \"shet\"\nto = \"other\"\nedges = [\"first_row\"]\n",
            "9:8: no body \"shet\"\n  did you mean \"sheet\"?"),
        bad("to_nothing", "body = \"sheet\"\nto = \"othr\"\nedges = [\"first_row\"]\n",
            "10:6: no body or obstacle \"othr\"\n  did you mean \"other\"?"),
        bad("to_itself", "body = \"sheet\"\nto = \"sheet\"\nedges = [\"first_row\"]\n",
            "10:6: a tie of body \"sheet\" to itself\n  expected \"other\""),
        bad("without_to", "body = \"sheet\"\nedges = [\"first_row\"]\n",
            "8:1: [[tie]] has no \"to\"\n  expected \"to\", a name of letters, digits, _ and -"),
        bad("of_no_vertex", "body = \"sheet\"\nto = \"other\"\n",
            "8:1: the tie selects nothing\n  expected corners, edges, rows, cols, or region_min "
            "and "
            "region_max"),
        bad("of_a_row_outside", "body = \"sheet\"\nto = \"other\"\nrows = [0, 7]\n",
            "11:12: no row 7\n  expected -5 to 4"),
        bad("without_stiffness", "body = \"sheet\"\nto = \"other\"\nstiffness = 0\n",
            "11:13: \"stiffness\" is 0\n  expected a number > 0 (N/m)"),
        bad("negative_force",
            "body = \"sheet\"\nto = \"other\"\nedges = [\"first_row\"]\nbreak_force = -1\n",
            "12:15: \"break_force\" is -1\n  expected a number > 0 (N)"),
        bad("that_breaks_in_equilibrium",
            "body = \"sheet\"\nto = \"other\"\nedges = [\"first_row\"]\nbreak_force = 1\n",
            "12:15: \"break_force\" does not go with time.method = \"static\"\n  expected a method "
            "that follows the motion in time, or a tie that holds",
            {"time.method=\"static\"", "world.gravity=[0,0,0]"}),
        bad("that_nothing_holds", "body = \"sheet\"\nto = \"other\"\nedges = [\"first_row\"]\n",
            "2:8: nothing holds body \"sheet\": under gravity it has no equilibrium (time.method = "
            "\"static\")\n  expected a pin, a tie, a seam, or an obstacle or a pinned body that it "
            "can "
            "rest "
            "on, with contact",
            {"time.method=\"static\""}),
        bad("unknown_key",
            "body = \"sheet\"\nto = \"other\"\nedges = [\"first_row\"]\nstifness = 1\n",
            "12:1: unknown key \"stifness\" in [[tie]]\n  did you mean \"stiffness\"?")),
    bad_case_name);

}  // namespace weft::sim::tie_test
