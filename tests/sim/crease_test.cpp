// Bending that yields: what creases keep, what they dissipate, and when they advance.
#include <cmath>
#include <numbers>

#include "bench/cloth_runs.h"
#include "sim/motion/energy_watch.h"
#include "tests/sim/channel_run.h"
#include "tests/sim/joint_cases.h"

namespace weft::sim::crease_test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double length = 0.2, yield_curvature = 8, hardening = 0.25;  // m, 1/m

// A free strip that starts bent to a curvature of 20 /m: its elastic part springs back.
constexpr const char* bent_strip = R"(
[time]
duration = 0.2
frames_per_second = 50
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.paper]
density = 0.1
membrane_stiffness = 2000
poisson_ratio = 0.3
bending_stiffness = 1e-3
bending_damping = 5e-3
stiffness_damping = 1e-4
mass_damping = 60
yield_curvature = 8
hardening = 0.25
[[body]]
name = "strip"
start = { bend_radius = 0.05 }
shape = { type = "rectangle", size = [0.2, 0.04], resolution = [5, 21] }
)";

// A strip that is clamped at one end falls under its weight and yields at the clamp.
constexpr const char* falling_strip = R"(
[time]
method = "implicit_midpoint"
step = 5e-4
duration = 0.12
position_tolerance = 1e-8
[contact]
enabled = false
[material.paper]
density = 0.1
membrane_stiffness = 2000
bending_stiffness = 1e-3
yield_curvature = 4
hardening = 0.1
[[body]]
name = "strip"
shape = { type = "rectangle", size = [0.2, 0.03], resolution = [3, 14] }
[[body.pin]]
edges = ["first_col"]
clamp = true
)";

// A strip whose clamped ends turn towards each other by 150 degrees, back to 45, and let go. The
// ends move as those of an arc of the strip's length. At 45 degrees little moment is left: a strip
// that is let go with more springs back in waves, which fold it further. With a Poisson's ratio of
// 0 it bends to a cylinder, to which the formula belongs.
constexpr const char* folded_strip = R"(
[time]
method = "euler"
step = 2e-3
duration = 3
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.paper]
density = 0.1
membrane_stiffness = 2000
poisson_ratio = 0
bending_stiffness = 1e-3
bending_damping = 5e-3
stiffness_damping = 1e-3
mass_damping = 20
yield_curvature = 8
hardening = 0.25
[output]
channels = ["bending_curvature", "bending_moment", "crease_curvature", "body_energy"]
[[body]]
name = "strip"
shape = { type = "rectangle", size = [0.2, 0.04], resolution = [4, 25] }
[[body.pin]]
edges = ["first_col"]
clamp = true
[[body.pin]]
edges = ["last_col"]
clamp = true
release_time = 1.9
motion = { centre = [0.1, 0, 0], keyframes = [
  { time = 0.1, translation = [-0.0022768, 0, 0.0260308], rotation_deg = [0, -15, 0] },
  { time = 0.2, translation = [-0.0090141, 0, 0.0511745], rotation_deg = [0, -30, 0] },
  { time = 0.3, translation = [-0.0199367, 0, 0.0745846], rotation_deg = [0, -45, 0] },
  { time = 0.4, translation = [-0.0346013, 0, 0.0954930], rotation_deg = [0, -60, 0] },
  { time = 0.5, translation = [-0.0524174, 0, 0.1132441], rotation_deg = [0, -75, 0] },
  { time = 0.6, translation = [-0.0726760, 0, 0.1273240], rotation_deg = [0, -90, 0] },
  { time = 0.7, translation = [-0.0945839, 0, 0.1373810], rotation_deg = [0, -105, 0] },
  { time = 0.8, translation = [-0.1173007, 0, 0.1432394], rotation_deg = [0, -120, 0] },
  { time = 0.9, translation = [-0.1399789, 0, 0.1449037], rotation_deg = [0, -135, 0] },
  { time = 1.0, translation = [-0.1618028, 0, 0.1425538], rotation_deg = [0, -150, 0] },
  { time = 1.1, translation = [-0.1399789, 0, 0.1449037], rotation_deg = [0, -135, 0] },
  { time = 1.2, translation = [-0.1173007, 0, 0.1432394], rotation_deg = [0, -120, 0] },
  { time = 1.3, translation = [-0.0945839, 0, 0.1373810], rotation_deg = [0, -105, 0] },
  { time = 1.4, translation = [-0.0726760, 0, 0.1273240], rotation_deg = [0, -90, 0] },
  { time = 1.5, translation = [-0.0524174, 0, 0.1132441], rotation_deg = [0, -75, 0] },
  { time = 1.6, translation = [-0.0346013, 0, 0.0954930], rotation_deg = [0, -60, 0] },
  { time = 1.7, translation = [-0.0199367, 0, 0.0745846], rotation_deg = [0, -45, 0] }] }
)";

