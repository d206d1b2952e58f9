// Cameras that see all of some points or a box, and the tolerance of detail that a camera allows.
#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include "gpu/renderer.h"

namespace weft::gpu {
namespace {

constexpr double picture_margin =
    1.1;  // size of the picture divided by the size of the points in it

// Finds a position of the eye from which the picture contains all points along one of its axes.
// Points have the coordinates `across`, along this axis, and `depth`, towards the eye (m). A point
// is in the picture if its slope |across - eye_across| / (eye_depth - depth) is at most the slope
// of the picture's edge.
struct Axis {
  std::vector<Eigen::Vector2d> points;  // (across, depth), m

  // Returns the largest across * x + depth * y of all points (x, y).
  double largest(double across, double depth) const {
    double value = -std::numeric_limits<double>::infinity();
    for (const Eigen::Vector2d& point : points) {
      value = std::max(value, across * point[0] + depth * point[1]);
    }
    return value;
  }
  // Returns the smallest depth of an eye that sees all points, if the picture's edges have this
  // slope. The lines of sight along both edges then touch the points and meet in the eye.
  double nearest_eye(double slope) const {
    return 0.5 * (largest(1, slope) + largest(-1, slope)) / slope;
  }
  // Returns the eye's coordinate `across` for which the points reach equally far to both sides of
  // the picture, at this depth of the eye. Bisection finds it as the root of a monotonic function.
  double middle(double eye_depth) const {
    double low = -largest(-1, 0);
    double high = largest(1, 0);
    for (int halving = 0; halving < 60; ++halving) {
      const double eye = 0.5 * (low + high);
      double above = -std::numeric_limits<double>::infinity();
      double below = above;
      for (const Eigen::Vector2d& point : points) {
        const double slope = (point[0] - eye) / (eye_depth - point[1]);
        above = std::max(above, slope);
        below = std::max(below, -slope);
      }
      (above > below ? low : high) = eye;
    }
    return 0.5 * (low + high);
  }
};

std::vector<Vec3> corners_of_box(const Vec3& lowest, const Vec3& highest) {
  std::vector<Vec3> corners;
  corners.reserve(8);
  for (int corner = 0; corner < 8; ++corner) {
    corners.emplace_back((corner & 1) != 0 ? highest.x() : lowest.x(),
                         (corner & 2) != 0 ? highest.y() : lowest.y(),
                         (corner & 4) != 0 ? highest.z() : lowest.z());
  }
  return corners;
}

}  // namespace

Camera camera_for_points(std::span<const Vec3> points, double aspect) {
  assert(!points.empty() && aspect > 0);
  Vec3 lowest = points.front();
  Vec3 highest = points.front();
  for (const Vec3& point : points) {
    assert(point.allFinite());
    lowest = lowest.cwiseMin(point);
    highest = highest.cwiseMax(point);
  }
  const Vec3 centre = 0.5 * (lowest + highest);
  // An extent of a millionth of the coordinates may be the rounding of float32 alone. The points
  // are then drawn as one point, with room around it.
  constexpr double rounding = 1e-6, room = 1e-3;
  const double farthest = std::max(lowest.cwiseAbs().maxCoeff(), highest.cwiseAbs().maxCoeff());
  if ((highest - lowest).maxCoeff() <= rounding * farthest || lowest == highest) {
    const Vec3 half = Vec3::Constant(std::max(0.5 * room, rounding * farthest));
    return camera_for_points(corners_of_box(centre - half, centre + half), aspect);
  }

  Camera camera;
  const double azimuth = -58 * std::numbers::pi / 180;
  const double elevation = 30 * std::numbers::pi / 180;
  const Vec3 backward(std::cos(azimuth) * std::cos(elevation),
                      std::sin(azimuth) * std::cos(elevation), std::sin(elevation));
  const Vec3 right = camera.up.cross(backward).normalized();
  const Vec3 up = backward.cross(right);
  Axis across;
  Axis upwards;
  for (const Vec3& point : points) {
    const Vec3 offset = point - centre;
    across.points.emplace_back(right.dot(offset), backward.dot(offset));
    upwards.points.emplace_back(up.dot(offset), backward.dot(offset));
  }
  const double slope = std::tan(camera.field_of_view_deg * std::numbers::pi / 360) / picture_margin;
  const double distance = std::max(across.nearest_eye(slope * aspect), upwards.nearest_eye(slope));
  camera.target = centre + across.middle(distance) * right + upwards.middle(distance) * up;
  camera.eye = camera.target + distance * backward;
  return camera;
}

Camera camera_for_box(const Vec3& lowest, const Vec3& highest, double aspect) {
  assert((lowest.array() <= highest.array()).all());
  return camera_for_points(corners_of_box(lowest, highest), aspect);
}

// Derivation: consider a small offset d of a point at distance r from the eye, at the angle a from
// the camera's axis. In the plane at distance 1, it moves the point's image by at most
// d / (r cos^2 a), to first order in d / r. A pixel of that plane has the side 2 slope / height.
// The angle is largest in the picture's corners.
bsi::DetailTolerance pixel_tolerance(const Camera& camera, int width, int height, double pixels) {
  assert(pixels >= 0);
  const double slope = std::tan(camera.field_of_view_deg * std::numbers::pi / 360);
  const double aspect = static_cast<double>(width) / height;
  const double squared_cosine = 1 / (1 + slope * slope * (1 + aspect * aspect));
  return {std::numeric_limits<double>::infinity(), pixels * 2 * slope / height * squared_cosine,
          camera.eye};
}

}  // namespace weft::gpu
