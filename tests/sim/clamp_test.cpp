// Clamps against the elastica, differences of energies and rigid motion.
#include <cmath>

#include "tests/reference_value.h"
#include "tests/sim/bad_case.h"
#include "tests/sim/joint_cases.h"

namespace weft::sim::clamp_test {
namespace {

// Returns the distance of a strip's tip from that of the inextensible elastica, as a share of the
// length of 0.27 m.
double tip_error(int columns) {
  const double width = 3 * 0.27 / (columns - 1);  // of three square cells
  Simulation simulation =
      make_simulation(read_case(WEFT_CASES_DIR "/benchmarks/cloth_cantilever.toml",
                                {"body.strip.shape.resolution=[4, " + std::to_string(columns) + "]",
                                 "body.strip.shape.size=[0.27, " + std::to_string(width) + "]"}));
  advance_to(simulation, 1);
  const std::vector<Vec3> places = simulation.position("strip");
  double drop = 0, reach = 0;
  for (int row = 0; row < 4; ++row) {
    const Vec3 &held = places[row * columns], &tip = places[row * columns + columns - 1];
    drop += (held.z() - tip.z()) / 4;
    reach += (tip.x() - held.x()) / 4;
  }
  return std::hypot(drop / 0.27 - reference_value("heavy_elastica_drop_over_length"),
                    reach / 0.27 - reference_value("heavy_elastica_reach_over_length"));
}

// A strip in space whose clamp turns by 60 degrees, while other edges of its triangles bend.
constexpr const char* turning_strip = R"(
[time]
duration = 1
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.strip]
density = 0.2
membrane_stiffness = 500
bending_stiffness = 1e-2
bending_damping = 1e-2
[[body]]
name = "strip"
shape = { type = "rectangle", size = [0.3, 0.1], resolution = [4, 10] }
[[body.pin]]
edges = ["first_col"]
clamp = true
[body.pin.motion]
centre = [-0.15, 0, 0]
keyframes = [{ time = 0 }, { time = 0.3, rotation_deg = [0, 60, 0] }]
)";

}  // namespace

TEST(Clamp, CantileverConvergesToTheElastica) {
  const double coarse = tip_error(14), middle = tip_error(27), fine = tip_error(53);
  EXPECT_LT(middle, 0.005);
  EXPECT_NEAR(std::log2(coarse / middle), 2, 0.15);
  EXPECT_NEAR(std::log2(middle / fine), 2, 0.25);
}

// The strip's clamp is at rest from 0.3 s on, turned.
TEST(Clamp, ForcesAreSlopesOfTheEnergy) {
  expect_consistent_forces(turning_strip, 0);
  expect_consistent_forces(turning_strip, 0.5);
  expect_consistent_forces(
      std::string(turning_strip) + "[[body.pin]]\nrows = [0, 1]\ncols = [5, 9]\nclamp = true\n", 0);
}

TEST(Clamp, CarriesAStripRound) {
  for (const char* name : {"cvode", "euler", "arkode"}) {
    SCOPED_TRACE(name);
    Simulation simulation = simulation_of(
        turning_strip, method(name, {"material.strip.mass_damping=10", "time.duration=4"}));
    const std::vector<Vec3> start = simulation.position("strip");
    advance_to(simulation, 4);
    const std::vector<Vec3> places = simulation.position("strip");
    const Eigen::Matrix3d turn = rotation_from_degrees({0, 60, 0});
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Vec3 expected = turn * (start[i] + Vec3(0.15, 0, 0)) - Vec3(0.15, 0, 0);
      EXPECT_LT((places[i] - expected).norm(), 2e-3) << i;
    }
  }
}

// Both halves of a strip hang from its middle column as from clamped borders.
TEST(Clamp, HoldsTheSameFromARowInsideASheet) {
  const std::string text =
      "[time]\nmethod = \"static\"\nduration = 1\nframes_per_second = 1\n[contact]\nenabled = "
      "false\n[material.strip]\npoisson_ratio = 0\nbending_stiffness = 1e-2\n[[body]]\nname = "
      "\"strip\"\nshape = { type = \"rectangle\", size = [0.4, 0.1], resolution = [4, 21] }\n"
      "[[body.pin]]\ncols = [10, 10]\nclamp = true\n";
  Simulation simulation = simulation_of(text);
  advance_to(simulation, 1);
  const std::vector<Vec3> places = simulation.position("strip");
  for (int column = 0; column < 21; ++column) {
    const Vec3 &one = places[21 + column], &other = places[2 * 21 + 20 - column];
    EXPECT_NEAR(one.x(), -other.x(), 1e-6);
    EXPECT_NEAR(one.z(), other.z(), 1e-6);
  }
  EXPECT_LT(places[21].z(), -0.01);
  // Beside the clamp the strip is a parabola of curvature sigma g L^2 / (2 D).
  const double curvature = 0.2 * 9.81 * 0.2 * 0.2 / (2 * 1e-2);
  EXPECT_NEAR(places[21 + 9].z(), -0.5 * curvature * 0.02 * 0.02, 4e-5);
}

