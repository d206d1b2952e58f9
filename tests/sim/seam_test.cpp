// Seams against the uncut sheet, conservation laws and contact.
#include <cmath>
#include <numbers>
#include <numeric>

#include "sim/motion/tolerances.h"
#include "sim/run/recorded_run.h"
#include "sim/trajectory/trajectory.h"
#include "sim/view/trajectory_info.h"
#include "tests/sim/joint_cases.h"
#include "tests/temporary_folder.h"

namespace weft::sim::seam_test {
namespace {

// A sheet that hangs by two corners, and the same one cut in two along its middle column and sewn.
// "[17,17]" and "[17,9]" stand for the resolutions.
constexpr const char* setting = R"(
[time]
duration = 0.2
frames_per_second = 50
[contact]
enabled = false
[material.cloth]
density = 0.2
membrane_stiffness = 500
bending_stiffness = 1e-3
stiffness_damping = 1e-3
bending_damping = 1e-3
)";
const std::string whole_sheet = std::string(setting) + R"(
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [17, 17] }
[[body.pin]]
corners = ["last_first", "last_last"]
)";
const std::string cut_sheet = std::string(setting) + R"(
[[body]]
name = "left"
position = [-0.25, 0, 0]
shape = { type = "rectangle", size = [0.5, 1], resolution = [17, 9] }
[[body.pin]]
corners = ["last_first"]
[[body]]
name = "right"
position = [0.25, 0, 0]
shape = { type = "rectangle", size = [0.5, 1], resolution = [17, 9] }
[[body.pin]]
corners = ["last_last"]
[[seam]]
body = "left"
edge = "last_col"
to = "right"
to_edge = "first_col"
)";

// The largest distance (m) of the halves from the sheet.
double distance_to_whole(const Simulation& whole, const Simulation& cut) {
  const std::vector<Vec3> sheet = whole.position("sheet");
  double largest = 0;
  for (const auto& [name, offset] : {std::pair("left", 0), std::pair("right", 8)}) {
    const std::vector<Vec3> half = cut.position(name);
    for (int r = 0; r < 17; ++r) {
      for (int c = 0; c < 9; ++c)
        largest = std::max(largest, (half[9 * r + c] - sheet[17 * r + c + offset]).norm());
    }
  }
  return largest;
}

// The largest opening of a seam between its stitches, m.
double opening(const Simulation& simulation) {
  const Scene& scene = simulation.scene();
  double largest = 0;
  for (const Seam& seam : scene.seams) {
    const std::vector<Vec3> one = simulation.position(scene.source.body[seam.body].name);
    const std::vector<Vec3> other = simulation.position(scene.source.body[seam.to].name);
    for (const Stitch& stitch : seam.stitches) {
      const Vec3 point =
          stitch.weight * other[stitch.nodes[0]] + (1 - stitch.weight) * other[stitch.nodes[1]];
      largest = std::max(largest, (one[stitch.vertex] - point).norm());
    }
  }
  return largest;
}

// Two pieces of different cloth and resolution in space, sewn along curved edges, that move apart
// and spin.
constexpr const char* thrown_pieces = R"(
[time]
duration = 0.1
frames_per_second = 50
method = "verlet"
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.stiff]
density = 0.3
membrane_stiffness = 2000
bending_stiffness = 2e-3
[material.soft]
density = 0.1
membrane_stiffness = 300
bending_stiffness = 1e-4
[[body]]
name = "one"
material = "stiff"
position = [-0.15, 0, 0]
velocity = [0.2, 0, 0.5]
angular_velocity_deg = [40, 20, 90]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [7, 5] }
[[body]]
name = "other"
material = "soft"
position = [0.2, 0, 0]
shape = { type = "rectangle", size = [0.4, 0.3], resolution = [10, 6] }
[[seam]]
body = "one"
edge = "last_col"
to = "other"
to_edge = "first_col"
angle_deg = 30
)";

