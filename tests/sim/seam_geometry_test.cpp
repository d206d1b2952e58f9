// Seams as geometry: the angle of a fold, triangles at clamps, closed borders, points that touch.
#include <cmath>
#include <numbers>

#include "tests/sim/bad_case.h"
#include "tests/sim/joint_cases.h"

namespace weft::sim::seam_geometry_test {
namespace {

// Cloth without contact.
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

// Two pieces that are sewn along borders of 7 and 19 vertices.
constexpr const char* uneven_pieces = R"(
[time]
duration = 0.1
frames_per_second = 50
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
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [7, 5] }
[[body]]
name = "other"
material = "soft"
position = [0.2, 0, 0]
shape = { type = "rectangle", size = [0.4, 0.3], resolution = [19, 6] }
[[seam]]
body = "one"
edge = "last_col"
to = "other"
to_edge = "first_col"
)";

// Two pieces that start folded upwards by 30 degrees at their seam. `rotation` turns the far one.
std::string folded_pieces(const std::string& rotation, double angle_deg,
                          const std::string& pin = "") {
  return R"(
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.cloth]
density = 0.2
membrane_stiffness = 500
poisson_ratio = 0
bending_stiffness = 1e-3
[[body]]
name = "near"
position = [-0.05, 0, 0]
shape = { type = "rectangle", size = [0.1, 0.05], resolution = [5, 9] }
)" + pin +
         R"(
[[body]]
name = "far"
position = [0.0433012701892, 0, 0.025]
shape = { type = "rectangle", size = [0.1, 0.05], resolution = [5, 9] }
rotation_deg = )" +
         rotation + R"(
[[seam]]
body = "near"
edge = "last_col"
to = "far"
to_edge = "first_col"
angle_deg = )" +
         std::to_string(angle_deg) + "\n";
}

double strain_energy_of(const std::string& text) {
  const auto scene = build_scene(parse_case(text, "test.toml"));
  Statistics statistics;
  Dynamics dynamics(*scene, statistics);
  double sum = 0;
  for (const auto& [name, energy] : dynamics.energies(0, dynamics.initial_state()).elastic)
    sum += energy;
  return sum;
}

}  // namespace

// A fold is the same whichever side of the far piece is up. D L t^2 / (2 a) is the energy of an
// angle t off rest.
TEST(SeamGeometry, FoldsToTheSameSideWhicheverWayThePiecesLie) {
  const double angle = std::numbers::pi / 6;
  const double of_angle = 1e-3 * 0.05 * angle * angle / (2 * 0.1 / 8);
  // Turned by -30 degrees about y, and the same after half a turn about x.
  for (const char* rotation : {"[0, -30, 0]", "[173.8666487320, 0, 46.5874281185]"}) {
    const double least = std::min(strain_energy_of(folded_pieces(rotation, 30)),
                                  strain_energy_of(folded_pieces(rotation, -30)));
    const double most = std::max(strain_energy_of(folded_pieces(rotation, 30)),
                                 strain_energy_of(folded_pieces(rotation, -30)));
    EXPECT_NEAR(least, 0, 1e-6 * of_angle) << rotation;
    EXPECT_NEAR(most, 4 * of_angle, 1e-5 * of_angle) << rotation;
    EXPECT_NEAR(strain_energy_of(folded_pieces(rotation, 0)), of_angle, 1e-5 * of_angle)
        << rotation;
  }
}

// A triangle beside a clamp and a seam bends once.
TEST(SeamGeometry, SharesATriangleWithAClamp) {
  const double free = strain_energy_of(folded_pieces("[0, -30, 0]", 0));
  const double clamped = strain_energy_of(
      folded_pieces("[0, -30, 0]", 0, "[[body.pin]]\nedges = [\"last_row\"]\nclamp = true\n"));
  EXPECT_NEAR(clamped, free, 1e-6 * free);
}

// Tubes that are sewn end to end, turned against each other by whole cells, do not bend at the
// seam.
TEST(SeamGeometry, JoinsTurnedTubesWithoutBending) {
  for (const char* turn : {"0", "60", "-90"}) {
    const std::string text = std::string(setting) + R"(
[[body]]
name = "lower"
shape = { type = "cylinder", radius = 0.1, length = 0.2, resolution = [5, 12] }
[[body]]
name = "upper"
position = [0, 0, 0.2]
rotation_deg = [0, 0, )" + turn +
                             R"(]
shape = { type = "cylinder", radius = 0.1, length = 0.2, resolution = [5, 12] }
[[seam]]
body = "lower"
edge = "last_row"
to = "upper"
to_edge = "first_row"
)";
    EXPECT_LT(strain_energy_of(text), 1e-20) << turn;
  }
}

// Vertices that hang between the same two vertices touch, as contact knows.
TEST(SeamGeometry, JoinsVerticesThatHangBetweenTheSameOnes) {
  const auto scene = build_scene(parse_case(uneven_pieces, "test.toml"));
  const Seam& seam = scene->seams.at(0);
  const int first = scene->bodies[scene->case_order[seam.body]].first_point;
  int pairs = 0;
  for (const Stitch& one : seam.stitches) {
    for (const Stitch& other : seam.stitches) {
      if (one.nodes[0] == one.nodes[1] || one.nodes != other.nodes || one.vertex == other.vertex)
        continue;
      ++pairs;
      EXPECT_TRUE(scene->sewn.are_joined(first + one.vertex, first + other.vertex));
    }
  }
  EXPECT_EQ(pairs, 2 * 6);
}

