#include "bsi/smallest_ball.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cassert>

namespace weft::bsi {

namespace {

constexpr double tolerance = 1e-12;  // of squared radii

// At most four points, and one more that may join them.
struct Support {
  std::array<Vec3, 5> point{Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  int count = 0;
};

bool holds(const Ball& ball, const Vec3& point) {
  return (point - ball.centre).squaredNorm() <= ball.squared_radius * (1 + tolerance);
}

// The smallest ball with the points on its surface: with edges a, b, c from the first of four
// points, its centre is off that point by
//   (|a|^2 b x c + |b|^2 c x a + |c|^2 a x b) / (2 a . b x c),
// and with a x b in place of c and the square of that in place of the product for three. False
// where the points are not independent.
bool ball_through(const Support& support, Ball& ball) {
  const Vec3& origin = support.point[0];
  const Vec3 a = support.point[1] - origin;
  const Vec3 b = support.point[2] - origin;
  const Vec3 c = support.count == 3 ? a.cross(b) : Vec3(support.point[3] - origin);
  Vec3 offset = Vec3::Zero();
  if (support.count == 2) {
    offset = 0.5 * a;
  } else if (support.count > 2) {
    const double determinant = a.dot(b.cross(c));
    if (determinant == 0) return false;
    offset = a.squaredNorm() * b.cross(c) + b.squaredNorm() * c.cross(a);
    if (support.count == 4) offset += c.squaredNorm() * a.cross(b);
    offset /= 2 * determinant;
  }
  ball = {origin + offset, 0};
  for (int i = 0; i < support.count; ++i) {
    const double squared = (support.point[i] - ball.centre).squaredNorm();
    ball.squared_radius = std::max(ball.squared_radius, squared);
  }
  return true;
}

// Replaces a support of up to five points by the subset whose ball holds them all and is smallest.
// False if rounding leaves none.
bool reduce(Support& support, Ball& ball) {
  bool found = false;
  Support best;
  for (unsigned subset = 1; subset < 1U << support.count; ++subset) {
    Support candidate;
    for (int i = 0; i < support.count; ++i) {
      if ((subset >> i & 1U) != 0) candidate.point[candidate.count++] = support.point[i];
    }
    Ball of_candidate;
    if (candidate.count > 4 || !ball_through(candidate, of_candidate)) continue;
    if (found && of_candidate.squared_radius >= ball.squared_radius) continue;
    bool all = true;
    for (int i = 0; i < support.count; ++i) all = all && holds(of_candidate, support.point[i]);
    if (!all) continue;
    found = true;
    best = candidate;
    ball = of_candidate;
  }
  support = best;
  return found;
}

}  // namespace

Ball smallest_ball(std::span<const Vec3> points) {
  assert(!points.empty());
  Ball ball{points[0], 0};
  Support support;
  support.point[support.count++] = points[0];
  for (;;) {
    const Vec3* farthest = nullptr;
    double squared = ball.squared_radius * (1 + tolerance);
    for (const Vec3& point : points) {
      const double distance = (point - ball.centre).squaredNorm();
      if (distance <= squared) continue;
      squared = distance;
      farthest = &point;
    }
    if (farthest == nullptr) return ball;
    Ball larger;
    support.point[support.count++] = *farthest;
    // A ball that does not grow is as good as rounding allows; make it hold the farthest point.
    if (!reduce(support, larger) || larger.squared_radius <= ball.squared_radius) {
      ball.squared_radius = squared;
      return ball;
    }
    ball = larger;
  }
}

}  // namespace weft::bsi
