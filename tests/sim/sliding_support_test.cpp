// Pins that hold some directions only, and planes of symmetry.
#include <cmath>

#include "tests/sim/channel_run.h"
#include "tests/sim/joint_cases.h"

namespace weft::sim::sliding_support_test {
namespace {

// A square of cloth whose first edge is held along its normal and whose last edge is pulled along
// x, between edges that are free to contract.
std::string pulled_square(const std::string& material) {
  return R"(
[time]
method = "static"
duration = 1
frames_per_second = 1
position_tolerance = 1e-9
[static]
loading = "in_time"
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[output]
channels = ["reactions"]
[material.square]
)" + material +
         R"(
[[body]]
name = "square"
shape = { type = "rectangle", size = [1, 1], resolution = [7, 7] }
[[body.pin]]
edges = ["first_col"]
axes = ["x"]
[[body.pin]]
edges = ["last_col"]
axes = ["x"]
motion = { velocity = [0.2, 0, 0] }
[[body.pin]]
corners = ["first_first"]
axes = ["y", "z"]
[[body.pin]]
corners = ["last_first", "first_last"]
axes = ["z"]
)";
}

const std::string square_cloth =
    "density = 0.2\nmembrane_stiffness = 1000\npoisson_ratio = 0.3\nbending_stiffness = 1e-3\n";
const std::string square_shell =
    "model = \"shell\"\nyoungs_modulus = 1e6\npoisson_ratio = 0.3\nshell_thickness = 1e-3\n"
    "volume_density = 1000\n";

}  // namespace

class PulledSquare : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(All, PulledSquare, testing::Values(square_cloth, square_shell));

// Uniaxial stress of St. Venant-Kirchhoff: S = E h (l^2 - 1) / 2 at the stretch l, with the lateral
// strain -nu (l^2 - 1) / 2. The force per width at rest is S l.
TEST_P(PulledSquare, ContractsAsItsPoissonRatioSays) {
  ChannelRun run(pulled_square(GetParam()));
  run.advance_to(1);
  constexpr double stretch = 1.2;
  const double strain = (stretch * stretch - 1) / 2;
  const double width = std::sqrt(1 - 2 * 0.3 * strain);
  const double force = 1000 * strain * stretch;
  const std::vector<Vec3>& x = run.position();
  // The strain points of shells do not integrate all products of their functions at open ends: a
  // constant stress is then 1e-3 off on this image.
  const bool is_shell = GetParam() == square_shell;
  EXPECT_NEAR((x[7 * 6 + 3] - x[3]).y(), width, is_shell ? 2e-3 : 1e-5);
  EXPECT_NEAR((x[6] - x[0]).x(), stretch, 1e-5);
  EXPECT_NEAR(run.vector("reactions/square/pin_2/force").x(), force, 1e-3 * force);
  EXPECT_NEAR(run.vector("reactions/square/pin_1/force").x(), -force, 1e-3 * force);
  EXPECT_NEAR(run.vector("reactions/square/pin_1/force").y(), 0, 1e-9 * force);
}

// Supports do work in a search for equilibria, too, and the energy watch must not take it for a
// gain of the motion.
TEST(SlidingSupport, PullsInASearchByPseudoSteps) {
  Simulation square =
      simulation_of(pulled_square(square_cloth), {"static.loading=\"proportional\""});
  advance_to(square, 1);
  const std::vector<Vec3> x = square.position("square");
  EXPECT_NEAR((x[6] - x[0]).x(), 1.2, 1e-5);
  EXPECT_NEAR((x[7 * 6 + 3] - x[3]).y(), std::sqrt(1 - 0.3 * (1.2 * 1.2 - 1)), 1e-4);
}

TEST(SlidingSupport, ForcesAndMatricesAgreeWithTheEnergy) {
  for (const std::string& material : {square_cloth, square_shell}) {
    std::string text = pulled_square(material);
    text.replace(text.find("velocity = [0.2, 0, 0]"), 22,
                 "velocity = [0.2, 0, 0], stop_time = 0.5");
    text.replace(text.find("method = \"static\""), 17, "method = \"cvode\"");
    text.replace(text.find("[static]\nloading = \"in_time\""), 28, "");
    expect_consistent_forces(text, 0.7);
  }
}

// A sheet slides along a rail at the speed with which it starts, however long: the rail holds its
// height against gravity.
TEST(SlidingSupport, LeavesTheOtherDirectionsFree) {
  const std::string text = R"(
[time]
duration = 0.5
[contact]
enabled = false
[material.cloth]
mass_damping = 0
[[body]]
name = "sheet"
velocity = [0.4, 0, 0]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [4, 4] }
[[body.pin]]
rows = [0, -1]
axes = ["z"]
)";
  for (const char* name : {"cvode", "arkode", "euler"}) {
    Simulation simulation = simulation_of(text, method(name));
    const Vec3 start = mean_of(simulation.position("sheet"));
    advance_to(simulation, 0.5);
    const Vec3 way = mean_of(simulation.position("sheet")) - start;
    EXPECT_NEAR(way.x(), 0.2, 1e-4) << name;
    EXPECT_NEAR(way.z(), 0, 1e-6) << name;
  }
}

