#include "bsi/shapes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <ostream>
#include <stdexcept>
#include <string>

namespace weft::bsi::shapes_test {
namespace {

constexpr double kPi = std::numbers::pi;

Vec3 area_vector(const Surface& surface, const std::array<int, 3>& corner) {
  const Vec3& origin = surface.positions[corner[0]];
  return 0.5 * (surface.positions[corner[1]] - origin).cross(surface.positions[corner[2]] - origin);
}

double area(const Surface& surface) {
  double sum = 0;
  for (const auto& corner : build_mesh(surface.atlas).triangles) {
    sum += area_vector(surface, corner).norm();
  }
  return sum;
}

// Volume inside a closed surface; negative if its normals point inwards (divergence theorem).
double volume(const Surface& surface) {
  double sum = 0;
  for (const auto& corner : build_mesh(surface.atlas).triangles) {
    sum += surface.positions[corner[0]].dot(area_vector(surface, corner)) / 3;
  }
  return sum;
}

int euler_characteristic(const Surface& surface) {
  const Mesh mesh = build_mesh(surface.atlas);
  return surface.atlas.particle_count() - static_cast<int>(mesh.edges.size()) +
         static_cast<int>(mesh.triangles.size());
}

int border_edges(const Surface& surface) {
  const Mesh mesh = build_mesh(surface.atlas);
  return static_cast<int>(
      std::ranges::count_if(mesh.edges, [](const Edge& edge) { return edge.triangle[1] < 0; }));
}

// Checks that every triangle faces the vector that `outwards` gives at its place.
template <typename Outwards>
void expect_facing(const Surface& surface, Outwards outwards) {
  for (const auto& corner : build_mesh(surface.atlas).triangles) {
    const Vec3 middle = (surface.positions[corner[0]] + surface.positions[corner[1]] +
                         surface.positions[corner[2]]) /
                        3;
    EXPECT_GT(area_vector(surface, corner).dot(outwards(middle)), 0);
  }
}

TEST(Shapes, RectangleLiesCentredInThePlane) {
  const Surface surface = make_rectangle(2.0, 0.5, 4, 7);
  EXPECT_EQ(surface.positions.size(), 28U);
  EXPECT_TRUE(surface.positions.front().isApprox(Vec3(-1.0, -0.25, 0)));
  EXPECT_TRUE(surface.positions.back().isApprox(Vec3(1.0, 0.25, 0)));
  EXPECT_NEAR(area(surface), 1.0, 1e-14);
  EXPECT_EQ(euler_characteristic(surface), 1);
  expect_facing(surface, [](const Vec3&) -> Vec3 { return Vec3::UnitZ(); });
}

TEST(Shapes, CylinderIsAPrismOfItsColumns) {
  const Surface surface = make_cylinder(0.3, 1.5, 5, 12);
  EXPECT_NEAR(area(surface), 12 * 2 * 0.3 * std::sin(kPi / 12) * 1.5, 1e-13);
  EXPECT_EQ(euler_characteristic(surface), 0);
  EXPECT_EQ(border_edges(surface), 24);
  expect_facing(surface, [](const Vec3& p) -> Vec3 { return Vec3(p.x(), p.y(), 0); });
  EXPECT_DOUBLE_EQ(surface.positions.front().z(), -0.75);
  EXPECT_DOUBLE_EQ(surface.positions.back().z(), 0.75);
}

TEST(Shapes, TorusConvergesToItsAreaAndVolume) {
  const Surface surface = make_torus(1.0, 0.25, 160, 80);
  EXPECT_NEAR(area(surface), 4 * kPi * kPi * 0.25, 4 * kPi * kPi * 0.25 * 1e-3);
  EXPECT_NEAR(volume(surface), 2 * kPi * kPi * 0.0625, 2 * kPi * kPi * 0.0625 * 2e-3);
  EXPECT_EQ(euler_characteristic(surface), 0);
  EXPECT_EQ(border_edges(surface), 0);
  expect_facing(surface,
                [](const Vec3& p) -> Vec3 { return p - Vec3(p.x(), p.y(), 0).normalized(); });
}

TEST(Shapes, SphereIsSewnAndFacesOutwards) {
  for (const int n : {2, 3, 6, 13}) {
    const Surface surface = make_sphere(0.7, n);
    EXPECT_EQ(surface.atlas.particle_count(), 6 * (n - 1) * (n - 1) + 2);
    EXPECT_EQ(euler_characteristic(surface), 2);
    EXPECT_EQ(border_edges(surface), 0);
    expect_facing(surface, [](const Vec3& p) -> Vec3 { return p; });
    for (const Vec3& position : surface.positions) EXPECT_NEAR(position.norm(), 0.7, 1e-15);
  }
}

TEST(Shapes, BlobIsSewnFrom48PatchesAndFacesOutwards) {
  for (const int n : {2, 3, 6}) {
    const Surface surface = make_blob(0.7, n);
    EXPECT_EQ(surface.atlas.patches().size(), 48U);
    for (const Patch& patch : surface.atlas.patches()) {
      EXPECT_EQ(patch.rows, 2 * n - 1);
      EXPECT_EQ(patch.cols, n);
    }
    EXPECT_EQ(euler_characteristic(surface), 2);
    EXPECT_EQ(border_edges(surface), 0);
    // Star-shaped: every triangle faces away from the centre.
    expect_facing(surface, [](const Vec3& p) -> Vec3 { return p; });
    for (const Vec3& position : surface.positions) {
      EXPECT_GE(position.norm(), 0.7 * 0.7);
      EXPECT_LE(position.norm(), 1.3 * 0.7);
    }
  }
}

TEST(Shapes, SphereConvergesToItsAreaAndVolume) {
  // Errors fall with the square of the spacing, pi / (2 (n - 1)).
  for (const int n : {17, 33}) {
    const double spacing = kPi / 2 / (n - 1);
    const Surface surface = make_sphere(2.0, n);
    EXPECT_NEAR(area(surface) / (16 * kPi), 1, 0.4 * spacing * spacing);
    EXPECT_NEAR(volume(surface) / (32 * kPi / 3), 1, 0.6 * spacing * spacing);
    EXPECT_LT(volume(surface), 32 * kPi / 3);
  }
}

TEST(Shapes, CubeOfTwoByTwoPatchesHasItsClosedForm) {
  const double side = 2 / std::sqrt(3.0);
  EXPECT_NEAR(area(make_sphere(1.0, 2)), 6 * side * side, 1e-14);
  EXPECT_NEAR(volume(make_sphere(1.0, 2)), side * side * side, 1e-14);
}

// The texels of a sphere's six patches, one by one, as a file would hold them.
std::vector<Vec3> texels_of(const Surface& surface) {
  std::vector<Vec3> texels;
  texels.reserve(surface.atlas.texel_count());
  for (int texel = 0; texel < surface.atlas.texel_count(); ++texel) {
    texels.push_back(surface.positions[surface.atlas.particle_of_texel(texel)]);
  }
  return texels;
}

TEST(Shapes, TexelsOfPatchesAreSewnWhereTheyMeet) {
  const Surface sphere = make_sphere(1.0, 5);
  const Surface read = make_from_texels(6, 5, 5, texels_of(sphere), false, false);
  EXPECT_EQ(read.positions, sphere.positions);
  for (int texel = 0; texel < sphere.atlas.texel_count(); ++texel) {
    EXPECT_EQ(read.atlas.particle_of_texel(texel), sphere.atlas.particle_of_texel(texel));
  }
}

TEST(Shapes, TexelsThatDoNotMeetStayApart) {
  const Surface torus = make_torus(1.0, 0.2, 6, 5);
  const Surface read = make_from_texels(1, 6, 5, torus.positions, true, true);
  EXPECT_TRUE(read.atlas.is_identity());
  EXPECT_EQ(read.positions, torus.positions);
  EXPECT_EQ(euler_characteristic(read), 0);
  // Coinciding texels are no seam if they are interior or of a single patch.
  std::vector<Vec3> folded = make_rectangle(1, 1, 4, 4).positions;
  folded[3] = folded[0];
  std::vector<Vec3> two = folded;
  two.reserve(2 * folded.size());
  for (const Vec3& position : folded) two.push_back(position + Vec3(0, 0, 1));
  two[16 + 5] = two[5];
  EXPECT_TRUE(make_from_texels(2, 4, 4, two, false, false).atlas.is_identity());
  // Minus zero is the same place as zero.
  two[16] = two[0] = Vec3(0.0, -0.0, 0.0);
  two[16].y() = 0.0;
  EXPECT_EQ(make_from_texels(2, 4, 4, two, false, false).atlas.particle_count(), 31);
}

// A shape by its resolution, with the closed forms that it converges to.
struct SmoothShape {
  std::string name;
  std::function<Surface(int)> make;  // with `n` quads along an edge of its image or patches
  std::function<Vec3(const Vec3&)> outwards;
  int euler_characteristic;
  double area;                   // m^2
  std::optional<double> volume;  // m^3, of closed shapes
  double smallest_angle;         // degrees: lower bound at every resolution from n = 2
};

std::ostream& operator<<(std::ostream& stream, const SmoothShape& shape) {
  return stream << shape.name;
}

Vec3 upwards(const Vec3&) { return Vec3::UnitZ(); }
Vec3 from_axis(const Vec3& p) { return {p.x(), p.y(), 0}; }
// Points away from the axis of a capsule whose straight part reaches from -half to half.
auto from_segment(double half) {
  return [half](const Vec3& p) -> Vec3 {
    return {p.x(), p.y(), p.z() - std::clamp(p.z(), -half, half)};
  };
}

std::vector<SmoothShape> smooth_shapes() {
  const double slant = std::hypot(0.5, 0.8), frustum_slant = std::hypot(0.3, 0.4);
  const auto sine = [](double degrees) { return std::sin(degrees * kPi / 180); };
  return {
      {"disc", [](int n) { return make_disc(0.7, n + 1); }, upwards, 1, kPi * 0.49, {}, 30},
      {"annulus",
       [](int n) { return make_annulus(0.2, 0.5, n + 1, 8 * n); },
       upwards,
       0,
       kPi * 0.21,
       {},
       24},
      {"annulus_sector",
       [](int n) { return make_annulus(0.2, 0.5, n + 1, 2 * n + 1, 100); },
       upwards,
       1,
       kPi * 0.21 * 100 / 360,
       {},
       26},
      {"box",
       [](int n) {
         return make_box({1.0, 0.5, 0.25}, {4 * n + 1, 2 * n + 1, n + 1});
       },
       [](const Vec3& p) { return p; }, 2, 1.75, 0.125, 44.9},
      {"capsule", [](int n) { return make_capsule(0.3, 0.5, 2 * n + 1, n + 1); },
       from_segment(0.25), 2, 4 * kPi * 0.09 + 2 * kPi * 0.3 * 0.5,
       4 * kPi / 3 * 0.027 + kPi * 0.09 * 0.5, 25},
      {"cone",
       [](int n) { return make_cone(0.5, 0.8, n + 1); },
       [](const Vec3& p) -> Vec3 { return p + Vec3(0, 0, 0.4); },
       1,
       kPi * 0.5 * slant,
       {},
       17},
      {"frustum",
       [](int n) { return make_frustum(0.5, 0.2, 0.4, n + 1, 6 * n); },
       from_axis,
       0,
       kPi * 0.7 * frustum_slant,
       {},
       20},
      {"cylinder_sector",
       [](int n) { return make_cylinder(0.5, 1.0, 2 * n + 1, 2 * n + 1, 120); },
       from_axis,
       1,
       0.5 * 2 * kPi / 3,
       {},
       40},
      {"sphere_sector",
       [](int n) { return make_sphere_sector(0.5, -30, 60, 2 * n + 1, 2 * n + 1, 80); },
       [](const Vec3& p) { return p; },
       1,
       0.25 * (sine(60) + sine(30)) * 80 * kPi / 180,
       {},
       20},
      {"sphere_zone",
       [](int n) { return make_sphere_sector(0.5, 10, 50, n + 1, 6 * n); },
       [](const Vec3& p) { return p; },
       0,
       0.25 * (sine(50) - sine(10)) * 2 * kPi,
       {},
       25},
      {"sphere_zone_of_patches",
       [](int n) {
         return cut_into_patches(make_sphere_sector(0.5, 10, 50, 2 * n + 1, 12 * n), 2, 3);
       },
       [](const Vec3& p) { return p; },
       0,
       0.25 * (sine(50) - sine(10)) * 2 * kPi,
       {},
       25},
  };
}

// Smallest angle of all triangles, degrees.
double smallest_angle(const Surface& surface) {
  double largest_cosine = -1;
  for (const auto& corner : build_mesh(surface.atlas).triangles) {
    for (int i = 0; i < 3; ++i) {
      const Vec3& at = surface.positions[corner[i]];
      const Vec3 a = surface.positions[corner[(i + 1) % 3]] - at;
      const Vec3 b = surface.positions[corner[(i + 2) % 3]] - at;
      largest_cosine = std::max(largest_cosine, a.normalized().dot(b.normalized()));
    }
  }
  return std::acos(largest_cosine) * 180 / kPi;
}

class SmoothShapes : public testing::TestWithParam<SmoothShape> {};

// build_mesh() refuses edges that two triangles use in the same direction.
TEST_P(SmoothShapes, AreOrientedAndSewn) {
  for (const int n : {1, 2, 3, 8}) {
    const Surface surface = GetParam().make(n);
    EXPECT_EQ(euler_characteristic(surface), GetParam().euler_characteristic);
    EXPECT_EQ(border_edges(surface) == 0, GetParam().volume.has_value());
    expect_facing(surface, GetParam().outwards);
    // A trajectory stores all patches of a body in one array.
    for (const Patch& patch : surface.atlas.patches()) {
      EXPECT_EQ(patch.rows, surface.atlas.patches().front().rows);
      EXPECT_EQ(patch.cols, surface.atlas.patches().front().cols);
    }
  }
}

TEST_P(SmoothShapes, HaveNoThinTriangles) {
  for (const int n : {2, 3, 8, 32}) {
    EXPECT_GT(smallest_angle(GetParam().make(n)), GetParam().smallest_angle) << n;
  }
}

// Errors at twice the resolution are a quarter, or rounding where the shape is flat.
TEST_P(SmoothShapes, ConvergeAtSecondOrder) {
  const Surface coarse = GetParam().make(16), fine = GetParam().make(32);
  const auto expect_order = [](double error, double finer_error) {
    if (std::abs(error) < 1e-12) return;
    const double order = std::log2(error / finer_error);
    EXPECT_NEAR(order, 2, 0.15);
    RecordProperty("order", std::to_string(order));
  };
  expect_order(area(coarse) / GetParam().area - 1, area(fine) / GetParam().area - 1);
  EXPECT_NEAR(area(fine) / GetParam().area, 1, 3e-3);
  if (!GetParam().volume) return;
  expect_order(volume(coarse) / *GetParam().volume - 1, volume(fine) / *GetParam().volume - 1);
  EXPECT_NEAR(volume(fine) / *GetParam().volume, 1, 3e-3);
}

INSTANTIATE_TEST_SUITE_P(Each, SmoothShapes, testing::ValuesIn(smooth_shapes()),
                         [](const auto& row) { return row.param.name; });

TEST(Shapes, DiscHasItsRimAndItsCentre) {
  const Surface surface = make_disc(0.7, 5);
  EXPECT_EQ(surface.atlas.patches().size(), 12U);
  EXPECT_EQ(border_edges(surface), 32);
  for (int patch = 4; patch < 12; ++patch) {
    for (int col = 0; col < 5; ++col) {
      EXPECT_NEAR(surface.positions[surface.atlas.particle(patch, 0, col)].norm(), 0.7, 1e-15);
    }
  }
  for (int patch = 0; patch < 4; ++patch) {
    EXPECT_EQ(surface.positions[surface.atlas.particle(patch, 4, 0)], Vec3::Zero());
  }
}

TEST(Shapes, BoxHasSharpEdgesAndSquareTiles) {
  const Surface surface = make_box({1.0, 0.6, 0.2}, {11, 7, 3});
  EXPECT_EQ(surface.atlas.patches().size(), 2U * (5 * 3 + 3 * 1 + 1 * 5));
  const auto on_face = [](const Vec3& p) {
    return std::abs(p.x()) == 0.5 || std::abs(p.y()) == 0.3 || std::abs(p.z()) == 0.1;
  };
  for (const Vec3& p : surface.positions) EXPECT_TRUE(on_face(p)) << p.transpose();
  // Counts without a common divisor: every quad is a patch of its own.
  EXPECT_EQ(make_box({1.0, 0.6, 0.2}, {5, 4, 3}).atlas.patches().size(), 2U * (12 + 6 + 8));
}

TEST(Shapes, CapsuleIsRoundAtBothEnds) {
  const Surface surface = make_capsule(0.3, 0.5, 5, 3);
  EXPECT_EQ(surface.atlas.patches().size(), 2U * (1 + 2 + 2));
  for (const Vec3& p : surface.positions) {
    EXPECT_NEAR(from_segment(0.25)(p).norm(), 0.3, 1e-15);
  }
}

// Patches of a cut surface have the positions of the whole one, in their places.
TEST(CutIntoPatches, KeepsEveryVertex) {
  const Surface whole = make_torus(2, 1, 6, 8);
  for (const auto& [rows, cols] :
       {std::pair(1, 1), std::pair(1, 2), std::pair(3, 1), std::pair(2, 4)}) {
    const Surface cut = cut_into_patches(whole, rows, cols);
    EXPECT_EQ(cut.atlas.particle_count(), whole.atlas.particle_count());
    ASSERT_EQ(cut.atlas.patches().size(), static_cast<std::size_t>(rows * cols));
    const Patch& patch = cut.atlas.patches()[0];
    EXPECT_EQ(patch.wrap_u, cols == 1);
    EXPECT_EQ(patch.wrap_v, rows == 1);
    for (int p = 0; p < rows * cols; ++p) {
      for (int r = 0; r < patch.rows; ++r) {
        for (int c = 0; c < patch.cols; ++c) {
          const int row = p / cols * patch.quad_rows() + r, col = p % cols * patch.quad_cols() + c;
          EXPECT_EQ(cut.positions[cut.atlas.particle(p, r, c)],
                    whole.positions[whole.atlas.particle(0, row, col)]);
        }
      }
    }
  }
  EXPECT_THROW(cut_into_patches(whole, 4, 1), std::invalid_argument);
  EXPECT_THROW(cut_into_patches(whole, 0, 1), std::invalid_argument);
  EXPECT_THROW(cut_into_patches(make_sphere(1, 5), 2, 2), std::invalid_argument);
}

TEST(Shapes, SectorsBeginAtTheXAxis) {
  const Surface sector = make_cylinder(0.5, 1.0, 3, 5, 90);
  EXPECT_TRUE(sector.positions[0].isApprox(Vec3(0.5, 0, -0.5)));
  EXPECT_TRUE(sector.positions[4].isApprox(Vec3(0, 0.5, -0.5)));
  EXPECT_FALSE(sector.atlas.patches()[0].wrap_u);
  EXPECT_TRUE(make_annulus(0.2, 0.5, 3, 5).atlas.patches()[0].wrap_u);
}

TEST(Shapes, RefuseImpossibleSizes) {
  EXPECT_THROW(make_rectangle(0, 1, 4, 4), std::invalid_argument);
  EXPECT_THROW(make_rectangle(1, std::numeric_limits<double>::quiet_NaN(), 4, 4),
               std::invalid_argument);
  EXPECT_THROW(make_rectangle(1, 1, 1, 4), std::invalid_argument);
  EXPECT_THROW(make_cylinder(-1, 1, 4, 4), std::invalid_argument);
  EXPECT_THROW(make_cylinder(1, 1, 4, 2), std::invalid_argument);
  EXPECT_THROW(make_torus(1, 1, 4, 4), std::invalid_argument);
  EXPECT_THROW(make_torus(1, 0.5, 2, 4), std::invalid_argument);
  EXPECT_THROW(make_sphere(std::numeric_limits<double>::infinity(), 4), std::invalid_argument);
  EXPECT_THROW(make_sphere(1, 1), std::invalid_argument);
  EXPECT_THROW(make_box({1, 0, 1}, {3, 3, 3}), std::invalid_argument);
  EXPECT_THROW(make_box({1, 1, 1}, {3, 1, 5}), std::invalid_argument);
  EXPECT_THROW(make_disc(1, 1), std::invalid_argument);
  EXPECT_THROW(make_capsule(1, 1, 1, 3), std::invalid_argument);
  EXPECT_THROW(make_cone(1, 0, 3), std::invalid_argument);
  EXPECT_THROW(make_frustum(1, 0, 1, 3, 9), std::invalid_argument);
  EXPECT_THROW(make_annulus(1, 1, 3, 9), std::invalid_argument);
  EXPECT_THROW(make_annulus(1, 2, 3, 9, 361), std::invalid_argument);
  EXPECT_THROW(make_cylinder(1, 1, 3, 9, 0), std::invalid_argument);
  EXPECT_THROW(make_sphere_sector(1, -90, 0, 3, 9), std::invalid_argument);
  EXPECT_THROW(make_sphere_sector(1, 10, 10, 3, 9), std::invalid_argument);
  EXPECT_THROW(make_from_texels(0, 2, 2, {}, false, false), std::invalid_argument);
  EXPECT_THROW(make_from_texels(1, 2, 2, {Vec3::Zero()}, false, false), std::invalid_argument);
}

TEST(Shapes, NameTheTexelThatIsNotFinite) {
  std::vector<Vec3> texels(2 * 3 * 3, Vec3::Zero());
  texels[9 + 5].z() = std::numeric_limits<double>::infinity();
  try {
    make_from_texels(2, 3, 3, texels, false, false);
    FAIL() << "an infinite position was accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("patch 1, row 1, column 2"), std::string::npos);
  }
}

}  // namespace
}  // namespace weft::bsi::shapes_test
