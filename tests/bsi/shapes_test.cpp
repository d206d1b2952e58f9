#include "bsi/shapes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

namespace weft::bsi {
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
}  // namespace weft::bsi
