// From case to scene: shapes, masses, pins, motions, and errors that only the scene can find.
#include "sim/scene/scene.h"

#include <gtest/gtest.h>
#include <hdf5.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <numbers>
#include <sstream>

#include "sim/case/case_error.h"
#include "sim/case/case_reader.h"
#include "sim/view/scene_description.h"
#include "tests/temporary_folder.h"

namespace weft::sim::scene_test {
namespace {

std::unique_ptr<const Scene> scene_of(const std::string& body, const std::string& more = "") {
  return build_scene(parse_case(
      "[material.m]\ndensity = 0.5\n[[body]]\nname = \"b\"\n" + body + more, "test.toml"));
}

// Returns the number of bodies, other than obstacles, that are held as a whole.
std::ptrdiff_t held_bodies(const Scene& scene) {
  return std::ranges::count_if(
      scene.bodies, [](const SceneBody& body) { return !body.dynamic && !body.is_obstacle; });
}

double total_mass(const Scene& scene) {
  double sum = 0;
  for (double m : scene.mass) sum += m;
  return sum;
}

std::vector<int> pinned(const Scene& scene) {
  std::vector<int> particles;
  for (int i = 0; i < scene.dynamic_particles; ++i) {
    if (scene.pinned[i] != 0) particles.push_back(i);
  }
  return particles;
}

constexpr const char* small_sheet =
    "shape = { type = \"rectangle\", size = [2.0, 1.0], resolution = [3, 4] }\n";

TEST(Scene, MassIsDensityTimesArea) {
  EXPECT_NEAR(total_mass(*scene_of(small_sheet)), 1.0, 1e-12);
  const double sphere =
      total_mass(*scene_of("shape = { type = \"sphere\", radius = 0.5, resolution = [33] }\n"));
  EXPECT_NEAR(sphere, 0.5 * std::numbers::pi, 0.01);
}

TEST(Scene, PlacesBodiesByRotationThenTranslation) {
  const auto scene =
      scene_of(std::string("position = [1, 2, 3]\nrotation_deg = [0, 0, 90]\n") + small_sheet);
  // The first vertex of the sheet lies at (-1, -0.5, 0); after the rotation, at (0.5, -1, 0).
  EXPECT_LT((scene->initial_position[0] - Vec3(1.5, 1, 3)).norm(), 1e-12);
}

TEST(Scene, SelectsPinsByCornerEdgeRangeAndRegion) {
  const auto pins = [](const std::string& pin) {
    return pinned(*scene_of(small_sheet, "[[body.pin]]\n" + pin));
  };
  EXPECT_EQ(pins("corners = [\"first_last\", \"last_first\"]\n"), (std::vector<int>{3, 8}));
  EXPECT_EQ(pins("corners = [\"all\"]\n"), (std::vector<int>{0, 3, 8, 11}));
  EXPECT_EQ(pins("edges = [\"last_row\"]\n"), (std::vector<int>{8, 9, 10, 11}));
  EXPECT_EQ(pins("rows = [0, 1]\ncols = [-1, -1]\n"), (std::vector<int>{3, 7}));
  EXPECT_EQ(pins("rows = [1, 1]\n"), (std::vector<int>{4, 5, 6, 7}));
  EXPECT_EQ(pins("region_min = [-2, -1, -1]\nregion_max = [-0.9, 0.1, 1]\n"),
            (std::vector<int>{0, 4}));
}

// A rotation rounds positions to either side of the face that they lie on. A point that is farther
// from the box than rounding may move it is not held.
TEST(Scene, BoxesHoldRotatedPointsOnTheirFaces) {
  const auto held = [](int degrees, double height) {
    std::ostringstream body, pin;
    body << "rotation_deg = [" << degrees
         << ", 0, 0]\nshape = { type = \"rectangle\", size = [1, 0.8], resolution = [9, 9] }\n";
    pin << std::setprecision(17) << "[[body.pin]]\nregion_min = [-1, -1, " << height
        << "]\nregion_max = [1, 1, 2]\n";
    return pinned(*scene_of(body.str(), pin.str())).size();
  };
  for (const int degrees : {10, 20, 50, 70}) {
    for (int row = 0; row < 8; ++row) {
      const double height = (0.1 * row - 0.4) * std::sin(degrees * std::numbers::pi / 180);
      EXPECT_EQ(held(degrees, height), 9U * (9 - row)) << degrees << ", row " << row;
      EXPECT_EQ(held(degrees, height + 1e-6), 9U * (8 - row)) << degrees << ", row " << row;
    }
  }
}

TEST(Scene, RefusesPinsThatSelectNothingOrLieOutside) {
  const auto refused = [](const std::string& body, const std::string& pin) {
    EXPECT_THROW(scene_of(body, "[[body.pin]]\n" + pin), CaseError) << pin;
  };
  refused(small_sheet, "region_min = [5, 5, 5]\nregion_max = [6, 6, 6]\n");
  refused(small_sheet, "rows = [0, 3]\n");
  const std::string tube =
      "shape = { type = \"cylinder\", radius = 0.2, length = 1.0, resolution = [5, 8] }\n";
  refused(tube, "edges = [\"first_col\"]\n");  // its columns are closed
  EXPECT_EQ(pinned(*scene_of(tube, "[[body.pin]]\nedges = [\"first_row\"]\n")).size(), 8U);
}

// Writes a dataset [dimensions...] of float64.
void write_dataset(const std::string& path, std::vector<hsize_t> dimensions,
                   const std::vector<double>& values) {
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t space =
      H5Screate_simple(static_cast<int>(dimensions.size()), dimensions.data(), nullptr);
  const hid_t dataset =
      H5Dcreate2(file, "shape", H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  H5Dclose(dataset);
  H5Sclose(space);
  H5Fclose(file);
}

class SceneFile : public testing::Test {
 protected:
  std::unique_ptr<const Scene> scene_from(const std::string& shape) const {
    return build_scene(parse_case(
        "[[body]]\nname = \"b\"\nshape = { type = \"file\", path = \"scan.h5\", " + shape + " }\n",
        folder_.path("case.toml")));
  }
  TemporaryFolder folder_;
};

TEST_F(SceneFile, ReadsOnePatchAndSewsSeveral) {
  write_dataset(folder_.path("scan.h5"), {2, 3, 3},
                {0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1, 0});
  EXPECT_EQ(scene_from("dataset = \"shape\"")->particle_count, 6);
  // Two patches of 2 x 2 that share an edge.
  write_dataset(folder_.path("scan.h5"), {2, 2, 2, 3},
                {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 1, 0, 0, 2, 0, 0, 1, 1, 0, 2, 1, 0});
  const auto sewn = scene_from("dataset = \"shape\"");
  EXPECT_EQ(sewn->particle_count, 6);
  EXPECT_NEAR(total_mass(*sewn), 2 * sewn->bodies[0].material->density, 1e-12);
}

TEST_F(SceneFile, RefusesWhatIsNotASurface) {
  const std::vector<std::vector<double>> bad = {
      {0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0},             // no area
      {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, std::nan(""), 0},  // not finite
  };
  for (const std::vector<double>& values : bad) {
    write_dataset(folder_.path("scan.h5"), {2, 2, 3}, values);
    EXPECT_THROW(scene_from("dataset = \"shape\""), CaseError);
  }
  EXPECT_THROW(scene_from("dataset = \"nothing\""), CaseError);
  write_dataset(folder_.path("scan.h5"), {1, 4, 3}, std::vector<double>(12, 1.0));  // a 1 x n image
  EXPECT_THROW(scene_from("dataset = \"shape\""), CaseError);
}

void expect_said(const std::string& text, const std::vector<std::string>& parts) {
  for (const std::string& part : parts)
    EXPECT_NE(text.find(part), std::string::npos) << part << " in\n" << text;
}

std::string obstacle(const std::string& name, double height) {
  return "[[obstacle]]\nname = \"" + name + "\"\nposition = [0, 0, " + std::to_string(height) +
         "]\nshape = { type = \"sphere\", radius = 1.0, resolution = [5] }\n";
}

TEST(Scene, SaysWhatItNeedsAndSkips) {
  const std::string text =
      describe_scene(*scene_of("self_contact = false\n" + std::string(small_sheet),
                               obstacle("near", -1.01) + obstacle("far", -9)));
  expect_said(text, {"body      b: 3 x 4 vertices", "obstacle  near: 6 patches", "skipped bending",
                     "skipped drag", "skipped self-traversal of b", "skipped friction",
                     "skipped 1 pair of 2: too far apart at the start",
                     "pyramid built once of near: it does not move",
                     "skipped pyramid of far: at the start, nothing that it may touch is near",
                     "skipped frames of far: it does not move"});
  EXPECT_EQ(text.find("skipped pyramid of near"), std::string::npos) << text;
  EXPECT_EQ(text.find("skipped pyramid of b"), std::string::npos) << text;
}

// A sheet that starts deep within contact.range is thrown off; at the end of the range it is not.
TEST(Scene, SaysHowMuchEnergyContactHasAtTheStart) {
  const auto text_of = [](const std::string& height, const std::string& method) {
    return describe_scene(*build_scene(parse_case(
        "[contact]\nrange = 0.002\n[material.m]\n[[body]]\nname = \"b\"\nposition = [0, 0, " +
            height +
            "]\nshape = { type = \"rectangle\", size = [0.1, 0.1], resolution = [5, 5] }\n"
            "[[obstacle]]\nname = \"floor\"\nshape = { type = \"plane\", size = [1, 1] }\n",
        "test.toml", {"time.method=" + method})));
  };
  expect_said(
      text_of("0.0013", "cvode"),
      {"at the start the smallest gap is 0.3 mm, and contact has 0.0682",
       " J,\n  which throws the bodies apart: move them apart, or make contact.range smaller\n"});
  EXPECT_EQ(text_of("0.0013", "static").find("throws"), std::string::npos);
  const std::string near = text_of("0.00298", "cvode");
  expect_said(near, {"at the start the smallest gap is 1.98 mm, and contact has "});
  EXPECT_EQ(near.find("throws"), std::string::npos) << near;
  EXPECT_EQ(text_of("0.5", "cvode").find("smallest gap"), std::string::npos);
}

TEST(Scene, SaysNothingOfDistancesWhereAllIsNear) {
  const std::string text = describe_scene(*scene_of(small_sheet, obstacle("near", -1.01)));
  EXPECT_EQ(text.find("too far apart"), std::string::npos) << text;
  EXPECT_EQ(text.find("skipped pyramid"), std::string::npos) << text;
}

TEST(Scene, SummarisesThousandsOfObstaclesInALine) {
  std::string far;
  for (int i = 0; i < 1000; ++i) far += obstacle("far" + std::to_string(i), -9);
  const std::string text = describe_scene(*scene_of(small_sheet, far));
  expect_said(text,
              {"obstacles 992 more, far8 to far999", "skipped 1000 pairs of 1000",
               "skipped pyramid of 1000 surfaces, far0 to far999: at the start, nothing that they "
               "may touch is near\n",
               "skipped frames of 1000 surfaces, far0 to far999: they do not move and are "
               "written once\n"});
  EXPECT_LT(std::ranges::count(text, '\n'), 30) << text;
}

TEST(Scene, CountsOneInTheSingular) {
  std::string far;
  for (int i = 0; i < 9; ++i) far += obstacle("far" + std::to_string(i), -9);
  const std::string one_pin =
      std::string(small_sheet) + "[[body.pin]]\ncorners = [\"first_first\"]\n";
  const std::string text = describe_scene(*scene_of(one_pin, far));
  expect_said(text, {" kg, 1 pinned vertex\n", "obstacles 1 more, far8: "});
}

std::unique_ptr<const Scene> sheet_on_threads(int size, const std::string& threads) {
  return build_scene(
      parse_case("[compute]\n" + threads +
                     "\n[contact]\nenabled = false\n[material.m]\n[[body]]\nname = \"b\"\n" +
                     "shape = { type = \"rectangle\", size = [1, 1], resolution = [" +
                     std::to_string(size) + ", " + std::to_string(size) + "] }\n",
                 "test.toml"));
}

TEST(Scene, TakesAsManyThreadsAsPay) {
  EXPECT_EQ(sheet_on_threads(33, "")->threads, 1);  // 1089 vertices
  EXPECT_EQ(sheet_on_threads(33, "threads = \"auto\"")->threads, 1);
  EXPECT_EQ(sheet_on_threads(5, "threads = 3")->threads, 3);
  const int most = omp_get_max_threads();
  EXPECT_EQ(sheet_on_threads(129, "")->threads, std::min({16, omp_get_num_procs(), most}));
  omp_set_num_threads(1);  // as OMP_NUM_THREADS does
  EXPECT_EQ(sheet_on_threads(129, "")->threads, 1);
  EXPECT_EQ(sheet_on_threads(5, "threads = 3")->threads, 3);
  omp_set_num_threads(most);
}

// A free sheet, and one whose vertices are all pinned.
std::string two_sheets(const std::string& motion = "") {
  const std::string shape =
      "shape = { type = \"rectangle\", size = [1, 1], resolution = [4, 4] }\n";
  return "[material.cloth]\nbending_stiffness = 1e-4\n[[body]]\nname = \"held\"\n" + shape +
         "[[body.pin]]\nrows = [0, 3]\n" + motion +
         "[[body]]\nname = \"free\"\nposition = [3, 0, 0]\n" + shape;
}

TEST(Scene, ABodyHeldAsAWholeIsAnObstacle) {
  const auto scene = build_scene(parse_case(two_sheets(), "test.toml"));
  EXPECT_EQ(scene->dynamic_bodies, 1);
  EXPECT_EQ(held_bodies(*scene), 1);
  EXPECT_EQ(scene->dynamic_particles, 16);
  EXPECT_EQ(scene->mass.size(), 16U);
  EXPECT_EQ(scene->bodies[0].name, "free");
  EXPECT_EQ(scene->case_order, (std::vector<int>{1, 0}));
  EXPECT_TRUE(scene->prescribed.empty());
  EXPECT_FALSE(scene->bodies[1].dynamic || scene->bodies[1].moves || scene->bodies[1].is_obstacle);
  EXPECT_EQ(scene->describe_particle(16), "body \"held\", row 0, column 0");
  EXPECT_NEAR(scene->initial_position[0].x() - scene->initial_position[16].x(), 3, 1e-12);
  const std::string text = describe_scene(*scene);
  expect_said(text, {"skipped forces, matrix and state of held: all of it is pinned",
                     "all 16 vertices pinned", "skipped frames of held"});
  EXPECT_LT(text.find("body      held"), text.find("body      free")) << text;
}

TEST(Scene, ABodyThatOnePinCarriesMovesAsAnObstacle) {
  const auto scene =
      build_scene(parse_case(two_sheets("motion = { velocity = [0, 0, 1] }\n"), "test.toml"));
  ASSERT_EQ(held_bodies(*scene), 1);
  EXPECT_TRUE(scene->bodies[1].moves);
  ASSERT_EQ(scene->prescribed.size(), 1U);
  EXPECT_EQ(scene->prescribed[0].particles.front(), 16);
  EXPECT_EQ(scene->prescribed[0].particles.back(), 31);
}

TEST(Scene, BodiesThatMotionsDeformOrThatAreAllHeldStayDynamic) {
  const std::string two_pins =
      "cols = [0, 1]\n[[body.pin]]\ncols = [2, 3]\nmotion = { velocity = [0, 0, 1] }\n";
  EXPECT_EQ(held_bodies(*build_scene(parse_case(two_sheets(two_pins), "test.toml"))), 0);
  const std::string both = two_sheets() + "[[body.pin]]\nrows = [0, 3]\n";
  EXPECT_EQ(held_bodies(*build_scene(parse_case(both, "test.toml"))), 0);
}

TEST(Scene, RefusesAStartBeyondTheRangeOfNumbers) {
  const std::string rectangle =
      "shape = { type = \"rectangle\", size = [1, 1], resolution = [5, 5] }\n";
  const std::string floor = "[[obstacle]]\nname = \"floor\"\n" + rectangle;
  const auto message_of = [](const std::string& body, const std::string& more = "") {
    try {
      scene_of(body, more);
    } catch (const CaseError& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_EQ(message_of(rectangle + "position = [1e300, 0, 0]\n"),
            "test.toml:3:1: the start of \"b\" is beyond the range of numbers\n  expected a place "
            "within 1e150 m of the origin");
  EXPECT_EQ(message_of(rectangle, floor + "position = [0, -1e300, 0]\n"),
            "test.toml:6:1: the start of \"floor\" is beyond the range of numbers\n  expected a "
            "place within 1e150 m of the origin");
}

TEST(Scene, TakesNormalsOfAnyLength) {
  for (const char* length : {"1e200", "1e-200"}) {
    EXPECT_NO_THROW(build_scene(
        parse_case("[material.m]\nmodel = \"shell\"\nyoungs_modulus = 1e6\npoisson_ratio = 0\n"
                   "shell_thickness = 0.01\nvolume_density = 100\n[[body]]\nname = \"b\"\n"
                   "shape = { type = \"rectangle\", size = [1, 1], resolution = [5, 5] }\n"
                   "[[body.pin]]\nedges = [\"first_row\"]\nsymmetry_normal = [0, " +
                       std::string(length) + ", 0]\n",
                   "test.toml")))
        << length;
  }
}

TEST(Scene, SaysThatAnEquilibriumHasNoFriction) {
  const std::string text = describe_scene(*build_scene(parse_case(
      "[time]\nmethod = \"static\"\n[contact]\nfriction = 0.5\n[material.m]\n[[body]]\nname = "
      "\"b\"\nshape = { type = \"rectangle\", size = [1, 1], resolution = [9, 9] }\n"
      "[[body.pin]]\ncorners = [\"all\"]\n",
      "test.toml")));
  EXPECT_NE(text.find("skipped friction and contact damping"), std::string::npos) << text;
}

// The vertices of a cone are denser near its apex, so that their mean is not its centre of mass.
TEST(Scene, AnAngularVelocityGivesNoMomentum) {
  const auto scene = scene_of(
      "shape = { type = \"cone\", radius = 0.2, length = 0.4, resolution = [5] }\n"
      "position = [1, 2, 3]\nangular_velocity_deg = [60, 20, 0]\n");
  Vec3 momentum = Vec3::Zero();
  double speed = 0;
  for (int i = 0; i < scene->dynamic_particles; ++i) {
    momentum += scene->mass[i] * scene->initial_velocity(i);
    speed = std::max(speed, scene->initial_velocity(i).norm());
  }
  EXPECT_GT(speed, 0.1);
  EXPECT_LT(momentum.norm(), 1e-12 * total_mass(*scene) * speed);
}

}  // namespace
}  // namespace weft::sim::scene_test