namespace {

// A strip of 0.2 m; overrides add its pins.
constexpr const char* damped_strip = R"(
[time]
duration = 2
method = "euler"
step = 1e-3
[contact]
enabled = false
[material.strip]
bending_stiffness = 4e-3
mass_damping = 10
[[body]]
name = "strip"
shape = { type = "rectangle", size = [0.2, 0.06], resolution = [4, 11] }
[[body.pin]]
edges = ["first_col"]
clamp = true
)";

}  // namespace

// A clamp that takes hold of a strip that hangs down, and turns by a right angle, holds it out.
TEST(Clamp, TakesHoldOfTheSurfaceAsItIs) {
  const std::string text = std::string(damped_strip) +
                           "hold_time = 1\n[body.pin.motion]\ncentre = [-0.1, 0, 0]\nkeyframes = "
                           "[{ time = 1 }, { time = 1.3, rotation_deg = [0, -90, 0] }]\n"
                           "[[body.pin]]\nedges = [\"first_col\"]\nrelease_time = 1\n";
  Simulation simulation = simulation_of(text);
  advance_to(simulation, 1);
  EXPECT_LT(simulation.position("strip")[10].z(), -0.18);
  advance_to(simulation, 2);
  const Vec3 tip = simulation.position("strip")[10];
  EXPECT_GT(tip.z(), -0.12);
  EXPECT_GT(tip.x(), 0.02);
}

// The direction of a clamp is that of its own start, whatever other pins do meanwhile.
TEST(Clamp, KeepsItsDirectionWhileOtherPinsChange) {
  const std::string other =
      "[[body.pin]]\ncorners = [\"first_last\"]\nhold_time = 0.5\nrelease_time = 0.51\n";
  Simulation touched = simulation_of(damped_strip + other), alone = simulation_of(damped_strip);
  advance_to(touched, 2);
  advance_to(alone, 2);
  EXPECT_NEAR(touched.position("strip")[10].z(), alone.position("strip")[10].z(), 2e-4);
}

TEST(Clamp, LetsGoAndContinuesFromBytes) {
  const std::string text = std::string(damped_strip) + "release_time = 0.6\n";
  Simulation simulation = simulation_of(text), again = simulation_of(text);
  advance_to(simulation, 0.59);
  EXPECT_GT(simulation.position("strip")[10].z(), -0.12);
  again.restore(simulation.save());
  advance_to(simulation, 0.8);
  advance_to(again, 0.8);
  EXPECT_LT(simulation.position("strip")[0].z(), -0.05);
  EXPECT_EQ(simulation.position("strip"), again.position("strip"));
}

class BadClamp : public testing::TestWithParam<BadCase> {};
TEST_P(BadClamp, IsRefused) { expect_refused(GetParam()); }
INSTANTIATE_TEST_SUITE_P(
    Cases, BadClamp,
    testing::Values(
        BadCase{"without_bending", sheet + "[[body.pin]]\nedges = [\"first_row\"]\nclamp = true\n",
                "case.toml:6:9: a clamp of body \"sheet\", whose material does not resist bending\n"
                "  expected bending_stiffness > 0 or orthotropic_bending in [material.default]"},
        BadCase{"of_another_type", sheet + "[[body.pin]]\nedges = [\"first_row\"]\nclamp = 1\n",
                "case.toml:6:9: \"clamp\" is a whole number\n  expected true or false"}),
    bad_case_name);

TEST(Clamp, NeedsAnEdge) {
  const std::string text = "[material.stiff]\nbending_stiffness = 1e-3\n" + sheet +
                           "[[body.pin]]\ncorners = [\"all\"]\nclamp = true\n";
  try {
    build_scene(parse_case(text, "case.toml"));
    FAIL() << "accepted";
  } catch (const CaseError& error) {
    EXPECT_STREQ(error.what(),
                 "case.toml:6:1: this clamp holds no edge of the surface\n"
                 "  expected a pin that holds neighbouring vertices, with free ones beside them");
  }
}

}  // namespace weft::sim::clamp_test
