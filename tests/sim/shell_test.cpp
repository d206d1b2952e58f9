// Shells against closed forms and the benchmarks by which shell elements are judged.
#include <cmath>
#include <tuple>

#include "../reference_value.h"
#include "bench/end_load_elastica.h"
#include "shell_model.h"

namespace weft::sim::shell_test {
namespace {

constexpr const char* strip = "type = \"rectangle\", size = [10, 1], resolution = [4, ";

// Holds the first two columns of a strip: a clamp.
constexpr const char* clamped_first_column =
    "[[body.pin]]\nedges = [\"first_col\"]\nclamp = true\n";

TEST(ShellScene, HasTheMassOfItsSurface) {
  const ShellModel roof(shell_case(1e6, 0.3, 0.01,
                                   "type = \"cylinder\", radius = 2, length = 3, angle_deg = 90, "
                                   "resolution = [9, 17]"));
  double mass = 0;
  for (const double each : roof.scene().mass) {
    EXPECT_GT(each, 0);
    mass += each;
  }
  EXPECT_NEAR(mass, 1000 * 0.01 * 3 * std::acos(-1.0), 1e-4 * mass);
}

TEST(ShellScene, ImageIsTheSurfaceOrTheControlNet) {
  const std::string shape =
      "type = \"cylinder\", radius = 2, length = 3, angle_deg = 90, resolution = [9, 9]";
  const ShellModel through(shell_case(1e6, 0.3, 0.01, shape));
  const ShellModel net(shell_case(1e6, 0.3, 0.01, shape, "control_net = true\n"));
  const SplineAxis& u = through.body().spline->patches()[0].u;
  for (int c = 0; c < u.control_points(); ++c) {
    const Vec3 x = through.position(u.image_parameter(c), 1.5);
    EXPECT_NEAR(std::hypot(x.x(), x.y()), 2, 1e-12);
    const Vec3 y = net.x()[net.at(4, c)];
    EXPECT_NEAR(std::hypot(y.x(), y.y()), 2, 1e-12);
  }
}

TEST(ShellScene, ClampHoldsTwoRows) {
  const ShellModel beam(shell_case(1e6, 0, 0.1, std::string(strip) + "11]", clamped_first_column));
  int held = 0;
  for (int i = 0; i < beam.scene().dynamic_particles; ++i) held += !beam.scene().is_free(i);
  EXPECT_EQ(held, 8);
  EXPECT_FALSE(beam.scene().is_free(beam.at(2, 1)));
  EXPECT_TRUE(beam.scene().is_free(beam.at(2, 2)));
}

std::vector<int> held_by(const std::string& shape, const std::string& pin) {
  const ShellModel shell(shell_case(1e9, 0, 0.01, shape, "[[body.pin]]\n" + pin));
  std::vector<int> held;
  for (int i = 0; i < shell.scene().dynamic_particles; ++i) {
    if (!shell.scene().is_free(i)) held.push_back(i);
  }
  return held;
}

// Control points of the second column lie nearer to the border than its points of the surface: a
// box around the border that held them, too, would clamp a hinge. Those of a curved shell lie
// outside of it.
TEST(ShellScene, BoxesHoldPointsOfTheSurface) {
  const std::string plate = "type = \"rectangle\", size = [1, 0.2], resolution = [6, 10]";
  EXPECT_EQ(held_by(plate, "region_min = [-0.51, -1, -1]\nregion_max = [-0.44, 1, 1]\n"),
            held_by(plate, "edges = [\"first_col\"]\n"));
  const std::string roof =
      "type = \"cylinder\", radius = 1, length = 1, angle_deg = 90, resolution = [5, 7]";
  EXPECT_EQ(
      held_by(roof, "region_min = [0.706, 0.706, -0.001]\nregion_max = [0.708, 0.708, 0.001]\n"),
      held_by(roof, "rows = [2, 2]\ncols = [3, 3]\n"));
}

// Points of the surface are rounded sums over control points. Some lie outside of a box whose face
// holds them, by a rounding error.
TEST(ShellScene, BoxesHoldPointsOnTheirFaces) {
  for (const int points : {9, 21, 41}) {
    const std::string plate =
        "type = \"rectangle\", size = [1, 1], resolution = [5, " + std::to_string(points) + "]";
    for (const int quarters : {1, 2, 3}) {
      const std::string end = std::to_string(quarters * (points - 1) / 4),
                        face = std::to_string(-0.5 + 0.25 * quarters);
      EXPECT_EQ(held_by(plate, "region_min = [-1, -1, 0]\nregion_max = [" + face + ", 1, 0]\n"),
                held_by(plate, "cols = [0, " + end + "]\n"))
          << points << " points, box to " << face;
    }
  }
}

TEST(ShellScene, BoxesTiePointsOfTheSurface) {
  const ShellModel shell(
      shell_case(1e9, 0, 0.01, "type = \"rectangle\", size = [1, 0.2], resolution = [6, 10]",
                 "[[obstacle]]\nname = \"wall\"\nposition = [-2, 0, 0]\nshape = { type = "
                 "\"rectangle\", size = [1, 1], resolution = [3, 3] }\n[[tie]]\nbody = "
                 "\"shell\"\nto = \"wall\"\nregion_min = [-0.51, -1, -1]\nregion_max = "
                 "[-0.44, 1, 1]\n"));
  EXPECT_EQ(shell.scene().ties[0].springs.size(), 6U);
}

// The closed form against figures that were computed elsewhere.
TEST(EndLoadElastica, HasTheTipOfTheTable) {
  for (const int load : {1, 2, 3, 4}) {
    const bench::ElasticaTip tip = bench::end_load_elastica(load);
    const std::string name = "elastica_end_load_" + std::to_string(load);
    EXPECT_NEAR(tip.inward, reference_value(name + "_inward"), 1e-10);
    EXPECT_NEAR(tip.across, reference_value(name + "_across"), 1e-10);
  }
}

// Cantilever under a dead shear force at its end (Sze, Liu and Lo 2004, section 3.1), against the
// elastica at the 20 loads of their curve. Errors are relative to either displacement.
class EndShear : public testing::TestWithParam<std::pair<int, double>> {};
TEST_P(EndShear, FollowsTheElastica) {
  const auto& [columns, limit] = GetParam();
  ShellModel beam(shell_case(1.2e6, 0, 0.1, std::string(strip) + std::to_string(columns) + "]",
                             clamped_first_column));
  const double u = beam.length_u();
  for (int point = 1; point <= 20; ++point) {
    const double load = 0.2 * point;
    ShellModel::Loads loads = beam.no_load();
    const SplineAxis& v = beam.body().spline->patches()[0].v;
    for (const auto& [at, weight] : v.gauss_points(4))
      beam.add_force({0, u, at}, {0, 0, load * weight / beam.length_v()}, loads);
    ASSERT_GT(beam.solve(loads, 10), 0);
    const Vec3 tip = beam.position(u, beam.length_v() / 2);
    const bench::ElasticaTip exact = bench::end_load_elastica(load);
    EXPECT_NEAR((5 - tip.x()) / 10, exact.inward, limit * exact.inward) << load;
    EXPECT_NEAR(tip.z() / 10, exact.across, limit * exact.across) << load;
  }
}
INSTANTIATE_TEST_SUITE_P(All, EndShear, testing::Values(std::pair(11, 3e-3), std::pair(19, 1e-4)));

// The relative error of the displacement of a thin quarter arch (R = 1, h = 1e-3) that is clamped
// at one end, under a radial force P at the other. The exact displacement is pi P R^3 / (4 E I).
double error_of_arch(int degree, int columns) {
  constexpr double youngs_modulus = 1e9, thickness = 1e-3, width = 0.1;
  std::string text = shell_case(youngs_modulus, 0, thickness,
                                "type = \"cylinder\", radius = 1, length = 0.1, angle_deg = 90, "
                                "resolution = [4, " +
                                    std::to_string(columns) + "]",
                                clamped_first_column);
  const std::string model = "model = \"shell\"\n";
  text.insert(text.find(model) + model.size(), "spline_degree = " + std::to_string(degree) + "\n");
  ShellModel arch(text);
  const double rigidity = youngs_modulus * width * std::pow(thickness, 3) / 12;
  constexpr double exact = 1e-6;
  const double force = exact * rigidity * 4 / std::acos(-1.0);
  const double end = arch.length_u(), middle = arch.length_v() / 2;
  const Vec3 before = arch.position(end, middle);
  const Vec3 radial = Vec3(before.x(), before.y(), 0).normalized();
  ShellModel::Loads loads = arch.no_load();
  const SplineAxis& v = arch.body().spline->patches()[0].v;
  for (const auto& [at, weight] : v.gauss_points(4))
    arch.add_force({0, end, at}, force * weight / arch.length_v() * radial, loads);
  EXPECT_GT(arch.solve(loads, 1), 0);
  return std::abs((arch.position(end, middle) - before).dot(radial) / exact - 1);
}

// The table of docs/theory.md, and the advice of the guide: cubic shells are a hundred times as
// exact as quadratic ones of the same image, or more.
TEST(Arch, CubicShellsAreAHundredTimesAsExact) {
  for (const auto& [columns, quadratic, cubic] :
       {std::tuple{9, 3.0e-2, 3.0e-4}, std::tuple{17, 6.4e-3, 1.3e-5}}) {
    const double of_quadratic = error_of_arch(2, columns), of_cubic = error_of_arch(3, columns);
    EXPECT_NEAR(of_quadratic, quadratic, 0.1 * quadratic);
    EXPECT_NEAR(of_cubic, cubic, 0.3 * cubic);
    EXPECT_GE(of_quadratic, 95 * of_cubic);
  }
}

// A sheet clamped at one edge that sags under its own weight.
struct Sagging {
  int columns;
  const char* gamma;  // weight per area L^3 / D
  double limit;
};
class HeavyElastica : public testing::TestWithParam<Sagging> {};
TEST_P(HeavyElastica, SagsAsTheElastica) {
  const auto& [columns, gamma, limit] = GetParam();
  constexpr double thickness = 1e-3, youngs_modulus = 1e9;
  ShellModel sheet(shell_case(
      youngs_modulus, 0, thickness,
      "type = \"rectangle\", size = [1, 0.1], resolution = [4, " + std::to_string(columns) + "]",
      clamped_first_column));
  const double rigidity = youngs_modulus * std::pow(thickness, 3) / 12;
  const double weight = std::stod(gamma) * rigidity;  // per area
  constexpr int steps = 40;
  for (int step = 1; step <= steps; ++step) {
    ShellModel::Loads loads = sheet.no_load();
    for (std::size_t i = 0; i < sheet.x().size(); ++i)
      loads[static_cast<Eigen::Index>(3 * i + 2)] =
          -std::pow(1.0 * step / steps, 3) * weight * sheet.scene().mass[i] / (1000 * thickness);
    ASSERT_GT(sheet.solve(loads, 1), 0);
  }
  const Vec3 tip = sheet.position(sheet.length_u(), sheet.length_v() / 2);
  const std::string name = std::string("heavy_elastica_") + gamma;
  EXPECT_NEAR(-tip.z(), reference_value(name + "_drop"), limit * reference_value(name + "_drop"));
  EXPECT_NEAR(tip.x() + 0.5, reference_value(name + "_reach"),
              limit * reference_value(name + "_reach"));
}
INSTANTIATE_TEST_SUITE_P(All, HeavyElastica,
                         testing::Values(Sagging{35, "1", 5e-4}, Sagging{35, "10", 5e-4},
                                         Sagging{35, "100", 5e-4}, Sagging{67, "1000", 2e-3}));

// Makes a border a plane of symmetry: its own control points keep their coordinate `normal`, and
// the next ones the other two coordinates of their neighbours.
template <class Border, class Next>
void mirror(ShellModel& model, int count, int normal, double stiffness, const Border& border,
            const Next& next) {
  for (int i = 0; i < count; ++i) {
    model.hold(border(i), {normal});
    for (int axis = 0; axis < 3; ++axis) {
      if (axis != normal) model.tie(border(i), next(i), axis, stiffness);
    }
  }
}
void mirror_column(ShellModel& model, int column, int normal, double stiffness) {
  mirror(
      model, model.body().atlas.patches()[0].rows, normal, stiffness,
      [&](int row) { return model.at(row, column); },
      [&](int row) { return model.at(row, column == 0 ? 1 : column - 1); });
}
void mirror_row(ShellModel& model, int row, int normal, double stiffness) {
  mirror(
      model, model.body().atlas.patches()[0].cols, normal, stiffness,
      [&](int column) { return model.at(row, column); },
      [&](int column) { return model.at(row == 0 ? 1 : row - 1, column); });
}

struct Benchmark {
  int points;
  double limit;
};

// Scordelis-Lo roof: a quarter, with a diaphragm below, symmetry above and at the ridge.
class ScordelisLo : public testing::TestWithParam<Benchmark> {};
TEST_P(ScordelisLo, SagsByTheLimitOfThinShells) {
  const auto& [n, limit] = GetParam();
  const std::string resolution = std::to_string(n) + ", " + std::to_string(n) + "]";
  ShellModel roof(
      shell_case(4.32e8, 0, 0.25,
                 "type = \"cylinder\", radius = 25, length = 25, angle_deg = 40, resolution = [" +
                     resolution));
  for (int c = 0; c < n; ++c) roof.hold(roof.at(0, c), {0, 1});
  mirror_row(roof, -1, 2, 1e12);
  mirror_column(roof, 0, 1, 1e12);
  constexpr double small = 1e-4;
  ShellModel::Loads loads = roof.no_load();
  for (std::size_t i = 0; i < roof.x().size(); ++i)
    loads[static_cast<Eigen::Index>(3 * i)] = -small * 90 * roof.scene().mass[i] / (1000 * 0.25);
  const double before = roof.x()[roof.at(-1, -1)].x();
  ASSERT_GT(roof.solve(loads, 25), 0);
  const double expected = reference_value("scordelis_lo_thin_shell");
  EXPECT_NEAR((before - roof.x()[roof.at(-1, -1)].x()) / small, expected, limit * expected);
}
INSTANTIATE_TEST_SUITE_P(All, ScordelisLo,
                         testing::Values(Benchmark{9, 1e-3}, Benchmark{17, 2e-4}));

// Cylinder between diaphragms, pinched by two forces: an octant.
class PinchedCylinder : public testing::TestWithParam<Benchmark> {};
TEST_P(PinchedCylinder, YieldsUnderTheLoad) {
  const auto& [n, limit] = GetParam();
  const std::string resolution = std::to_string(n) + ", " + std::to_string(n) + "]";
  ShellModel octant(
      shell_case(3e6, 0.3, 3,
                 "type = \"cylinder\", radius = 300, length = 300, angle_deg = 90, resolution = [" +
                     resolution));
  for (int c = 0; c < n; ++c) octant.hold(octant.at(0, c), {0, 1});
  mirror_row(octant, -1, 2, 1e11);
  mirror_column(octant, 0, 1, 1e11);
  mirror_column(octant, -1, 0, 1e11);
  ShellModel::Loads loads = octant.no_load();
  const int loaded = octant.at(-1, 0);
  loads[3 * loaded] = -0.25;
  const double before = octant.x()[loaded].x();
  ASSERT_GT(octant.solve(loads, 300), 0);
  const double expected = reference_value("pinched_cylinder");
  EXPECT_NEAR(before - octant.x()[loaded].x(), expected, limit * expected);
}
INSTANTIATE_TEST_SUITE_P(All, PinchedCylinder,
                         testing::Values(Benchmark{17, 2e-2}, Benchmark{33, 3e-3}));

// Hemisphere with a hole of 18 degrees, pulled and pushed at its equator: a quarter.
class Hemisphere : public testing::TestWithParam<int> {
 protected:
  Hemisphere() : model_(shell_case(6.825e7, 0.3, 0.04, shape())) {
    mirror_column(model_, 0, 1, 1e10);
    mirror_column(model_, -1, 0, 1e10);
    model_.hold(model_.at(-1, 0), {2});
  }
  static std::string shape() {
    const std::string n = std::to_string(GetParam());
    return "type = \"sphere_sector\", radius = 10, latitude_deg = [0, 72], angle_deg = 90, "
           "resolution = [" +
           n + ", " + n + "]";
  }
  // Displacements outwards and inwards under a load on each point (of a quarter, N).
  std::array<double, 2> displacements(double load) {
    const int out = model_.at(0, 0), in = model_.at(0, -1);
    ShellModel::Loads loads = model_.no_load();
    loads[3 * out] = load;
    loads[3 * in + 1] = -load;
    EXPECT_GT(model_.solve(loads, 10), 0);
    return {model_.x()[out].x() - 10, 10 - model_.x()[in].y()};
  }
  ShellModel model_;
};

using LinearHemisphere = Hemisphere;
TEST_P(LinearHemisphere, YieldsUnderASmallLoad) {
  const auto [out, in] = displacements(1e-3);
  const double expected = reference_value("hemisphere_with_hole_linear");
  EXPECT_NEAR(out / 1e-3, expected, 3e-3 * expected);
  EXPECT_NEAR(in / 1e-3, expected, 3e-3 * expected);
}
INSTANTIATE_TEST_SUITE_P(All, LinearHemisphere, testing::Values(17));

using LoadedHemisphere = Hemisphere;
TEST_P(LoadedHemisphere, YieldsUnderTheFullLoad) {
  std::array<double, 2> reached{};
  for (int step = 1; step <= 8; ++step) reached = displacements(25 * step);
  const double limit = 3e-2;  // `weft bench shells` has the errors of finer images
  EXPECT_NEAR(reached[0], reference_value("hemisphere_full_load_outward"),
              limit * reference_value("hemisphere_full_load_outward"));
  EXPECT_NEAR(reached[1], reference_value("hemisphere_full_load_inward"),
              limit * reference_value("hemisphere_full_load_inward"));
}
INSTANTIATE_TEST_SUITE_P(All, LoadedHemisphere, testing::Values(16));

}  // namespace
}  // namespace weft::sim::shell_test
