// Patches of shells that meet: where they do, and that they bend as one surface.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "../reference_value.h"
#include "joint_cases.h"
#include "shell_model.h"
#include "sim/scene/patch_joints.h"
#include "tests/dense_algebra.h"

namespace weft::sim::shell_joint_test {
namespace {

TEST(PatchJoints, AreTheSharedBorders) {
  EXPECT_TRUE(find_patch_joints(bsi::make_rectangle(1, 1, 4, 5).atlas).empty());
  EXPECT_TRUE(find_patch_joints(bsi::make_torus(2, 1, 5, 5).atlas).empty());
  EXPECT_EQ(find_patch_joints(bsi::make_sphere(1, 4).atlas).size(), 12U);
  EXPECT_EQ(find_patch_joints(bsi::make_box({1, 1, 1}, {5, 5, 5}).atlas).size(), 12U);
  // Twelve patches with 48 borders, of which eight lie on the rim.
  EXPECT_EQ(find_patch_joints(bsi::make_disc(1, 4).atlas).size(), 20U);
  EXPECT_EQ(
      find_patch_joints(bsi::cut_into_patches(bsi::make_torus(2, 1, 8, 8), 2, 2).atlas).size(), 8U);
}

// The control points beside a border lie in the same order as those on it, in both patches.
TEST(PatchJoints, HaveTheirNeighboursInOrder) {
  for (const bsi::Surface& surface :
       {bsi::make_sphere(1, 5), bsi::make_disc(1, 5),
        bsi::cut_into_patches(bsi::make_cylinder(1, 2, 9, 12), 2, 3),
        bsi::cut_into_patches(bsi::make_cylinder(1, 2, 9, 12), 2, 1)}) {
    for (const PatchJoint& joint : find_patch_joints(surface.atlas)) {
      for (std::size_t i = 0; i < joint.border.size(); ++i) {
        const auto distance = [&](int particle) {
          return (surface.positions[particle] - surface.positions[joint.border[i]]).norm();
        };
        EXPECT_GT(distance(joint.first[i]), 0);
        EXPECT_GT(distance(joint.second[i]), 0);
        EXPECT_LT(distance(joint.first[i]), 0.6);
        EXPECT_LT(distance(joint.second[i]), 0.6);
        EXPECT_NE(joint.first[i], joint.second[i]);
      }
    }
  }
}

// Patches with closed borders that begin at different control points.
TEST(PatchJoints, MeetAtClosedBordersThatAreTurned) {
  std::vector<int> particles{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
  std::vector<int> turned{10, 11, 8, 9, 14, 15, 12, 13, 18, 19, 16, 17};
  particles.insert(particles.end(), turned.begin(), turned.end());
  const bsi::Patch patch{3, 4, true, false};
  const std::vector<PatchJoint> joints = find_patch_joints(bsi::Atlas({patch, patch}, particles));
  ASSERT_EQ(joints.size(), 1U);
  EXPECT_TRUE(joints[0].is_closed);
  EXPECT_EQ(joints[0].border, (std::vector<int>{8, 9, 10, 11}));
  EXPECT_EQ(joints[0].first, (std::vector<int>{4, 5, 6, 7}));
  EXPECT_EQ(joints[0].second, (std::vector<int>{12, 13, 14, 15}));
}

TEST(PatchJoints, RefuseAPartOfABorder) {
  EXPECT_THROW(find_patch_joints(bsi::make_blob(1, 4).atlas), std::invalid_argument);
  try {
    build_scene(parse_case(
        shell_case(1e6, 0.3, 0.01, "type = \"blob\", radius = 1, resolution = [4]"), "test.toml"));
    FAIL();
  } catch (const CaseError& error) {
    EXPECT_STREQ(
        error.what(),
        "test.toml:11:9: the patches of \"shell\" do not meet: patch 0 shares a part of its "
        "border first_row with another patch\n"
        "  expected patches that share whole borders, with the same control points");
  }
}

std::string with_degree(std::string text, int degree, const std::string& more = "") {
  const std::string key = "volume_density = 1000\n";
  return text.replace(text.find(key), key.size(),
                      key + "spline_degree = " + std::to_string(degree) + "\n" + more);
}

class ShellOfDegree : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(All, ShellOfDegree, testing::Values(2, 3));

// Elements and joints, with damping that does not vary.
TEST_P(ShellOfDegree, ForcesAndMatricesAgreeWithTheEnergy) {
  const std::string text =
      "[world]\ngravity = [0, 0, 0]\n" +
      with_degree(shell_case(1e3, 0.3, 0.1,
                             "type = \"cylinder\", radius = 1, length = 2, "
                             "angle_deg = 200, resolution = [9, 9], "
                             "patches = [2, 2]"),
                  GetParam(), "stiffness_damping = 0.01\nbending_damping = 0.02\n");
  expect_consistent_forces(text, 0);
}

int zero_directions(const ShellModel& model) {
  const Eigen::VectorXd values = eigenvalues(model.tangent());
  return static_cast<int>((values.array() < 1e-11 * values.maxCoeff()).count());
}

// A shell without supports has six motions without energy, those of a rigid body, whatever its
// size: no wave goes unseen by the points of quadrature.
TEST_P(ShellOfDegree, OnlyRigidMotionsAreFree) {
  const int degree = GetParam();
  for (const double poisson_ratio : {0.0, 0.3}) {
    const auto expect_six = [&](const std::string& shape) {
      const ShellModel model(with_degree(shell_case(1, poisson_ratio, 0.01, shape), degree));
      EXPECT_EQ(zero_directions(model), 6) << shape << ", " << poisson_ratio;
    };
    for (int rows = degree + 1; rows <= degree + 4; ++rows) {
      for (const int cols : {degree + 1, degree + 2, degree + 3, degree + 4}) {
        const std::string resolution =
            "resolution = [" + std::to_string(rows) + ", " + std::to_string(cols) + "]";
        expect_six("type = \"rectangle\", size = [1, 1.3], " + resolution);
        expect_six("type = \"cylinder\", radius = 1, length = 1, angle_deg = 70, " + resolution);
        expect_six("type = \"cylinder\", radius = 1, length = 1, " + resolution);
        expect_six("type = \"torus\", major_radius = 1, minor_radius = 0.3, " + resolution);
      }
    }
  }
}

// Flat patches with joints do not fold along them.
TEST_P(ShellOfDegree, JoinedPatchesDoNotFold) {
  for (const char* shape :
       {"type = \"rectangle\", size = [1, 1.3], resolution = [9, 9], patches = [2, 2]",
        "type = \"disc\", radius = 1, resolution = [4]",
        "type = \"box\", size = [1, 1, 1], resolution = [5, 5, 5]"}) {
    const ShellModel model(with_degree(shell_case(1, 0.3, 0.05, shape), GetParam()));
    EXPECT_EQ(zero_directions(model), 6) << shape;
  }
}

// A quarter of a circle, clamped at one end, under a force along the radius at the other. A thin
// arch does not stretch: its end moves by pi / 4 P R^3 / (E I).
TEST_P(ShellOfDegree, ThinArchBendsWithoutStretching) {
  constexpr double thickness = 1e-3, width = 0.2, youngs_modulus = 1e9;
  ShellModel arch(with_degree(shell_case(youngs_modulus, 0, thickness,
                                         "type = \"cylinder\", radius = 1, length = 0.2, "
                                         "angle_deg = 90, resolution = [4, 33]",
                                         "[[body.pin]]\nedges = [\"first_col\"]\nclamp = true\n"),
                              GetParam()));
  const double inertia = width * std::pow(thickness, 3) / 12;
  const double small = 1e-4 * youngs_modulus * inertia;
  ShellModel::Loads loads = arch.no_load();
  for (const auto& [at, weight] : arch.body().spline->patches()[0].v.gauss_points(4))
    arch.add_force({0, arch.length_u(), at}, {0, weight / arch.length_v() * small, 0}, loads);
  const double before = arch.position(arch.length_u(), 0.5).y();
  ASSERT_GT(arch.solve(loads, 1), 0);
  const double moved = (arch.position(arch.length_u(), 0.5).y() - before) / 1e-4;
  const double expected = std::acos(-1.0) / 4;
  EXPECT_NEAR(moved, expected, (GetParam() == 2 ? 3e-3 : 2e-4) * expected);
}

// A strip of 1 m in eight patches, clamped at one end, under a small force P per width at the
// other: its end moves by P L^3 / 3 D. The joints add 2.7e-4 of it, as much as strips of a
// thousandth of the elements' width bend. Borders of few control points must not turn about each
// other.
TEST_P(ShellOfDegree, StripOfPatchesBendsAsOneForAnyWidthOfItsBorders) {
  constexpr double thickness = 0.01, width = 0.1, youngs_modulus = 1e9, force = 1e-3;
  const int degree = GetParam();
  for (int rows = degree + 1; rows <= degree + 5; ++rows) {
    ShellModel strip(with_degree(
        shell_case(youngs_modulus, 0, thickness,
                   "type = \"rectangle\", size = [1, 0.1], resolution = [" + std::to_string(rows) +
                       ", 41], patches = [1, 8]",
                   "[[body.pin]]\nregion_min = [-0.501, -1, -1]\nregion_max = [-0.499, 1, 1]\n"
                   "clamp = true\n"),
        degree));
    const SceneBody& body = strip.body();
    const auto& [u, v] = body.spline->patches()[7];
    const auto end = static_cast<double>(u.elements());
    ShellModel::Loads loads = strip.no_load();
    for (const auto& [at, weight] : v.gauss_points(2))
      strip.add_force({7, end, at}, {0, 0, force * weight / v.elements()}, loads);
    ASSERT_GT(strip.solve(loads, 1), 0);
    const double moved =
        body.spline->at(body.atlas, {7, end, 0.5 * v.elements()}).position(strip.x()).z();
    const double expected = 4 * force / (youngs_modulus * width * std::pow(thickness, 3));
    EXPECT_NEAR(moved, expected, 1e-3 * expected) << rows;
  }
}

// Hemisphere with a hole of 18 degrees, pulled and pushed at its equator: a quarter, of one patch
// or several.
class PatchedHemisphere {
 public:
  PatchedHemisphere(int degree, int points, int patches)
      : model_(with_degree(shell_case(6.825e7, 0.3, 0.04, shape(points, patches)), degree)) {
    const bsi::Atlas& atlas = model_.body().atlas;
    const int last = static_cast<int>(atlas.patches()[0].cols) - 1;
    for (int p = 0; p < static_cast<int>(atlas.patches().size()); ++p) {
      if (p % patches == 0) mirror_column(p, 0, 1, 1);
      if (p % patches == patches - 1) mirror_column(p, last, last - 1, 0);
    }
    model_.hold(atlas.particle(patches * (patches - 1), atlas.patches()[0].rows - 1, 0), {2});
  }
  // The mean displacement of both loaded points under a small load, for the unit load.
  double displacement() {
    const bsi::Atlas& atlas = model_.body().atlas;
    const bsi::Patch& patch = atlas.patches()[0];
    const int patches = static_cast<int>(std::lround(std::sqrt(atlas.patches().size())));
    const int out = atlas.particle(0, 0, 0), in = atlas.particle(patches - 1, 0, patch.cols - 1);
    ShellModel::Loads loads = model_.no_load();
    loads[3 * out] = 1e-3;
    loads[3 * in + 1] = -1e-3;
    EXPECT_GT(model_.solve(loads, 10), 0);
    return 0.5 * (model_.x()[out].x() - model_.x()[in].y()) / 1e-3;
  }

 private:
  static std::string shape(int points, int patches) {
    const std::string n = std::to_string(points), m = std::to_string(patches);
    return "type = \"sphere_sector\", radius = 10, latitude_deg = [0, 72], angle_deg = 90, "
           "resolution = [" +
           n + ", " + n + "], patches = [" + m + ", " + m + "]";
  }
  void mirror_column(int patch, int column, int next, int normal) {
    const bsi::Atlas& atlas = model_.body().atlas;
    for (int row = 0; row < atlas.patches()[patch].rows; ++row) {
      const int on = atlas.particle(patch, row, column), beside = atlas.particle(patch, row, next);
      model_.hold(on, {normal});
      for (int axis = 0; axis < 3; ++axis) {
        if (axis != normal) model_.tie(on, beside, axis, 1e10);
      }
    }
  }

  ShellModel model_;
};

TEST_P(ShellOfDegree, HemisphereOfFourPatchesBendsAsOne) {
  const double one = PatchedHemisphere(GetParam(), 25, 1).displacement();
  const double four = PatchedHemisphere(GetParam(), 25, 2).displacement();
  EXPECT_NEAR(four, one, 1e-3 * one);
  const double expected = reference_value("hemisphere_with_hole_linear");
  EXPECT_NEAR(four, expected, 5e-3 * expected);
}

// Patches that meet at an angle keep it: the faces of a closed box under pressure bend as if their
// edges were clamped.
TEST_P(ShellOfDegree, PatchesKeepTheAngleBetweenThem) {
  const std::string image = GetParam() == 3 ? "[9, 9, 9]" : "[17, 17, 17]";
  ShellModel box(with_degree(
      shell_case(1e6, 0, 0.01, "type = \"box\", size = [1, 1, 1], resolution = " + image),
      GetParam()));
  const SceneBody& body = box.body();
  ShellModel::Loads loads = box.no_load();
  for (int p = 0; p < 6; ++p) {
    const auto& [u, v] = body.spline->patches()[p];
    for (const auto& [at_v, weight_v] : v.gauss_points(2)) {
      for (const auto& [at_u, weight_u] : u.gauss_points(2)) {
        const SplineSurface::Point point = body.spline->at(body.atlas, {p, at_u, at_v});
        const Vec3 area = point.tangent_u(body.rest).cross(point.tangent_v(body.rest));
        box.add_force({p, at_u, at_v}, 1e-4 * weight_u * weight_v * area, loads);
      }
    }
  }
  ASSERT_GT(box.solve(loads, 1), 0);
  // A square plate with clamped edges sags by 0.00126532 q a^4 / D (Timoshenko and
  // Woinowsky-Krieger 1959, table 35).
  const double rigidity = 1e6 * 1e-6 / 12;
  const SplineSurface::Point middle =
      body.spline->at(body.atlas, {0, box.length_u() / 2, box.length_v() / 2});
  const Vec3 moved = middle.position(box.x()) - middle.position(body.rest);
  const double expected = 0.00126532 * 1e-4 / rigidity;
  EXPECT_NEAR(moved.norm(), expected, 0.02 * expected);
}

// A ring of one closed patch, pinched by two opposite forces, gives way by (pi / 4 - 2 / pi) F R^3
// / (E I).
TEST_P(ShellOfDegree, ClosedRingGivesWayWhenPinched) {
  constexpr double thickness = 5e-3, width = 0.1, youngs_modulus = 1e9;
  ShellModel ring(with_degree(shell_case(youngs_modulus, 0, thickness,
                                         "type = \"cylinder\", radius = 1, length = 0.1, "
                                         "resolution = [4, 32]"),
                              GetParam()));
  const double stiffness = youngs_modulus * width * std::pow(thickness, 3) / 12;
  const SplineAxis& u = ring.body().spline->patches()[0].u;
  const std::array<int, 4> points{0, 8, 16, 24};
  ShellModel::Loads loads = ring.no_load();
  const auto place = [&](int i, double v) { return Vec3(ring.position(u.image_parameter(i), v)); };
  for (const auto& [at, weight] : ring.body().spline->patches()[0].v.gauss_points(4)) {
    const double part = 1e-4 * stiffness * weight / ring.length_v();
    ring.add_force({0, u.image_parameter(points[0]), at}, {-part, 0, 0}, loads);
    ring.add_force({0, u.image_parameter(points[2]), at}, {part, 0, 0}, loads);
  }
  // Three points of the ring hold it as a rigid body.
  const int a = ring.at(0, 0), b = ring.at(0, 8);
  ring.hold(a, {2});
  ring.hold(b, {2, 0});
  ring.hold(ring.at(0, 16), {2, 1});
  ring.hold(a, {1});
  const double before = (place(0, 0.5) - place(16, 0.5)).norm();
  ASSERT_GT(ring.solve(loads, 1), 0);
  const double nearer = (before - (place(0, 0.5) - place(16, 0.5)).norm()) / 1e-4;
  const double pi = std::acos(-1.0);
  EXPECT_NEAR(nearer, pi / 4 - 2 / pi, (GetParam() == 2 ? 2e-2 : 2e-3) * (pi / 4 - 2 / pi));
}

}  // namespace
}  // namespace weft::sim::shell_joint_test
