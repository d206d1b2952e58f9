// Bodies that start in another shape than that of rest.
#include <cmath>
#include <fstream>

#include "sim/case/case_writer.h"
#include "sim/scene/start_shape.h"
#include "sim/view/scene_description.h"
#include "tests/sim/bad_case.h"
#include "tests/sim/joint_cases.h"

namespace weft::sim::start_shape_test {
namespace {

// A plate of bending stiffness D = 1e-2 N m and 0.3 x 0.2 m.
std::string plate(const std::string& start, int rows = 9, int columns = 13) {
  return "[contact]\nenabled = false\n[world]\ngravity = [0, 0, 0]\n[material.plate]\n"
         "membrane_stiffness = 1000\npoisson_ratio = 0\nbending_stiffness = 1e-2\n[[body]]\nname = "
         "\"plate\"\nstart = " +
         start + "\nshape = { type = \"rectangle\", size = [0.3, 0.2], resolution = [" +
         std::to_string(rows) + ", " + std::to_string(columns) + "] }\n";
}

double strain_energy(const std::string& text) {
  const auto scene = build_scene(parse_case(text, "test.toml"));
  Statistics statistics;
  Dynamics dynamics(*scene, statistics);
  return dynamics.energies(0, dynamics.initial_state()).total();
}

}  // namespace

TEST(StartShape, BendsOntoACylinder) {
  const Vec3 along = Vec3(1, 2, 0).normalized(), across = Vec3(-2, 1, 0).normalized();
  const double direction = std::atan2(2, 1) * 180 / std::acos(-1.0);
  for (const double radius : {0.3, -0.3, 5e3}) {
    std::vector<Vec3> flat;
    for (int i = -5; i <= 5; ++i)
      flat.push_back(0.1 * i * along + 0.02 * i * i * across + Vec3(0, 0, 0.01 * i));
    const std::vector<Vec3> bent = bend(flat, radius, direction);
    for (std::size_t i = 0; i < flat.size(); ++i) {
      const double angle = flat[i].dot(along) / radius, inner = radius - flat[i].z();
      EXPECT_NEAR(bent[i].dot(along), inner * std::sin(angle), 1e-11);
      EXPECT_NEAR(bent[i].z(), radius - inner * std::cos(angle), 1e-11);
      EXPECT_NEAR(bent[i].dot(across), flat[i].dot(across), 1e-12);
    }
  }
}

// The energy of a plate bent to a cylinder is D A / (2 R^2), in every direction.
TEST(StartShape, ABendHasTheEnergyOfItsCurvature) {
  const double exact = 0.5 * 1e-2 * 0.3 * 0.2 / (0.5 * 0.5);
  for (const char* direction : {"0", "30", "90", "135"}) {
    const std::string bend =
        "{ bend_radius = 0.5, bend_direction_deg = " + std::string(direction) + " }";
    EXPECT_NEAR(strain_energy(plate(bend, 65, 97)), exact, 0.02 * exact) << direction;
  }
}

TEST(StartShape, TakesAnotherShapeOfTheSameImage) {
  const std::string sector =
      "{ shape = { type = \"cylinder\", radius = 0.1909859317, length = 0.2, angle_deg = 90, "
      "resolution = [9, 13] } }";
  const auto scene = build_scene(parse_case(plate(sector), "test.toml", {}));
  for (const Vec3& place : scene->initial_position)
    EXPECT_NEAR(std::hypot(place.x(), place.y()), 0.1909859317, 1e-12);
  const double exact = 0.5 * 1e-2 * 0.3 * 0.2 / (0.1909859317 * 0.1909859317);
  EXPECT_NEAR(strain_energy(plate(sector)), exact, 0.1 * exact);
}

// A flat pattern that begins curved springs back: it ends flat.
TEST(StartShape, SpringsBack) {
  Simulation simulation = simulation_of(plate("{ bend_radius = 0.2 }"),
                                        {"material.plate.mass_damping=30", "time.duration=3"});
  advance_to(simulation, 3);
  const std::vector<Vec3> places = simulation.position("plate");
  const Vec3 middle = mean_of(places);
  for (const Vec3& place : places) EXPECT_NEAR(place.z(), middle.z(), 2e-4);
}

TEST(StartShape, CheckSaysItsEnergy) {
  const auto scene = build_scene(parse_case(plate("{ bend_radius = 0.5 }"), "test.toml", {}));
  const std::string text = describe_scene(*scene);
  EXPECT_NE(text.find("start     strained: membrane "), std::string::npos) << text;
  const auto flat = build_scene(parse_case(sheet, "test.toml"));
  EXPECT_EQ(describe_scene(*flat).find("start "), std::string::npos);
}

class BadStart : public testing::TestWithParam<BadCase> {};
TEST_P(BadStart, IsRefused) { expect_refused(GetParam()); }
INSTANTIATE_TEST_SUITE_P(
    Cases, BadStart,
    testing::Values(
        BadCase{"empty", sheet + "start = {}\n",
                "case.toml:4:9: the start has no shape\n  expected \"shape\" or \"bend_radius\""},
        BadCase{"of_two_kinds",
                sheet + "start = { bend_radius = 1, shape = { type = \"sphere\", radius = 1, "
                        "resolution = [3] } }\n",
                "case.toml:4:28: \"shape\" does not go with \"bend_radius\"\n  expected only one "
                "of the two"},
        BadCase{"of_another_image",
                sheet + "start = { shape = { type = \"rectangle\", size = [1, 1], resolution = [5, "
                        "8] } }\n",
                "case.toml:4:19: the start has 5 x 8 vertices, the rest shape 5 x 9 vertices\n  "
                "expected a shape with as many rows, columns and patches as body.shape has"},
        BadCase{"of_no_radius", sheet + "start = { bend_radius = 0 }\n",
                "case.toml:4:25: a bend of radius 0\n  expected a number > 0, or < 0 to bend the "
                "borders downwards"},
        BadCase{"direction_alone",
                sheet + "start = { bend_direction_deg = 30, shape = { type = \"rectangle\", size = "
                        "[1, 1], resolution = [5, 9] } }\n",
                "case.toml:4:32: \"bend_direction_deg\" without a bend\n  expected \"bend_radius\" "
                "with it"},
        BadCase{"without_its_file",
                sheet +
                    "start = { shape = { type = \"file\", path = \"none.h5\", dataset = \"x\" } "
                    "}\n",
                "case.toml:4:43: no file \"none.h5\"\n  expected an HDF5 file, here none.h5"}),
    bad_case_name);

// Restarts, --resume and sweeps read the case that a trajectory stores, so it must be a valid one.
TEST(StartShape, OfAResolvedCaseIsReadAgain) {
  for (const char* start :
       {"start = { shape = { type = \"rectangle\", size = [2, 1], resolution = [5, 9] } }\n",
        "start = { bend_radius = 0.5 }\n",
        "start = { bend_radius = 0.5, bend_direction_deg = 30 }\n"}) {
    const std::string resolved = case_text(parse_case(sheet + start, "case.toml"));
    EXPECT_EQ(case_text(parse_case(resolved, "resolved.toml")), resolved);
  }
}

TEST(StartShape, RefusesAnImageThatIsClosedOtherwise) {
  const std::string text =
      "[[body]]\nname = \"tube\"\nshape = { type = \"cylinder\", radius = 0.1, length = 1, "
      "resolution = [5, 9] }\nstart = { shape = { type = \"rectangle\", size = [1, 1], resolution "
      "= [5, 9] } }\n";
  try {
    build_scene(parse_case(text, "case.toml"));
    FAIL() << "accepted";
  } catch (const CaseError& error) {
    EXPECT_STREQ(error.what(),
                 "case.toml:4:19: the image of this start is not like that of the rest shape of "
                 "\"tube\"\n  expected as many rows, columns and patches, closed and sewn alike");
  }
}

}  // namespace weft::sim::start_shape_test
