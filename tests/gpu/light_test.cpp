// Shadows and the light of the sky.
#include <gtest/gtest.h>

#include "bsi/shapes.h"
#include "gpu/depth_map.h"
#include "gpu/screen_geometry.h"
#include "gpu/sky_light.h"
#include "gpu/triangle_batch.h"
#include "gpu/view.h"

namespace weft::gpu::light_test {
namespace {

using Eigen::Vector3f;

const Vec3 up(0, 0, 1);

// Sheets of 2 x 2 quads in planes of constant z.
class Sheets {
 public:
  void add(double size, double height) {
    bsi::Surface sheet = bsi::make_rectangle(size, size, 3, 3);
    for (Vec3& position : sheet.positions) position.z() = height;
    const auto first = static_cast<int>(positions_.size());
    for (std::array<int, 3> triangle : bsi::build_mesh(sheet.atlas).triangles) {
      for (int& corner : triangle) corner += first;
      triangles_.push_back(triangle);
    }
    positions_.insert(positions_.end(), sheet.positions.begin(), sheet.positions.end());
  }
  TriangleBatch batch() const {
    TriangleBatch batch;
    batch.assemble(std::array{DrawnSurface{positions_, triangles_}}, Vec3::Zero());
    return batch;
  }

 private:
  std::vector<Vec3> positions_;
  std::vector<std::array<int, 3>> triangles_;
};

// A roof -1..1 at z = 0 under a light straight above; a texel is 4/90 m.
TEST(DepthMap, ShadesWhatIsBehind) {
  Sheets sheets;
  sheets.add(2, 0);
  DepthMap map(96);
  map.draw(sheets.batch(), up, Vec3(0, 1, 0), 2);
  EXPECT_NEAR(map.texel(), 4.0 / 90, 1e-6);
  for (const auto look_up : {&DepthMap::lit, &DepthMap::softly_lit}) {
    EXPECT_EQ((map.*look_up)(Vector3f(0.3F, -0.4F, -0.1F)), 0);
    EXPECT_EQ((map.*look_up)(Vector3f(0.3F, -0.4F, 0.1F)), 1);
    EXPECT_EQ((map.*look_up)(Vector3f(1.3F, -0.4F, -0.1F)), 1);
    EXPECT_EQ((map.*look_up)(Vector3f(100, 100, -0.1F)), 1);  // beyond the map
  }
}

// Light grows from full shadow to full light within 1 texel, and within 3, without a step.
TEST(DepthMap, FadesAtTheRimOfAShadow) {
  Sheets sheets;
  sheets.add(2, 0);
  DepthMap map(96);
  map.draw(sheets.batch(), up, Vec3(0, 1, 0), 2);
  for (const auto& [look_up, texels] :
       {std::pair(&DepthMap::lit, 1), std::pair(&DepthMap::softly_lit, 3)}) {
    int grey = 0;
    float last = 0;
    constexpr int steps = 1000;
    for (int i = 0; i < steps; ++i) {
      const float x = 1 + 5 * map.texel() * (static_cast<float>(i) / steps - 0.5F);
      const float lit = (map.*look_up)(Vector3f(x, 0, -0.1F));
      EXPECT_GE(lit, last);
      EXPECT_LT(lit, last + 0.01F);
      last = lit;
      grey += lit > 0 && lit < 1;
    }
    EXPECT_EQ(last, 1);
    EXPECT_NEAR(grey, steps * texels / 5, steps / 50);
  }
}

// A surface does not shade itself in any orientation to the light.
TEST(DepthMap, LightsASphereOnTheLightsSide) {
  const bsi::Surface ball = bsi::make_sphere(1, 33);
  const bsi::Mesh mesh = bsi::build_mesh(ball.atlas);
  TriangleBatch batch;
  batch.assemble(std::array{DrawnSurface{ball.positions, mesh.triangles}}, Vec3::Zero());
  const Vec3 light = Vec3(0.3, -0.5, 0.8).normalized();
  DepthMap map(512);
  map.draw(batch, light, up, 2);
  for (const Vec3& position : ball.positions) {
    const double cosine = position.dot(light);
    const Vector3f looked_up = ((1 + 2.5 * map.texel()) * position).cast<float>();
    if (std::abs(cosine + 0.125) < 0.175) continue;
    EXPECT_EQ(map.softly_lit(looked_up), cosine > 0 ? 1 : 0) << cosine;
  }
}

TEST(SkyLight, IsOneOnAFreeLevelSurfaceAndNoneBelowIt) {
  Sheets sheets;
  sheets.add(1, 0);
  TriangleBatch batch = sheets.batch();
  add_sky_light(up, sky_reach(batch, 3), batch);
  for (BatchVertex& vertex : batch.vertices) {
    EXPECT_NEAR(vertex.front_sky(), 1, 1e-5);
    EXPECT_EQ(vertex.back_sky(), 0);
  }
}

// A roof as large as the sheet shades its middle more than its corners.
TEST(SkyLight, IsKeptOffByWhatIsAbove) {
  Sheets sheets;
  sheets.add(1, 0);
  sheets.add(1, 0.2);
  TriangleBatch batch = sheets.batch();
  add_sky_light(up, sky_reach(batch, 3), batch);
  float middle = 1, corner = 0;
  for (std::size_t i = 0; i < 9; ++i) {
    const float distance = batch.vertices[i].position().matrix().norm();
    if (distance < 0.1F) middle = batch.vertices[i].front_sky();
    if (distance > 0.6F) corner = std::max(corner, batch.vertices[i].front_sky());
  }
  EXPECT_LT(middle, 0.2F);
  EXPECT_GT(corner, middle + 0.2F);
  EXPECT_LT(corner, 0.9F);
}

TEST(SkyLight, ReachesAsFarAsWhatKeepsItOff) {
  Sheets sheets;
  sheets.add(1, 0);
  const double half_diagonal = std::sqrt(0.5);
  const double alone = sky_reach(sheets.batch(), 100);
  EXPECT_GE(alone, half_diagonal);
  EXPECT_LE(alone, 1.25 * half_diagonal);
  EXPECT_EQ(sky_reach(sheets.batch(), 0.8), 0.8);
  sheets.add(1000, -1);  // a floor beyond all bounds
  EXPECT_LE(sky_reach(sheets.batch(), 100), 1.25 * std::hypot(half_diagonal, 1));
}

// Light at the corners is enough for triangles that are small in the picture.
TEST(ScreenGeometry, CutsLargeTriangles) {
  constexpr int size = 256;
  const Perspective perspective{look_along(up, Vec3(0, 1, 0)), {0, 0, 4}, size, size, size, 1e-3};
  Sheets sheets;
  sheets.add(1000, 0);
  TriangleBatch batch = sheets.batch();
  ScreenGeometry geometry;
  geometry.project(perspective, batch);
  // Right-angled triangles with sides of 8 to 16 pixels.
  EXPECT_GT(geometry.triangles.size(), size * size / 128U);
  EXPECT_LT(geometry.triangles.size(), size * size / 24U);
  EXPECT_LT(batch.vertices.size(), geometry.triangles.size() + 1000);
  for (const ScreenTriangle& triangle : geometry.triangles) {
    EXPECT_TRUE(triangle.is_front);
    EXPECT_LE(triangle.box.right - triangle.box.left, 16);
    EXPECT_LE(triangle.box.bottom - triangle.box.top, 16);
    EXPECT_NEAR(triangle.nearness.at(3, 5), 0.25, 1e-5);
  }
}

}  // namespace
}  // namespace weft::gpu::light_test