// A moving support puts energy into the sheet, which the watch of energies must know. The sheet
// turns by a small angle as a rigid bar with the masses 1, 2, 2, 1 at its columns: lifted at its
// end, its centre rises by 1 / (1 + 27 / 11) of that.
TEST(SlidingSupport, CarriesASheetAlong) {
  const std::string text = R"(
[time]
duration = 0.4
position_tolerance = 1e-7
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.cloth]
stiffness_damping = 1e-3
bending_stiffness = 0.1
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [4, 4] }
[[body.pin]]
edges = ["first_col"]
axes = ["z"]
[body.pin.motion]
keyframes = [{ time = 0.2, translation = [0, 0, 0.005] }]
)";
  Simulation simulation = simulation_of(text);
  advance_to(simulation, 0.4);
  const std::vector<Vec3> x = simulation.position("sheet");
  for (int row = 0; row < 4; ++row) EXPECT_NEAR(x[4 * row].z(), 0.005, 1e-6);
  EXPECT_NEAR(mean_of(x).z(), 0.005 / (1 + 27.0 / 11), 3e-6);
}

// A strip of shell with a rail at its first edge. The springs of the rail would pass on a speed
// within 1e-8 s, which no step resolves.
std::string railed_strip(const std::string& start, const std::string& motion) {
  return R"(
[time]
duration = 0.1
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.solid]
model = "shell"
youngs_modulus = 1e9
poisson_ratio = 0
shell_thickness = 5e-3
volume_density = 1000
stiffness_damping = 1e-4
[[body]]
name = "strip"
)" + start +
         R"(
shape = { type = "rectangle", size = [1, 0.3], resolution = [5, 9] }
[[body.pin]]
edges = ["first_col"]
axes = ["x", "z"]
)" + motion;
}

TEST(SlidingSupport, GivesItsSpeedAtOnce) {
  const std::string text = railed_strip("", "motion = { velocity = [0, 0, 3] }\n");
  for (const char* name : {"cvode", "arkode", "euler"}) {
    Simulation simulation = simulation_of(text, method(name));
    advance_to(simulation, 0.1);
    EXPECT_NEAR(simulation.position("strip")[0].z(), 0.3, 1e-4) << name;
  }
}

TEST(SlidingSupport, JumpsFromSpeedToSpeed) {
  const std::string text = railed_strip(
      "", "motion = { velocity = [0, 0, 1], start_time = 0.0203, stop_time = 0.0617 }\n");
  for (const char* name : {"cvode", "arkode", "euler"}) {
    Simulation simulation = simulation_of(text, method(name));
    advance_to(simulation, 0.04);
    EXPECT_NEAR(simulation.position("strip")[0].z(), 0.04 - 0.0203, 1e-4) << name;
    advance_to(simulation, 0.1);
    EXPECT_NEAR(simulation.position("strip")[0].z(), 0.0617 - 0.0203, 1e-4) << name;
  }
}

TEST(SlidingSupport, StopsWhatRunsAgainstItAtTheStart) {
  const std::string text = railed_strip("velocity = [0, 0.2, 3]", "");
  for (const char* name : {"cvode", "arkode", "euler"}) {
    Simulation simulation = simulation_of(text, method(name));
    const Vec3 start = simulation.position("strip")[0];
    advance_to(simulation, 0.1);
    const Vec3 way = simulation.position("strip")[0] - start;
    EXPECT_NEAR(way.z(), 0, 1e-4) << name;
    EXPECT_NEAR(way.y(), 0.02, 1e-4) << name;
  }
}

// A plate under pressure between two simple supports sags like its half with a plane of symmetry.
TEST(Symmetry, HalfAPlateSagsLikeTheWhole) {
  const auto plate = [](bool is_half) {
    const std::string size = is_half ? "[0.5, 0.4]" : "[1, 0.4]";
    const std::string resolution = is_half ? "[7, 11]" : "[7, 19]";
    const std::string second = is_half ? "symmetry_normal = [1, 0, 0]" : "axes = [\"z\"]";
    // The plane of symmetry keeps the half from sliding; the whole is held at one vertex.
    const std::string third =
        is_half ? "" : "[[body.pin]]\nrows = [3, 3]\ncols = [0, 0]\naxes = [\"x\"]\n";
    return R"(
[time]
method = "static"
duration = 1
frames_per_second = 1
position_tolerance = 1e-9
[static]
loading = "in_time"
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.plate]
model = "shell"
youngs_modulus = 1e9
poisson_ratio = 0.3
shell_thickness = 0.01
volume_density = 1000
[[body]]
name = "plate"
shape = { type = "rectangle", size = )" +
           size + ", resolution = " + resolution + R"( }
[[body.pin]]
edges = ["first_col"]
axes = ["z"]
[[body.pin]]
edges = ["last_col"]
)" + second +
           R"(
[[body.pin]]
corners = ["first_first"]
axes = ["y"]
)" + third +
           R"([[load]]
body = "plate"
type = "area"
force = { times = [0, 1], values = [[0, 0, 0], [0, 0, -20]] }
)";
  };
  Simulation whole = simulation_of(plate(false)), half = simulation_of(plate(true));
  advance_to(whole, 1);
  advance_to(half, 1);
  // Elements of the same size; the middle of the whole plate is a knot, where a third of the
  // neighbours counts.
  const std::vector<Vec3> x = whole.position("plate"), y = half.position("plate");
  const double middle = (x[19 * 3 + 8].z() + 4 * x[19 * 3 + 9].z() + x[19 * 3 + 10].z()) / 6;
  const double sag = y[11 * 3 + 10].z();
  // A beam with the stiffness of a plate sags by 5 q L^4 / (384 D).
  const double rigidity = 1e9 * 1e-6 / 12;
  EXPECT_NEAR(-sag, 5 * 20 / (384 * rigidity), 0.1 * 5 * 20 / (384 * rigidity));
  EXPECT_NEAR(middle, sag, 1e-3 * std::abs(sag));
}

}  // namespace weft::sim::sliding_support_test