Vec3 momentum(const Simulation& simulation) {
  const StateView state = StateView::of(simulation.state());
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < state.velocity.size(); ++i)
    sum += simulation.scene().mass[i] * state.velocity[i];
  return sum;
}
Vec3 angular_momentum(const Simulation& simulation) {
  const StateView state = StateView::of(simulation.state());
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < state.velocity.size(); ++i)
    sum += simulation.scene().mass[i] * state.position[i].cross(state.velocity[i]);
  return sum;
}

// Two sheets 2 cm apart whose seam closes in a fifth of a second.
constexpr const char* closing = R"(
[time]
duration = 0.4
frames_per_second = 50
[world]
gravity = [0, 0, 0]
[contact]
range = 2e-3
[material.cloth]
density = 0.2
membrane_stiffness = 200
bending_stiffness = 1e-4
stiffness_damping = 2e-3
mass_damping = 5
[[body]]
name = "left"
position = [-0.16, 0, 0]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [7, 7] }
[[body]]
name = "right"
position = [0.16, 0, 0]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [10, 7] }
[[seam]]
body = "left"
edge = "last_col"
to = "right"
to_edge = "first_col"
closing_time = 0.2
)";

// Four pieces that meet in one point, with contact, which drape over a ball.
constexpr const char* quilt = R"(
[time]
duration = 0.25
frames_per_second = 20
[contact]
range = 2e-3
[material.a]
density = 0.2
membrane_stiffness = 300
bending_stiffness = 2e-4
stiffness_damping = 1e-3
[material.b]
density = 0.4
membrane_stiffness = 800
bending_stiffness = 5e-4
stiffness_damping = 1e-3
[[body]]
name = "p00"
material = "a"
position = [-0.1, -0.1, 0]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [7, 7] }
[[body]]
name = "p01"
material = "b"
position = [0.1, -0.1, 0]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [7, 7] }
[[body]]
name = "p10"
material = "b"
position = [-0.1, 0.1, 0]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [7, 9] }
[[body]]
name = "p11"
material = "a"
position = [0.1, 0.1, 0]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [7, 9] }
[[obstacle]]
name = "ball"
position = [0.01, 0.02, -0.105]
shape = { type = "sphere", radius = 0.1, resolution = [9] }
[[seam]]
body = "p00"
edge = "last_col"
to = "p01"
to_edge = "first_col"
[[seam]]
body = "p10"
edge = "last_col"
to = "p11"
to_edge = "first_col"
[[seam]]
body = "p00"
edge = "last_row"
to = "p10"
to_edge = "first_row"
[[seam]]
body = "p01"
edge = "last_row"
to = "p11"
to_edge = "first_row"
)";

// A strip rolled up until its ends meet, and sewn to a tube.
constexpr const char* tube = R"(
[time]
duration = 0.1
method = "static"
position_tolerance = 5e-6
[world]
gravity = [0, 0, 0]
[contact]
range = 1e-3
[material.cloth]
membrane_stiffness = 1000
bending_stiffness = 1e-3
poisson_ratio = 0
[[body]]
name = "strip"
thickness = 5e-4
start = { bend_radius = 0.05 }
shape = { type = "rectangle", size = [0.3141592653589793, 0.05], resolution = [4, 33] }
[[seam]]
body = "strip"
edge = "first_col"
to = "strip"
to_edge = "last_col"
)";

}  // namespace

