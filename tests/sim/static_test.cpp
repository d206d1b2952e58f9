// Equilibria, against closed forms and the ends of damped motions.
#include <cmath>
#include <optional>

#include "channel_run.h"
#include "simulated_case.h"

namespace weft::sim::static_test {
namespace {

// A strip of length L hangs from its upper end. The weight below each edge between rows is known,
// and St. Venant-Kirchhoff stretches it by E h (l^2 - 1) / 2 l = force per width.
TEST(Static, StripStretchesUnderItsWeight) {
  const std::string text = R"(
[time]
duration = 1
frames_per_second = 2
method = "static"
position_tolerance = 1e-7
[contact]
enabled = false
[material.cloth]
density = 0.2
membrane_stiffness = 20
poisson_ratio = 0
[[body]]
name = "strip"
rotation_deg = [90, 0, 0]
shape = { type = "rectangle", size = [0.5, 1.0], resolution = [11, 6] }
[[body.pin]]
edges = ["last_row"]
)";
  SimulatedCase sim(text);
  const std::vector<Vec3> half = sim.positions_at(0.5), whole = sim.positions_at(1);
  const auto length = [](double load) {
    double sum = 0;
    for (int edge = 0; edge < 10; ++edge) {
      const double force = load * 0.2 * 9.81 * (edge + 0.5) * 0.1;
      double stretch = 1;
      for (int i = 0; i < 50; ++i) {
        stretch -= (20 * stretch * (stretch * stretch - 1) / 2 - force) /
                   (20 * (3 * stretch * stretch - 1) / 2);
      }
      sum += 0.1 * stretch;
    }
    return sum;
  };
  EXPECT_NEAR(0.5 - half[2].z(), length(0.5), 2e-4);
  EXPECT_NEAR(0.5 - whole[2].z(), length(1), 2e-4);
  EXPECT_GT(length(1), 1.04);
}

// Nearly inextensible triangles can only rotate, which makes every load hard for Newton's method.
// The first frame is before all loads. Energies are those under the present weight.
TEST(Static, RecordsWhatItsPartOfTheLoadsDoes) {
  ChannelRun sheet(R"(
[time]
method = "static"
duration = 1
frames_per_second = 4
[contact]
enabled = false
[output]
channels = ["reactions", "body_energy"]
[material.cloth]
density = 0.2
bending_stiffness = 1e-2
[[body]]
name = "sheet"
position = [0, 0, 1]
shape = { type = "rectangle", size = [0.5, 0.4], resolution = [7, 9] }
[[body.pin]]
edges = ["first_col", "last_col"]
)");
  const double weight = 0.2 * 0.5 * 0.4 * 9.81;
  for (const double load : {0.0, 0.25, 1.0}) {
    sheet.advance_to(load);
    const double carried = sheet.sum_of_reactions("force").z();
    EXPECT_NEAR(std::abs(carried), load * weight, 1e-3 * weight) << load;
    // The sheet is 1 m up, less its sag.
    const double energy = sheet.simulation().energies().gravitational;
    EXPECT_NEAR(energy, load * weight, 0.05 * load * weight) << load;
    EXPECT_NEAR(sheet.record("body_energy/sheet/gravitational")[0], energy, 1e-12 * weight) << load;
  }
}

// A strip hangs high up and is stretched by a third. Under a part of its weight it has more elastic
// energy than that part of its height says, but not more than its whole weight gives.
TEST(Static, StretchesAboveTheOriginWithoutAlarm) {
  ChannelRun strip(R"(
[time]
method = "static"
duration = 1
frames_per_second = 4
[contact]
enabled = false
[material.cloth]
density = 1
membrane_stiffness = 16
poisson_ratio = 0
bending_stiffness = 1e-6
[[body]]
name = "strip"
position = [0, 0, 5]
rotation_deg = [90, 0, 0]
shape = { type = "rectangle", size = [0.2, 1], resolution = [17, 5] }
[[body.pin]]
edges = ["last_row"]
)");
  strip.advance_to(1);
  const std::vector<Vec3> end = strip.simulation().position("strip");
  EXPECT_GT(end.back().z() - end.front().z(), 1.2);
}

TEST(Static, HangsHoweverStiff) {
  for (const char* stiffness : {"1e3", "1e6", "1e9"}) {
    Overrides options = method("static");
    options.push_back(std::string("material.cloth.membrane_stiffness=") + stiffness);
    SimulatedCase sim(hanging_sheet, options);
    const std::vector<double> y = sim.advance_to(0.1);
    EXPECT_LE(sim.integrator().counts().newton_iterations, 600) << stiffness;
    std::vector<double> rate(y.size());
    ASSERT_FALSE(sim.dynamics().rate(0.1, y, rate));
    for (const Vec3& left : StateView::of(rate).velocity) EXPECT_LT(left.norm(), 0.02) << stiffness;
    double lowest = 0;
    for (const Vec3& x : StateView::of(y).position) lowest = std::min(lowest, x.z());
    EXPECT_LT(lowest, -0.9) << stiffness;
  }
}

// One end moves towards the other. The final state equals that of a long damped run.
TEST(Static, EndsWhereADampedRunComesToRest) {
  const std::string text = R"(
[time]
duration = 1
frames_per_second = 4
[contact]
enabled = false
[material.chain]
density = 0.2
membrane_stiffness = 500
poisson_ratio = 0.0
mass_damping = 4.0
[[body]]
name = "strip"
shape = { type = "rectangle", size = [1.25, 0.1], resolution = [2, 14] }
[[body.pin]]
edges = ["first_col"]
[[body.pin]]
edges = ["last_col"]
[body.pin.motion]
keyframes = [{ time = 0.0 }, { time = 1.0, translation = [-0.25, 0, 0] }]
)";
  SimulatedCase still(text, method("static")), swinging(text, {"time.duration=20"});
  const std::vector<Vec3> found = still.positions_at(1), damped = swinging.positions_at(12);
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_LT((found[i] - damped[i]).norm(), 1e-4) << i;
  }
}

