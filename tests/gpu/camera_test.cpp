// What a camera sees, by projecting the points with a formula of its own.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "bsi/shapes.h"
#include "gpu/renderer.h"

namespace weft::gpu {
namespace {

struct Frame {
  double left = INFINITY, right = -INFINITY, bottom = INFINITY, top = -INFINITY;
};

// The part of the picture (-1..1 along both axes) that the points take.
Frame seen(const Camera& camera, double aspect, std::span<const Vec3> points) {
  const Vec3 forward = (camera.target - camera.eye).normalized();
  const Vec3 right = forward.cross(camera.up).normalized();
  const Vec3 up = right.cross(forward);
  const double slope = std::tan(camera.field_of_view_deg / 2 * std::numbers::pi / 180);
  Frame frame;
  for (const Vec3& point : points) {
    const Vec3 ray = point - camera.eye;
    const double depth = ray.dot(forward);
    EXPECT_GT(depth, 0);
    const double x = ray.dot(right) / (depth * slope * aspect);
    const double y = ray.dot(up) / (depth * slope);
    frame = {std::min(frame.left, x), std::max(frame.right, x), std::min(frame.bottom, y),
             std::max(frame.top, y)};
  }
  return frame;
}

TEST(Camera, SeesAllPointsAsLargeAsTheMarginAllows) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  for (const double aspect : {0.5, 1.0, 4.0 / 3, 3.0}) {
    for (int trial = 0; trial < 20; ++trial) {
      const Vec3 scale(std::exp(4 * coordinate(random)), std::exp(4 * coordinate(random)),
                       std::exp(4 * coordinate(random)));
      const Vec3 offset = 100 * Vec3(coordinate(random), coordinate(random), coordinate(random));
      std::vector<Vec3> points;
      points.reserve(30);
      for (int i = 0; i < 30; ++i) {
        points.push_back(offset + scale.cwiseProduct(Vec3(coordinate(random), coordinate(random),
                                                          coordinate(random))));
      }
      const Frame frame = seen(camera_for_points(points, aspect), aspect, points);
      // Centred along both axes, and as large as the margin of 10 % allows along one.
      EXPECT_NEAR(frame.left, -frame.right, 1e-9);
      EXPECT_NEAR(frame.bottom, -frame.top, 1e-9);
      EXPECT_NEAR(std::max(frame.right, frame.top), 1 / 1.1, 1e-9);
    }
  }
}

TEST(Camera, LooksFromAboveAndSeesABoxWhole) {
  const Camera camera = camera_for_box({0, 0, 0}, {3, 2, 1}, 1.5);
  EXPECT_GT(camera.eye.z(), 1);
  std::vector<Vec3> corners;
  for (const double x : {0.0, 3.0}) {
    for (const double y : {0.0, 2.0}) {
      for (const double z : {0.0, 1.0}) corners.emplace_back(x, y, z);
    }
  }
  const Frame frame = seen(camera, 1.5, corners);
  EXPECT_GT(frame.left, -1);
  EXPECT_LT(frame.top, 1);
}

TEST(Camera, HasRoomAroundASinglePoint) {
  const Vec3 point(1, 2, 3);
  const Camera camera = camera_for_points(std::array{point}, 1.0);
  EXPECT_TRUE(camera.eye.allFinite());
  EXPECT_NEAR((camera.target - point).norm(), 0, 1e-3);
  EXPECT_GT((camera.eye - point).norm(), 1e-4);
  EXPECT_LT((camera.eye - point).norm(), 1e-2);
}

TEST(GridLines, FollowTheImageOverItsWraps) {
  // 24 rows and columns of quads: a line at every second; both axes closed.
  const bsi::Atlas torus({{24, 24, true, true}});
  const auto lines = grid_lines(torus);
  EXPECT_EQ(lines.size(), 2U * 12 * 24);
  EXPECT_NE(std::find(lines.begin(), lines.end(), std::array<int, 2>{23, 0}), lines.end());
  // 5 x 8 vertices, 4 x 7 quads: every row and column.
  EXPECT_EQ(grid_lines(bsi::Atlas({{5, 8}})).size(), 5U * 7 + 8U * 4);
  // 13 quads: every second, and the border, of which both ends are lined.
  EXPECT_EQ(grid_lines(bsi::Atlas({{2, 14}})).size(), 2U * 13 + 8U * 1);
}

TEST(Palette, HasNoTwoNeighboursAlike) {
  for (int i = 0; i < 8; ++i) {
    const Colour a = palette(i).front;
    const Colour b = palette(i + 1).front;
    double difference = 0;
    for (int channel = 0; channel < 3; ++channel) difference += std::abs(a[channel] - b[channel]);
    EXPECT_GT(difference, 0.2);
    EXPECT_NE(palette(i).front, palette(i).back);
  }
  EXPECT_EQ(palette(0).front, palette(8).front);
}

}  // namespace
}  // namespace weft::gpu