TEST(Seam, ForcesAreSlopesOfTheEnergy) {
  expect_consistent_forces(thrown_pieces, 0);
  std::string damped = thrown_pieces;
  damped.replace(damped.find("membrane_stiffness = 2000"), 0, "bending_damping = 1e-3\n");
  expect_consistent_forces(damped, 0);
  // While it closes.
  std::string text = closing;
  text.replace(text.find("range = 2e-3"), 12, "enabled = false");
  text.replace(text.find("mass_damping = 5\n"), 17, "");
  expect_consistent_forces(text, 0.1);
  // A clamp that meets the seam, and a seam to a body that pins hold.
  const std::string pin = "[[body.pin]]\n", seam = "[[seam]]\n";
  std::string clamped = thrown_pieces, held = thrown_pieces;
  clamped.insert(clamped.find(seam), pin + "edges = [\"first_row\"]\nclamp = true\n");
  expect_consistent_forces(clamped, 0);
  held.insert(held.find(seam), pin + "rows = [0, -1]\ncols = [0, -1]\n");
  expect_consistent_forces(held, 0);
}

TEST(Seam, ConservesMomentumAndAngularMomentum) {
  Simulation simulation = simulation_of(thrown_pieces);
  const Vec3 start = momentum(simulation), spin = angular_momentum(simulation);
  while (simulation.time() < 0.1) {
    if (const auto failure = simulation.step()) FAIL() << failure->text;
  }
  EXPECT_LT((momentum(simulation) - start).norm(), 1e-12);
  EXPECT_LT((angular_momentum(simulation) - spin).norm(), 1e-12);
  EXPECT_LT(opening(simulation), 2e-4);
}

// A sheet that is cut and sewn again moves as the uncut one does: within a ten thousandth of its
// size. At a tolerance of 1 um, the errors of cvode alone are as large; at 0.1 um a third of
// them is left.
TEST(Seam, BehavesAsTheUncutSheet) {
  for (const Overrides& overrides :
       std::vector<Overrides>{{"time.position_tolerance=1e-7"},
                              {"time.method=\"euler\"", "time.step=0.01"},
                              {"time.method=\"static\"", "time.frames_per_second=25"}}) {
    SCOPED_TRACE(overrides.front());
    Simulation whole = simulation_of(whole_sheet, overrides);
    Simulation cut = simulation_of(cut_sheet, overrides);
    for (const double time : {0.1, 0.2}) {
      advance_to(whole, time);
      advance_to(cut, time);
      EXPECT_LT(distance_to_whole(whole, cut), 1e-4) << time;
      EXPECT_LT(opening(cut), 2e-5) << time;
    }
  }
}

// Bending goes on across the seam: a cantilever that is cut half way sags as the whole one does.
TEST(Seam, BendsAsTheUncutStrip) {
  const std::string whole = std::string(setting) + R"(
[[body]]
name = "strip"
shape = { type = "rectangle", size = [0.2, 0.05], resolution = [5, 17] }
[[body.pin]]
edges = ["first_col"]
clamp = true
)";
  const std::string cut = std::string(setting) + R"(
[[body]]
name = "near"
position = [-0.05, 0, 0]
shape = { type = "rectangle", size = [0.1, 0.05], resolution = [5, 9] }
[[body.pin]]
edges = ["first_col"]
clamp = true
[[body]]
name = "far"
position = [0.05, 0, 0]
shape = { type = "rectangle", size = [0.1, 0.05], resolution = [5, 9] }
[[seam]]
body = "far"
edge = "first_col"
to = "near"
to_edge = "last_col"
)";
  const Overrides still{"time.method=\"static\"", "time.frames_per_second=25"};
  const auto tip = [&](const std::string& text, const char* body, const Overrides& more = {}) {
    Overrides all = still;
    all.insert(all.end(), more.begin(), more.end());
    Simulation simulation = simulation_of(text, all);
    advance_to(simulation, 0.2);
    return simulation.position(body).back();
  };
  const Vec3 expected = tip(whole, "strip");
  ASSERT_LT(expected.z(), -0.03);
  EXPECT_LT((tip(cut, "far") - expected).norm(), 1e-3 * std::abs(expected.z()));
  // With a hinge the far half hangs down. Stiffer strips than these show it: they hardly sag by
  // themselves.
  const Overrides stiff{"material.cloth.bending_stiffness=1e-2"};
  const double stiff_sag = tip(whole, "strip", stiff).z();
  EXPECT_LT(std::abs((tip(cut, "far", stiff).z() - stiff_sag) / stiff_sag), 1e-3);
  EXPECT_LT(tip(cut, "far", {stiff[0], "seam.0.bending=\"hinged\""}).z(), 1.5 * stiff_sag);
  // A far half of another resolution is as good as its mesh.
  EXPECT_LT((tip(cut, "far", {"body.far.shape.resolution=[9,17]"}) - expected).norm(),
            0.02 * std::abs(expected.z()));
}