// A very stiff sheet, held at two corners, starts flat. Within a loose velocity tolerance, the
// first pseudo-steps change nothing, although all of the weight is still unbalanced.
TEST(Static, IsNotDoneBeforeForcesBalance) {
  SimulatedCase sim(hanging_sheet,
                    method("static", {"time.duration=1", "time.frames_per_second=5",
                                      "time.position_tolerance=1e-2", "time.relative_tolerance=0.1",
                                      "material.cloth.membrane_stiffness=1e9",
                                      "body.sheet.shape.resolution=[13, 13]"}));
  const auto reason = sim.integrator().step();
  if (reason) {
    EXPECT_NE(reason->text.find("body \"sheet\", row"), std::string::npos) << reason->text;
    return;
  }
  std::vector<double> y(sim.integrator().state().begin(), sim.integrator().state().end());
  std::vector<double> rate(y.size());
  ASSERT_FALSE(sim.dynamics().rate(0.2, y, rate));
  for (const Vec3& left : StateView::of(rate).velocity) EXPECT_LT(left.norm(), 0.1);
}

// A sheet on a ball, off its centre, slides: nothing holds it without friction. `static` takes no
// steps of time.minimum_step, so its message does not speak of them.
TEST(Static, SaysThatALoadHasNoEquilibrium) {
  SimulatedCase sim(R"(
[time]
method = "static"
frames_per_second = 4
[material.cloth]
density = 0.2
membrane_stiffness = 500
[[body]]
name = "sheet"
position = [0.2, 0.13, 0.01]
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [5, 5] }
[[obstacle]]
name = "ball"
position = [0, 0, -0.3]
shape = { type = "sphere", radius = 0.3, resolution = [5] }
)");
  std::optional<Failure> failure;
  for (int load = 0; load < 4 && !failure; ++load) failure = sim.integrator().step();
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->kind, Failure::Kind::newton);
  EXPECT_EQ(failure->text.find("no equilibrium is found beyond the load at t = 0 s: the forces are "
                               "farthest from balance at body \"sheet\", row "),
            0U)
      << failure->text;
}

// A ball carries the middle of a sheet, whose corners hang.
TEST(Static, KeepsSurfacesApart) {
  const std::string text = R"(
[time]
duration = 1
frames_per_second = 2
method = "static"
[material.cloth]
density = 0.2
membrane_stiffness = 200
bending_stiffness = 1e-3
[[body]]
name = "sheet"
position = [0, 0, 0.503]
thickness = 1e-3
self_contact = false
shape = { type = "rectangle", size = [0.4, 0.4], resolution = [7, 7] }
[[body.pin]]
rows = [3, 3]
cols = [3, 3]
[[obstacle]]
name = "ball"
thickness = 1e-3
shape = { type = "sphere", radius = 0.5, resolution = [9] }
)";
  SimulatedCase sim(text);
  const std::vector<Vec3> x = sim.positions_at(1);
  EXPECT_EQ(crossings(sim.scene(), x), 0);
  EXPECT_GT(sim.dynamics().contact()->pairs_in_reach(), 0U);
  EXPECT_LT(x[0].z(), 0.45);
}

