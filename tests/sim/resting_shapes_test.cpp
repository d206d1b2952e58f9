// Every shape as an obstacle on which a sheet comes down, and as a body that comes down on a plane.
#include <optional>
#include <ostream>

#include "sim/run/make_simulation.h"
#include "sim/simulation/simulation.h"
#include "simulated_case.h"

namespace weft::sim::resting_shapes_test {
namespace {

struct RestingShape {
  std::string name;
  std::string table;     // the shape in a case file
  std::string rotation;  // degrees
  double top;            // m, of the rotated shape
  double bottom;         // m
};

std::ostream& operator<<(std::ostream& stream, const RestingShape& shape) {
  return stream << shape.name;
}

// Round shapes lie on their sides. Open ones stand on their rims or lie on an edge.
std::vector<RestingShape> resting_shapes() {
  return {
      {"box", R"("box", size = [0.2, 0.1, 0.1], resolution = [9, 5, 5])", "0, 0, 0", 0.05, -0.05},
      {"disc", R"("disc", radius = 0.1, resolution = [5])", "0, 0, 0", 0, 0},
      {"annulus", R"("annulus", inner_radius = 0.05, outer_radius = 0.12, resolution = [5, 32])",
       "0, 0, 0", 0, 0},
      {"annulus_sector",
       R"("annulus", inner_radius = 0.05, outer_radius = 0.12, angle_deg = 270, resolution = [5, 25])",
       "0, 0, 0", 0, 0},
      {"capsule", R"("capsule", radius = 0.05, length = 0.1, resolution = [9, 5])", "90, 0, 0",
       0.05, -0.05},
      {"cone", R"("cone", radius = 0.1, length = 0.1, resolution = [5])", "0, 0, 0", 0.05, -0.05},
      {"frustum", R"("cone", radius = 0.1, top_radius = 0.06, length = 0.1, resolution = [7, 32])",
       "0, 0, 0", 0.05, -0.05},
      {"cylinder_sector",
       R"("cylinder", radius = 0.1, length = 0.2, angle_deg = 180, resolution = [11, 17])",
       "90, 0, 0", 0.1, 0},
      {"sphere_sector",
       R"("sphere_sector", radius = 0.1, latitude_deg = [0, 60], resolution = [8, 32])", "0, 0, 0",
       0.1 * 0.866025403784439, 0},
      {"sphere_sector_of_half_a_turn",
       R"("sphere_sector", radius = 0.1, latitude_deg = [-45, 45], angle_deg = 180, resolution = [9, 17])",
       "90, 0, 0", 0.1, 0},
  };
}

// A plane cannot be a body.
std::vector<RestingShape> supports() {
  std::vector<RestingShape> all = resting_shapes();
  all.push_back({"plane", R"("plane", size = [20, 20])", "0, 0, 0", 0, 0});
  return all;
}

constexpr const char* settings = R"(
[time]
duration = 0.15
[contact]
friction = 0.3
[material.card]
bending_stiffness = 1e-4
stiffness_damping = 1e-3
bending_damping = 1e-3
)";

std::string table(const std::string& kind, const std::string& name, const std::string& shape,
                  const std::string& rotation, double height) {
  return "[[" + kind + "]]\nname = \"" + name + "\"\nshape = { type = " + shape +
         " }\nrotation_deg = [" + rotation + "]\nposition = [0, 0, " + std::to_string(height) +
         "]\n";
}

// Runs a case and checks its surfaces five times: they come into reach, a gap is left between them,
// and none crosses another.
void expect_rest_without_crossing(const std::string& text) {
  Simulation simulation = make_simulation(parse_case(text, "test.toml"));
  std::optional<double> gap;
  for (int part = 1; part <= 5; ++part) {
    const auto failure = simulation.advance(0.03 * part - simulation.time());
    ASSERT_FALSE(failure) << failure->text;
    if (simulation.smallest_gap()) {
      gap = simulation.smallest_gap();
      EXPECT_GT(*gap, 0);
    }
    std::vector<Vec3> position;
    for (const SceneBody& body : simulation.scene().bodies) {
      const std::vector<Vec3> own = simulation.position(body.name);
      position.insert(position.end(), own.begin(), own.end());
    }
    EXPECT_EQ(crossings(simulation.scene(), position), 0);
  }
  EXPECT_TRUE(gap) << "nothing came into reach";
}

class Supports : public testing::TestWithParam<RestingShape> {};

TEST_P(Supports, HoldASheet) {
  const RestingShape& shape = GetParam();
  expect_rest_without_crossing(settings +
                               table("body", "sheet",
                                     R"("rectangle", size = [0.3, 0.3], resolution = [17, 17])",
                                     "0, 0, 20", shape.top + 0.006) +
                               table("obstacle", "support", shape.table, shape.rotation, 0));
}

class RestingShapes : public testing::TestWithParam<RestingShape> {};

TEST_P(RestingShapes, LieOnAPlane) {
  const RestingShape& shape = GetParam();
  expect_rest_without_crossing(
      settings + table("body", "thing", shape.table, shape.rotation, 0.006 - shape.bottom) +
      table("obstacle", "ground", R"("plane", size = [20, 20])", "0, 0, 0", 0));
}

// A slanted plane holds as well as a level one, whatever its size.
TEST(Plane, HoldsASheetWhenItIsSlantedAndLarge) {
  for (const char* size : {"2", "200"}) {
    const std::string plane =
        R"("plane", size = [)" + std::string(size) + ", " + std::string(size) + "]";
    expect_rest_without_crossing(settings +
                                 table("body", "sheet",
                                       R"("rectangle", size = [0.3, 0.3], resolution = [17, 17])",
                                       "20, 0, 0", 0.006) +
                                 table("obstacle", "ground", plane, "20, 0, 0", 0));
  }
}

std::string name_of(const testing::TestParamInfo<RestingShape>& row) { return row.param.name; }

INSTANTIATE_TEST_SUITE_P(Each, Supports, testing::ValuesIn(supports()), name_of);
INSTANTIATE_TEST_SUITE_P(Each, RestingShapes, testing::ValuesIn(resting_shapes()), name_of);

}  // namespace
}  // namespace weft::sim::resting_shapes_test