// Woven cloth bends across a seam by its stiffness there, linear or by curvature.
TEST(Seam, BendsAsTheUncutWovenStrip) {
  std::string woven = setting;
  const std::string stiffness = "bending_stiffness = 1e-3\n";
  woven.erase(woven.find(stiffness), stiffness.size());
  const std::string whole = R"(
[[body]]
name = "strip"
shape = { type = "rectangle", size = [0.2, 0.05], resolution = [5, 17] }
[[body.pin]]
edges = ["first_col"]
clamp = true
)";
  const std::string cut = R"(
[[body]]
name = "near"
position = [-0.05, 0, 0]
shape = { type = "rectangle", size = [0.1, 0.05], resolution = [5, 9] }
[[body.pin]]
edges = ["first_col"]
clamp = true
[[body]]
name = "far"
position = [0.05, 0, 0]
shape = { type = "rectangle", size = [0.1, 0.05], resolution = [5, 9] }
[[seam]]
body = "far"
edge = "first_col"
to = "near"
to_edge = "last_col"
)";
  for (const char* bending :
       {"warp = [1e-3]\nbias = [5e-4]\nweft = [2e-4]\n",
        "warp = [1e-3, 5e-4]\nbias = [5e-4, 3e-4]\nweft = [2e-4, 2e-4]\ncurvatures = [0, 5]\n"}) {
    SCOPED_TRACE(bending);
    const std::string cloth = woven + "[material.cloth.orthotropic_bending]\n" + bending;
    const auto tip = [&](const std::string& text, const char* body) {
      Simulation simulation =
          simulation_of(cloth + text, {"time.method=\"static\"", "time.frames_per_second=25"});
      advance_to(simulation, 0.2);
      return simulation.position(body).back();
    };
    const Vec3 expected = tip(whole, "strip");
    ASSERT_LT(expected.z(), -0.03);
    EXPECT_LT((tip(cut, "far") - expected).norm(), 1e-3 * std::abs(expected.z()));
    std::string free = cloth + cut;
    free.replace(free.find("[contact]"), 0, "[world]\ngravity = [0, 0, 0]\n");
    expect_consistent_forces(free, 0);
  }
}

// The stiffness across a seam is that of the direction: here along the warp of one side, the weft
// of the other.
TEST(Seam, TurnsByTheStiffnessOfTheDirection) {
  const std::string text = std::string(setting) + R"(
[material.woven]
density = 0.2
[material.woven.orthotropic_bending]
warp = [3e-3]
bias = [1e-3]
weft = [1e-3]
[[body]]
name = "near"
material = "woven"
position = [-0.05, 0, 0]
shape = { type = "rectangle", size = [0.1, 0.05], resolution = [5, 9] }
[[body]]
name = "far"
material = "woven"
warp_angle_deg = 90
position = [0.05, 0, 0]
shape = { type = "rectangle", size = [0.1, 0.05], resolution = [5, 9] }
[[seam]]
body = "near"
edge = "last_col"
to = "far"
to_edge = "first_col"
)";
  const auto scene = build_scene(parse_case(text, "test.toml"));
  ASSERT_EQ(scene->seams.at(0).folds.size(), 8);
  for (const SeamFold& fold : scene->seams[0].folds)
    EXPECT_NEAR(fold.share, fold.body == 0 ? 0.5 : 1.5, 1e-12);
}