double turning(const Simulation& simulation) {
  return bench::turning_angle(simulation.scene(), simulation.position("strip"));
}

}  // namespace

// Remaining curvature after slow unloading: (1 - hardening) (kappa - kappa_y), whatever the
// direction of the curve in the image and the method.
TEST(Crease, KeepsTheAngleOfTheFormula) {
  const double expected = (1 - hardening) * (20 - yield_curvature) * length;
  for (const Overrides& overrides :
       std::vector<Overrides>{{"time.method=\"cvode\""},
                              {"time.method=\"arkode\""},
                              {"time.method=\"euler\"", "time.step=2e-3"},
                              {"time.method=\"euler\"", "time.step=2e-3", "time.newton=1"},
                              {"time.method=\"implicit_midpoint\"", "time.step=1e-3"},
                              {"time.method=\"static\""},
                              {"time.method=\"cvode\"", "material.paper.poisson_ratio=0"}}) {
    SCOPED_TRACE(overrides.front() + overrides.back());
    Simulation simulation =
        make_simulation(read_case(WEFT_CASES_DIR "/benchmarks/crease.toml", overrides));
    EXPECT_NEAR(turning(simulation), 4, 0.01);
    advance_to(simulation, 0.8);
    EXPECT_NEAR(turning(simulation), expected, 0.02 * expected);
  }
}

// A free body has no stiffness against motions as a whole. Rounding must not decide whether the
// search for its equilibrium ends: in each of these strips it differs.
TEST(Crease, ElasticStripsSpringBack) {
  for (const char* stiffness :
       {"2000", "2000.000000002", "2000.000000004", "2000.000000006", "2000.000000008"}) {
    SCOPED_TRACE(stiffness);
    Simulation simulation =
        simulation_of(bent_strip, {"material.paper.yield_curvature=21", "time.method=\"static\"",
                                   std::string("material.paper.membrane_stiffness=") + stiffness});
    advance_to(simulation, 0.2);
    EXPECT_LT(turning(simulation), 1e-3);
    EXPECT_LT(simulation.counts().newton_iterations, 125);
  }
}

// A yield curvature that nothing reaches changes no bit.
TEST(Crease, ThatNothingReachesChangesNoBit) {
  std::string elastic = falling_strip;
  const std::string keys = "yield_curvature = 4\nhardening = 0.1\n";
  elastic.erase(elastic.find(keys), keys.size());
  Simulation one = simulation_of(elastic);
  Simulation other = simulation_of(falling_strip, {"material.paper.yield_curvature=1e6"});
  for (int i = 0; i < 40; ++i) {
    ASSERT_FALSE(one.step());
    ASSERT_FALSE(other.step());
    ASSERT_TRUE(std::ranges::equal(one.state(), other.state())) << i;
  }
  EXPECT_FALSE(one.energies().dissipated);
  EXPECT_EQ(other.energies().dissipated, 0.0);
}

TEST(Crease, ForcesAreSlopesOfThePotential) {
  std::string text = bent_strip;
  text.replace(text.find("mass_damping = 60\n"), 18, "");
  expect_consistent_forces(text, 0);
  const std::string clamped = text + "[[body.pin]]\nedges = [\"first_col\"]\nclamp = true\n";
  expect_consistent_forces(clamped, 0);
}

// Without damping, motion, strain and what creases have dissipated keep their sum; the energy watch
// knows the loss.
TEST(Crease, DissipateWhatTheMotionLoses) {
  Simulation simulation = simulation_of(falling_strip);
  const double start = simulation.energies().total();
  double before = 0, most = 0;
  while (simulation.time() < 0.12) {
    if (const auto failure = simulation.step()) FAIL() << failure->text;
    const Energies& energies = simulation.energies();
    ASSERT_TRUE(energies.dissipated);
    EXPECT_GE(*energies.dissipated, before - 1e-12);
    before = *energies.dissipated;
    most = std::max(most, energies.kinetic);
    EXPECT_NEAR(energies.total() + before, start, 0.01 * most + 1e-9) << simulation.time();
  }
  EXPECT_GT(before, 0.1 * most);
}