// A ball that rises into a hanging sheet, within the first second, and stays.
constexpr const char* rising_ball = R"(
[time]
duration = 1
frames_per_second = 4
[contact]
damping_time = 1e-4
[material.cloth]
density = 0.2
membrane_stiffness = 200
bending_stiffness = 1e-3
mass_damping = 6
[[body]]
name = "sheet"
self_contact = false
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [7, 7] }
[[body.pin]]
edges = ["first_row", "last_row"]
[[obstacle]]
name = "ball"
position = [0.02, 0.01, -0.25]
shape = { type = "sphere", radius = 0.1, resolution = [5] }
motion = { keyframes = [{ time = 0 }, { time = 1, translation = [0, 0, 0.2] }] }
)";

// A strip that stands on its pinned edge turns over. On the straight line between both shapes it
// would pass through itself, but not on its path.
TEST(Static, TurnsOverWithoutPassingThroughItself) {
  SimulatedCase sim(R"(
[time]
method = "static"
duration = 1
frames_per_second = 1
[material.cloth]
density = 0.2
membrane_stiffness = 500
bending_stiffness = 1e-4
[[body]]
name = "strip"
rotation_deg = [0, -90, 0]
shape = { type = "rectangle", size = [0.6, 0.2], resolution = [5, 25] }
pin = [{ edges = ["first_col"] }]
)");
  const Vec3 free_corner = sim.positions_at(0)[24], hanging = sim.positions_at(1)[24];
  EXPECT_NEAR(free_corner.z(), 0.3, 1e-9);
  EXPECT_NEAR(hanging.z(), -0.9, 0.005);
}

// In each load, obstacles push from where the load's time puts them.
TEST(Static, FollowsAMovingObstacle) {
  SimulatedCase sim(rising_ball, method("static"));
  double last_top = -1;
  for (int frame = 1; frame <= 4; ++frame) {
    const double time = 0.25 * frame;
    const std::vector<Vec3> x = sim.positions_at(time);
    EXPECT_EQ(sim.integrator().time(), time);
    EXPECT_EQ(crossings(sim.scene(), x), 0) << time;
    double top = -1;
    for (int i = 0; i < 49; ++i) top = std::max(top, x[i].z());
    if (frame > 2) {
      EXPECT_GT(top, last_top) << time;
    }
    last_top = top;
  }
  EXPECT_GT(last_top, 0.05);
  SimulatedCase swinging(rising_ball, {"time.duration=9"});
  const std::vector<Vec3> found = sim.positions_at(1), damped = swinging.positions_at(8);
  for (int i = 0; i < 49; ++i) EXPECT_LT((found[i] - damped[i]).norm(), 1e-3) << i;
}

// Between two frames, a ball passes through the place of the hanging sheet, and back.
TEST(Static, FeelsAnObstacleThatComesAndGoesWithinALoad) {
  SimulatedCase sim(rising_ball,
                    method("static", {"time.frames_per_second=1",
                                      "obstacle.ball.motion.keyframes=[{ time = 0 }, { time = 0.5, "
                                      "translation = [0, 0, 0.2] }, { time = 1 }]"}));
  double top = -1;
  while (sim.integrator().time() < 1) {
    ASSERT_EQ(sim.integrator().step(), std::nullopt);
    const double time = sim.integrator().time();
    const std::vector<Vec3> x =
        sim.positions(time, {sim.integrator().state().begin(), sim.integrator().state().end()});
    ASSERT_EQ(crossings(sim.scene(), x), 0) << time;
    for (int i = 0; i < 49; ++i) top = std::max(top, x[i].z());
  }
  EXPECT_GT(top, 0.05);
}