// Beside a far softer piece the seam turns with the softer side; the stiff one stays as it is
// alone.
TEST(Seam, TurnsWithTheSofterSide) {
  const std::string text = std::string(setting) + R"(
[material.rag]
density = 0.2
membrane_stiffness = 500
bending_stiffness = 1e-6
[[body]]
name = "near"
material = "cloth"
position = [-0.05, 0, 0]
shape = { type = "rectangle", size = [0.1, 0.05], resolution = [5, 9] }
[[body]]
name = "far"
material = "rag"
position = [0.05, 0, 0]
shape = { type = "rectangle", size = [0.1, 0.05], resolution = [5, 9] }
[[seam]]
body = "near"
edge = "last_col"
to = "far"
to_edge = "first_col"
)";
  const auto scene = build_scene(parse_case(text, "test.toml"));
  ASSERT_EQ(scene->seams.at(0).folds.size(), 8);
  for (const SeamFold& fold : scene->seams[0].folds)
    EXPECT_NEAR(fold.share, fold.body == 0 ? 2 / 1001.0 : 2000 / 1001.0, 1e-12);
}

TEST(Seam, StitchesByFractionsOfTheEdges) {
  const auto scene = build_scene(parse_case(thrown_pieces, "test.toml"));
  const Seam& seam = scene->seams.at(0);
  EXPECT_EQ(scene->source.body[seam.body].name, "other");  // the finer side has the stitches
  ASSERT_EQ(seam.stitches.size(), 10);
  double length = 0;
  for (const Stitch& stitch : seam.stitches) {
    length += stitch.length;
    EXPECT_LT(stitch.gap, 1e-12);
  }
  EXPECT_NEAR(length, 0.3, 1e-12);
  EXPECT_EQ(seam.stitches[3].nodes[0], seam.stitches[3].nodes[1]);  // a third of 9 and of 6
  EXPECT_NEAR(seam.stitches[1].weight, 1.0 / 3, 1e-12);
  // Sewn from the other end, or turned around, it finds the same points.
  const auto turned =
      build_scene(parse_case(thrown_pieces, "test.toml",
                             {"body.other.rotation_deg=[0,0,180]", "seam.0.to_edge=\"last_col\""}));
  for (const Stitch& stitch : turned->seams.at(0).stitches) EXPECT_LT(stitch.gap, 1e-12);
}

TEST(Seam, ClosesInItsTime) {
  for (const Overrides& overrides :
       std::vector<Overrides>{{"time.method=\"cvode\""},
                              {"time.method=\"arkode\""},
                              {"time.method=\"euler\"", "time.step=5e-3"}}) {
    SCOPED_TRACE(overrides.front());
    Simulation simulation = simulation_of(closing, overrides);
    EXPECT_NEAR(opening(simulation), 0.02, 1e-9);
    while (simulation.time() < 0.4) {
      if (const auto failure = simulation.step()) FAIL() << failure->text;
    }
    EXPECT_LT(opening(simulation), 1e-4);
    // Seams conserve momentum, and there is none at the start. Methods solve for velocities within
    // their tolerance; a piece that closes has 25 times the momentum that this allows.
    const Scene& scene = simulation.scene();
    const double mass = std::accumulate(scene.mass.begin(), scene.mass.end(), 0.0);
    EXPECT_LT(momentum(simulation).norm(), mass * velocity_tolerance(scene.source.time));
    // Sewn together, nothing pushes the edges apart.
    EXPECT_EQ(simulation.contact_pairs(), 0);
  }
}

TEST(Seam, ContactDoesNotPushSewnEdgesApart) {
  Simulation simulation =
      simulation_of(quilt, {"world.gravity=[0,0,0]", "obstacle.ball.position=[0,0,-1]"});
  const std::vector<double> start(simulation.state().begin(), simulation.state().end());
  advance_to(simulation, 0.25);
  // Stitches between vertices of unequal borders start apart by a rounding error. A push of contact
  // would open them by the order of its range, 2 mm.
  EXPECT_LT(position_difference(start, {simulation.state().begin(), simulation.state().end()}),
            1e-8);
  EXPECT_FALSE(simulation.smallest_gap());
}