// By distance alone, both halves of the edge would be joined by a translation, and rolled up.
TEST(SeamGeometry, ClosesADartFromTheVertexThatItsSidesShare) {
  for (const std::string ranges :
       {"range = [0, 4]\nto_range = [4, 8]\n", "range = [4, 8]\nto_range = [0, 4]\n"}) {
    const auto scene = build_scene(parse_case(std::string(setting) + R"(
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [5, 9] }
[[seam]]
body = "sheet"
edge = "first_row"
to = "sheet"
to_edge = "first_row"
closing_time = 0.1
)" + ranges,
                                              "test.toml"));
    const std::vector<Stitch>& stitches = scene->seams[0].stitches;
    ASSERT_EQ(stitches.size(), 4);
    for (const Stitch& stitch : stitches) {
      EXPECT_EQ(stitch.nodes[0], 8 - stitch.vertex);
      EXPECT_EQ(stitch.nodes[1], 8 - stitch.vertex);
    }
  }
}

// Pieces that a seam still draws together do not fall asleep, however slowly it does.
TEST(SeamGeometry, KeepsPiecesAwakeUntilItIsClosed) {
  const std::string text = std::string(setting) + R"(
[material.still]
density = 0.2
mass_damping = 10
[[body]]
name = "one"
material = "still"
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [3, 3] }
[[body]]
name = "other"
material = "still"
position = [0.22, 0, 0]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [3, 3] }
[[body]]
name = "moving"
position = [0, 0, 1]
velocity = [0.1, 0, 0]
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [2, 2] }
material = "cloth"
[[seam]]
body = "one"
edge = "last_col"
to = "other"
to_edge = "first_col"
closing_time = 1e4
)";
  Simulation simulation = simulation_of(text, {"world.gravity=[0,0,0]", "time.duration=1e4",
                                               "time.method=\"euler\"", "time.step=0.02"});
  advance_to(simulation, 1);
  EXPECT_EQ(simulation.summary_of(1, simulation.state()).sleeping_bodies, 0);
}

// Nothing joins pieces whose seam is still open: neither parallel sheets that would lie folded onto
// each other, nor the ends of a flat strip, between which lies the whole strip.
TEST(SeamGeometry, OpenSeamsDoNotBend) {
  const std::string ends = "[[seam]]\nbody = \"one\"\nedge = \"last_col\"\nclosing_time = 0.1\n";
  const std::string one = std::string(setting) + R"(
[[body]]
name = "one"
shape = { type = "rectangle", size = [0.3, 0.1], resolution = [5, 13] }
)";
  const std::string other = R"(
[[body]]
name = "other"
position = [0, 0, 0.15]
shape = { type = "rectangle", size = [0.3, 0.1], resolution = [5, 13] }
)";
  const Overrides weightless{"world.gravity=[0,0,0]"};
  for (const std::string& text :
       {one + other + ends + "to = \"other\"\nto_edge = \"last_col\"\n",
        one + ends + "to = \"one\"\nto_edge = \"first_col\"\nangle_deg = 30\n"}) {
    const auto scene = build_scene(parse_case(text, "test.toml", weightless));
    Statistics statistics;
    Dynamics dynamics(*scene, statistics);
    for (const auto& [name, energy] : dynamics.energies(0, dynamics.initial_state()).elastic)
      EXPECT_LT(energy, 1e-20) << name;
    std::vector<Vec3> acceleration(scene->mass.size());
    ASSERT_FALSE(dynamics.acceleration(0, dynamics.initial_state(), acceleration));
    for (const Vec3& each : acceleration) EXPECT_LT(each.norm(), 1e-6);
  }
}

// The power of a closing seam is the rate of the energy at fixed positions.
TEST(SeamGeometry, ClosingPutsInTheEnergyOfTheFold) {
  for (const char* law : {"", "yield_curvature = 20\n"}) {
    std::string text = folded_pieces("[0, -30, 0]", 70) + "closing_time = 0.2\n";
    text.insert(text.find("poisson_ratio"), law);
    const auto scene = build_scene(parse_case(text, "test.toml"));
    Statistics statistics;
    Dynamics dynamics(*scene, statistics);
    const std::vector<double> y = dynamics.initial_state();
    const auto energy_at = [&](double time) {
      const Energies energies = dynamics.energies(time, y);
      return energies.total() + energies.dissipated.value_or(0);
    };
    constexpr double time = 0.08, step = 1e-6;
    const double rate = (energy_at(time + step) - energy_at(time - step)) / (2 * step);
    EXPECT_GT(rate, 1e-3);
    EXPECT_NEAR(dynamics.external_power(time, y), rate, 1e-6 * rate);
  }
}

}  // namespace weft::sim::seam_geometry_test