// An energy watch that did not know the loss would let as much again be gained.
TEST(Crease, TheEnergyWatchSubtractsTheLoss) {
  const auto scene = build_scene(parse_case(falling_strip, "test.toml"));
  Statistics statistics;
  Dynamics dynamics(*scene, statistics);
  const std::vector<double> y = dynamics.initial_state();
  EnergyWatch watch(dynamics, y);
  Energies now = dynamics.energies(0, y);
  now.kinetic += 1e-3;
  now.gravitational -= 1e-3;
  EXPECT_FALSE(watch.check(0.1, y, now));
  now.dissipated = 0.9e-3;
  const auto failure = watch.check(0.1, y, now);
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->kind, Failure::Kind::energy);
}

// Folded between clamps, unfolded and let go: every place keeps what the formula says of the
// largest curvature it had.
TEST(Crease, KeepsWhatTheFoldHad) {
  ChannelRun run(folded_strip);
  const auto curvature = [&] {
    std::vector<double> values = run.field("strip", "bending_curvature_major");
    const std::vector<double> minor = run.field("strip", "bending_curvature_minor");
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = std::max(std::abs(values[i]), std::abs(minor[i]));
    return values;
  };
  std::vector<double> folded(4 * 25, 0.0);
  while (run.simulation().time() < 1.1 - 1e-9) {
    run.advance_to(run.simulation().time() + 0.01);
    const std::vector<double> now = curvature();
    for (std::size_t i = 0; i < now.size(); ++i) folded[i] = std::max(folded[i], now[i]);
  }
  const double dissipated = *run.simulation().energies().dissipated;
  run.advance_to(3);
  const std::vector<double> left = curvature();
  const std::vector<double> major = run.field("strip", "crease_curvature_major");
  const std::vector<double> minor = run.field("strip", "crease_curvature_minor");
  const std::vector<double> moments = run.field("strip", "bending_moment_major");
  const int cols = 25;
  for (int c = 4; c + 4 < cols; ++c) {
    const int i = 2 * cols + c;
    const double expected = (1 - hardening) * (folded[i] - yield_curvature);
    ASSERT_GT(expected, 1);
    EXPECT_NEAR(left[i], expected, 0.02 * expected) << "column " << c;
    EXPECT_NEAR(std::max(std::abs(major[i]), std::abs(minor[i])), expected, 0.02 * expected);
    EXPECT_LT(std::abs(moments[i]), 0.02 * 1e-3 * yield_curvature);
  }
  // Elastic unloading dissipates nothing.
  EXPECT_NEAR(*run.simulation().energies().dissipated, dissipated, 1e-3 * dissipated);
}

// Methods agree on the way of a strip that yields, as far as their tolerances go.
TEST(Crease, MethodsAgree) {
  std::vector<std::vector<Vec3>> places;
  for (const Overrides& overrides :
       std::vector<Overrides>{{"time.step=2.5e-4"},
                              {"time.method=\"cvode\"", "time.position_tolerance=1e-7"},
                              {"time.method=\"arkode\"", "time.position_tolerance=1e-7"},
                              {"time.method=\"verlet\""}}) {
    std::string text = falling_strip;
    if (overrides.size() > 1 || overrides[0].find("verlet") != std::string::npos)
      text.erase(text.find("step = 5e-4\n"), 12);
    Simulation simulation = simulation_of(text, overrides);
    advance_to(simulation, 0.1);
    places.push_back(simulation.position("strip"));
  }
  for (std::size_t m = 1; m < places.size(); ++m) {
    for (std::size_t i = 0; i < places[0].size(); ++i)
      EXPECT_LT((places[m][i] - places[0][i]).norm(), 1e-4) << m << ' ' << i;
  }
}