TEST(Seam, DrapesWithoutCrossings) {
  const TemporaryFolder folder;
  const std::string path = folder.path("quilt.h5");
  const auto scene = build_scene(parse_case(quilt, "test.toml"));
  RunOptions options;
  options.trajectory = path;
  const RunReport report = run_simulation(*scene, options);
  ASSERT_EQ(report.status, RunReport::Status::done) << report.reason;
  EXPECT_GT(report.smallest_gap.value_or(0), 0);
  for (const FrameCrossings& frame : count_crossings(path)) EXPECT_EQ(frame.count, 0);
  const TrajectoryReader reader(path);
  EXPECT_GT(reader.sewn().size(), 4 * 6);
}

// A strip that is sewn to a tube stays a tube, round but for the seam, which is straight at rest.
TEST(Seam, MakesATubeOfAStrip) {
  Simulation simulation = simulation_of(tube);
  EXPECT_LT(opening(simulation), 1e-4);
  advance_to(simulation, 0.1);
  EXPECT_LT(opening(simulation), 1e-4);
  const std::vector<Vec3> x = simulation.position("strip");
  const Vec3 middle = mean_of(x);
  for (const Vec3& each : x) {
    const Vec3 arm(each.x() - middle.x(), 0, each.z() - middle.z());
    EXPECT_NEAR(arm.norm(), 0.05, 0.003);
  }
}

TEST(Seam, SleepsWithWhatItIsSewnTo) {
  const std::string text = std::string(setting) + R"(
[material.still]
density = 0.2
mass_damping = 10
[[body]]
name = "held"
material = "still"
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [3, 3] }
[[body]]
name = "sewn"
material = "still"
position = [0.2, 0, 0]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [3, 3] }
[[body]]
name = "moving"
position = [0, 0, 1]
velocity = [0.1, 0, 0]
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [2, 2] }
material = "cloth"
[[seam]]
body = "held"
edge = "last_col"
to = "sewn"
to_edge = "first_col"
)";
  Simulation simulation = simulation_of(text, {"world.gravity=[0,0,0]", "time.duration=2",
                                               "time.method=\"euler\"", "time.step=0.02"});
  advance_to(simulation, 1);
  EXPECT_EQ(simulation.summary_of(1, simulation.state()).sleeping_bodies, 2);
}

TEST(Seam, HangsAPieceInAnEquilibrium) {
  const std::string text = std::string(setting) + R"(
[[body]]
name = "held"
rotation_deg = [90, 0, 0]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [5, 5] }
[[body.pin]]
edges = ["last_row"]
[[body]]
name = "hung"
rotation_deg = [90, 0, 0]
position = [0, 0, -0.2]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [5, 5] }
[[seam]]
body = "hung"
edge = "last_row"
to = "held"
to_edge = "first_row"
)";
  Simulation simulation =
      simulation_of(text, {"time.method=\"static\"", "time.frames_per_second=25"});
  advance_to(simulation, 0.2);
  EXPECT_LT(opening(simulation), 1e-5);
  EXPECT_LT(mean_of(simulation.position("hung")).z(), -0.2);
}

TEST(Seam, IsSavedWithTheState) {
  const Overrides overrides{"time.method=\"euler\"", "time.step=5e-3"};
  Simulation whole = simulation_of(closing, overrides), begun = simulation_of(closing, overrides);
  while (whole.time() < 0.1) ASSERT_FALSE(whole.step());
  begun.restore(whole.save());
  while (whole.time() < 0.3) ASSERT_FALSE(whole.step());
  while (begun.time() < 0.3) ASSERT_FALSE(begun.step());
  EXPECT_TRUE(std::ranges::equal(whole.state(), begun.state()));
}

}  // namespace weft::sim::seam_test