// Pins are also where the load's time puts them; a load in which they rotate far is divided.
TEST(Static, DividesALoadInWhichPinsTurn) {
  SimulatedCase sim(rising_ball,
                    method("static", {"contact.enabled=false", "time.frames_per_second=1",
                                      "body.sheet.pin.0.motion.centre=[0, 0, 0]",
                                      "body.sheet.pin.0.motion.keyframes=[{ time = 0 }, { time = "
                                      "1, rotation_deg = [0, 0, 180] }]"}));
  const std::vector<Vec3> x = sim.positions_at(1);
  EXPECT_GT(sim.integrator().counts().steps, 20);
  SimulatedCase still(rising_ball, method("static", {"contact.enabled=false"}));
  const std::vector<Vec3> unturned = still.positions_at(1);
  for (int i = 0; i < 49; ++i) {
    const Vec3 turned(-unturned[i].x(), -unturned[i].y(), unturned[i].z());
    EXPECT_LT((x[i] - turned).norm(), 1e-3) << i;
  }
}

// A film resists bending so little that a tiny pressure bends it by more than it shows in seconds.
// A load in its plane is ten thousand times larger, and soon in balance.
TEST(Static, WaitsForAWeakBending) {
  const std::string text = R"(
[time]
method = "static"
duration = 1
frames_per_second = 1
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.film]
model = "shell"
youngs_modulus = 1e5
poisson_ratio = 0
shell_thickness = 1e-3
volume_density = 1000
[[body]]
name = "film"
shape = { type = "rectangle", size = [1, 1], resolution = [6, 12] }
pin = [{ edges = ["first_col"], clamp = true }]
[[load]]
body = "film"
type = "area"
force = [0, 2e-4, 0]
[[load]]
body = "film"
type = "pressure"
pressure = 1e-8
)";
  SimulatedCase relaxed(text), followed(text, {"static.loading=\"in_time\""});
  const std::vector<Vec3> found = relaxed.positions_at(1), exact = followed.positions_at(1);
  EXPECT_GT(exact.back().z(), 1e-4);
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_LT((found[i] - exact[i]).norm(), 1e-5) << i;
}

// A steel plate, 10 mm thick, on supports. The springs of its pins with axes are so stiff that the
// rounding errors of positions are forces a hundred times as large as the residual of a search may
// be. A simply supported square sags by 0.004062 q a^4 / D (Timoshenko and Woinowsky-Krieger,
// Theory of Plates and Shells, table 8).
TEST(Static, SettlesOnStiffSupports) {
  SimulatedCase sim(R"(
[time]
method = "static"
duration = 1
frames_per_second = 2
[contact]
enabled = false
[material.steel]
membrane_stiffness = 2e9
bending_stiffness = 18315
poisson_ratio = 0.3
density = 78.5
[[body]]
name = "plate"
material = "steel"
shape = { type = "rectangle", size = [1, 1], resolution = [17, 17] }
pin = [
  { edges = ["first_row", "last_row", "last_col"], axes = ["z"] },
  { edges = ["first_col"], axes = ["x", "z"] },
  { corners = ["first_first"], axes = ["y"] },
]
)");
  const double full = 0.004062 * 78.5 * 9.81 / 18315;
  for (const double part : {0.5, 1.0})
    EXPECT_NEAR(sim.positions_at(part)[8 * 17 + 8].z(), -part * full, 0.01 * part * full) << part;
}

// The force on a free body is 1e-8 of that on the sheet beside it. No equilibrium balances it.
TEST(Static, FindsThatNothingHoldsALightlyLoadedBody) {
  SimulatedCase sim(R"(
[time]
method = "static"
duration = 1
frames_per_second = 1
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.cloth]
membrane_stiffness = 1e4
bending_stiffness = 1e-3
[[body]]
name = "held"
shape = { type = "rectangle", size = [1, 1], resolution = [9, 9] }
pin = [{ edges = ["first_col", "last_col"] }]
[[body]]
name = "free"
position = [3, 0, 0]
shape = { type = "rectangle", size = [1, 1], resolution = [9, 9] }
[[load]]
body = "held"
type = "area"
force = [0, 0, 100]
[[load]]
body = "free"
type = "area"
force = [0, 0, 1e-6]
)");
  const std::optional<Failure> failure = sim.integrator().step();
  ASSERT_TRUE(failure);
  EXPECT_NE(failure->text.find("no equilibrium is found"), std::string::npos) << failure->text;
}

}  // namespace
}  // namespace weft::sim::static_test
