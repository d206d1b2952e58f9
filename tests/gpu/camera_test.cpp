// Checks the view of a camera by projecting points with an independent formula.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "bsi/shapes.h"
#include "gpu/renderer.h"

namespace weft::gpu::camera_test {
namespace {

struct Frame {
  double left = INFINITY, right = -INFINITY, bottom = INFINITY, top = -INFINITY;
};

// Returns the part of the picture (-1..1 along both axes) that the points cover.
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
      // The points are centred along both axes and, along one, as large as the margin of 10 %
      // allows.
      EXPECT_NEAR(frame.left, -frame.right, 1e-9);
      EXPECT_NEAR(frame.bottom, -frame.top, 1e-9);
      EXPECT_NEAR(std::max(frame.right, frame.top), 1 / 1.1, 1e-9);
    }
  }
}

// A sheet fills its picture whatever its size, as long as float32 tells its ends apart.
TEST(Camera, SeesScenesOfAnySizeAlike) {
  for (const double size : {1e-9, 1e-5, 1.0, 1e4, 1e9}) {
    for (const double shift : {0.0, 1e5}) {
      std::vector<Vec3> corners;
      for (const double x : {0.0, 1.0}) {
        for (const double y : {0.0, 1.0}) corners.push_back(size * Vec3(shift + x, y, 0));
      }
      const Frame frame = seen(camera_for_points(corners, 1.5), 1.5, corners);
      EXPECT_NEAR(std::max(frame.right, frame.top), 1 / 1.1, 1e-6) << size << ' ' << shift;
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

// Points that only the rounding of float32 keeps apart are one point.
TEST(Camera, HasRoomAroundAPointFarAway) {
  for (const double place : {1.0, 1e5, 1e12}) {
    const std::array points{Vec3(place, 0, 0), Vec3(place * (1 + 1e-7), 0, 0)};
    const Camera camera = camera_for_points(points, 1.0);
    ASSERT_TRUE(camera.eye.allFinite());
    const Frame frame = seen(camera, 1.0, points);
    EXPECT_LT(frame.right - frame.left, 0.5) << place;
  }
}

// The rows and columns of one patch that get a line.
std::array<std::vector<int>, 2> lined(const bsi::Surface& surface) {
  const bsi::Patch& patch = surface.atlas.patches()[0];
  std::array<std::vector<int>, 2> places;
  for (const auto& [from, to] : grid_lines(surface.atlas, surface.positions)) {
    const bool is_along_row = from / patch.cols == to / patch.cols;
    if (is_along_row && from % patch.cols == 0) places[0].push_back(from / patch.cols);
    if (!is_along_row && from / patch.cols == 0) places[1].push_back(from % patch.cols);
  }
  return places;
}

TEST(GridLines, MakeSquareCellsInMetres) {
  using Places = std::vector<int>;
  // 24 quads of 4 cm along 0.96 m, 24 of 2 cm along the other side: cells of 8 cm.
  const auto [rows, cols] = lined(bsi::make_rectangle(0.96, 0.48, 25, 25));
  EXPECT_EQ(cols, (Places{0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24}));
  EXPECT_EQ(rows, (Places{0, 4, 8, 12, 16, 20, 24}));
  // The cells are as coarse as the longest edges.
  const auto [coarse_rows, coarse_cols] = lined(bsi::make_rectangle(1, 1, 5, 9));
  EXPECT_EQ(coarse_rows, (Places{0, 1, 2, 3, 4}));
  EXPECT_EQ(coarse_cols, (Places{0, 2, 4, 6, 8}));
  // 13 quads: two to a cell, and one in the last.
  const auto [strip_rows, strip_cols] = lined(bsi::make_rectangle(1.3, 0.2, 3, 14));
  EXPECT_EQ(strip_cols, (Places{0, 2, 4, 6, 8, 10, 12, 13}));
  EXPECT_EQ(strip_rows, (Places{0, 2}));
}

TEST(GridLines, FollowTheImageOverItsWraps) {
  // 24 quads around the axis, two of them to a cell; 24 around the tube, a quarter as long.
  const bsi::Surface torus = bsi::make_torus(0.8, 0.2, 24, 24);
  const auto lines = grid_lines(torus.atlas, torus.positions);
  EXPECT_EQ(lines.size(), (24U / 8 + 24U / 2) * 24);
  EXPECT_NE(std::find(lines.begin(), lines.end(), std::array<int, 2>{23, 0}), lines.end());
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
}  // namespace weft::gpu::camera_test