// A saved run goes on with the same bits, before and after its pins change. Multigrid's coarse
// matrices are older than the save: they are assembled again, with the creases of their time.
TEST(Crease, IsSavedWithTheState) {
  const Overrides overrides{"time.preconditioner=multigrid"};
  for (const double time : {0.8, 1.95}) {
    SCOPED_TRACE(time);
    Simulation whole = simulation_of(folded_strip, overrides);
    Simulation begun = simulation_of(folded_strip, overrides);
    while (whole.time() < time) ASSERT_FALSE(whole.step());
    EXPECT_GT(whole.energies().dissipated, 0);
    begun.restore(whole.save());
    while (whole.time() < time + 0.1) ASSERT_FALSE(whole.step());
    while (begun.time() < time + 0.1) ASSERT_FALSE(begun.step());
    EXPECT_TRUE(std::ranges::equal(whole.state(), begun.state()));
    EXPECT_EQ(whole.energies().dissipated, begun.energies().dissipated);
  }
}

TEST(Crease, DoesNotDependOnThreads) {
  std::vector<std::vector<double>> ends;
  std::vector<std::optional<double>> losses;
  for (const char* threads : {"compute.threads=1", "compute.threads=3"}) {
    Simulation simulation =
        simulation_of(bent_strip, {"time.method=\"euler\"", "time.step=2e-3", threads,
                                   "body.strip.shape.resolution=[33,129]"});
    for (int i = 0; i < 3; ++i) ASSERT_FALSE(simulation.step());
    ends.emplace_back(simulation.state().begin(), simulation.state().end());
    losses.push_back(simulation.energies().dissipated);
  }
  EXPECT_EQ(ends[0], ends[1]);
  EXPECT_EQ(losses[0], losses[1]);
}

// The history follows accepted steps: a time within the last one sees the creases at its start, and
// a step that is taken back leaves none.
TEST(CreaseHistory, FollowsAcceptedSteps) {
  const auto scene = build_scene(parse_case(bent_strip, "test.toml"));
  CreaseHistory history(*scene);
  ASSERT_EQ(history.of_body(0).size(), 2 * 4 * 20);
  const auto accept = [&](double time, double curvature) {
    history.begin_accept(time);
    history.advanced(0)[3].curvature = curvature;
    history.end_accept();
  };
  const auto at = [&](double time) {
    history.choose(time);
    return history.of_body(0)[3].curvature;
  };
  accept(0.1, 1);
  accept(0.2, 2);
  EXPECT_EQ(at(0.15), 1);
  EXPECT_EQ(at(0.2), 2);
  EXPECT_EQ(at(0.3), 2);
  EXPECT_FALSE(history.take_back(0.2));
  EXPECT_EQ(at(0.2), 2);
  const std::int64_t version = history.version();
  EXPECT_TRUE(history.take_back(0.15));  // later than the start: the part up to there is taken anew
  EXPECT_EQ(at(0.15), 1);
  EXPECT_GT(history.version(), version);
  accept(0.15, 1.5);
  EXPECT_EQ(at(0.12), 1);
  EXPECT_EQ(at(0.15), 1.5);
  StateArchive written;
  history.transfer(written);
  CreaseHistory other(*scene);
  const std::string bytes = written.bytes();
  StateArchive read(bytes);
  other.transfer(read);
  other.choose(0.12);
  EXPECT_EQ(other.of_body(0)[3].curvature, 1);
  other.choose(0.2);
  EXPECT_EQ(other.of_body(0)[3].curvature, 1.5);
  // The start of the step is known, too: taken back to it, nothing is left to take anew.
  EXPECT_FALSE(other.take_back(0.1));
}

// Bodies that sleep keep their creases, and a step that is taken back to wake one advances none.
TEST(Crease, SleepsAndWakes) {
  const std::string two = std::string(bent_strip) + R"(
[[body]]
name = "other"
material = "elastic"
position = [0, 0, 1]
velocity = [0.3, 0, 0]
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [3, 3] }
[material.elastic]
)";
  const Overrides overrides{"time.method=\"euler\"", "time.step=5e-3", "time.duration=3",
                            "body.strip.material=\"paper\""};
  Simulation sleepy = simulation_of(two, overrides);
  Overrides awake_too = overrides;
  awake_too.emplace_back("time.sleep=false");
  Simulation awake = simulation_of(two, awake_too);
  advance_to(sleepy, 3);
  advance_to(awake, 3);
  EXPECT_NEAR(turning(sleepy), turning(awake), 1e-5);
  EXPECT_NEAR(*sleepy.energies().dissipated, *awake.energies().dissipated, 1e-9);
  EXPECT_EQ(sleepy.summary_of(3, sleepy.state()).sleeping_bodies, 1);
}

}  // namespace weft::sim::crease_test
