#include "bsi/smallest_ball.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace weft::bsi {
namespace {

double reach(const std::vector<Vec3>& points, const Vec3& centre) {
  double farthest = 0;
  for (const Vec3& point : points) farthest = std::max(farthest, (point - centre).norm());
  return farthest;
}

TEST(SmallestBall, IsThatOfSimpleShapes) {
  const auto expect = [](const std::vector<Vec3>& points, const Vec3& centre, double radius) {
    const Ball ball = smallest_ball(points);
    EXPECT_LT((ball.centre - centre).norm(), 1e-14);
    EXPECT_NEAR(std::sqrt(ball.squared_radius), radius, 1e-14);
  };
  expect({{1, 2, 3}}, {1, 2, 3}, 0);
  expect({{1, 2, 3}, {1, 2, 3}, {1, 2, 3}}, {1, 2, 3}, 0);
  expect({{0, 0, 0}, {2, 0, 0}, {0.5, 0, 0}}, {1, 0, 0}, 1);
  expect({{0, 0, 0}, {2, 0, 0}, {1, 0.1, 0}}, {1, 0, 0}, 1);  // obtuse: the longest edge alone
  const double r = 1 / std::sqrt(3.0);
  expect({{0, 0, 0}, {1, 0, 0}, {0.5, std::sqrt(0.75), 0}}, {0.5, std::sqrt(0.75) / 3, 0}, r);
  std::vector<Vec3> cube;
  cube.reserve(8);
  for (int i = 0; i < 8; ++i) cube.emplace_back(i & 1, i >> 1 & 1, i >> 2);
  expect(cube, {0.5, 0.5, 0.5}, std::sqrt(0.75));
}

// The farthest distance is a convex function of the centre: a minimum among near points is one.
TEST(SmallestBall, HoldsItsPointsAndNoBallNearbyIsSmaller) {
  std::mt19937 random(31);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return Vec3(normal(random), normal(random), normal(random)); };
  for (int set = 0; set < 300; ++set) {
    std::vector<Vec3> points(1 + set % 60);
    const Vec3 scale = draw(), offset = 100 * draw();
    for (Vec3& point : points) point = offset + scale.cwiseProduct(draw());
    const Ball ball = smallest_ball(points);
    const double radius = std::sqrt(ball.squared_radius);
    EXPECT_LE(reach(points, ball.centre), radius * (1 + 1e-12));
    for (int i = 0; i < 50; ++i) {
      const Vec3 beside = ball.centre + radius * std::pow(10.0, -i % 6) * draw();
      EXPECT_GE(reach(points, beside), radius * (1 - 1e-10));
    }
  }
}

}  // namespace
}  // namespace weft::bsi
