// Where to look from.
#include <Eigen/Geometry>
#include <cassert>
#include <cmath>
#include <numbers>

#include "gpu/renderer.h"

namespace weft::gpu {
namespace {

constexpr double margin = 1.12;  // room around the box, as a factor on its size in the picture

struct View {
  Vec3 right, up, backward;
};

}  // namespace

Camera camera_for_box(const Vec3& lowest, const Vec3& highest, double aspect) {
  assert(lowest.allFinite() && highest.allFinite() && (lowest.array() <= highest.array()).all());
  assert(aspect > 0);
  Camera camera;
  const double azimuth = -58 * std::numbers::pi / 180;
  const double elevation = 24 * std::numbers::pi / 180;
  View view;
  view.backward = {std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
                   std::sin(elevation)};
  view.right = camera.up.cross(view.backward).normalized();
  view.up = view.backward.cross(view.right);

  const double slope_up = std::tan(camera.field_of_view_deg * std::numbers::pi / 360) / margin;
  const double slope_right = slope_up * aspect;
  camera.target = 0.5 * (lowest + highest);
  const Vec3 half = (0.5 * (highest - lowest)).cwiseMax(0.5e-3);

  // Along each axis of the picture, the corners give lines that the eye must stay behind; in a
  // frame where the eye is (x, y, z), a corner c is inside when |c.x - x| <= slope (z - c.z). The
  // two extreme lines on either side meet in the eye that just sees everything.
  double distance = 0;
  Eigen::Vector2d shift;
  for (const int axis : {0, 1}) {
    const Vec3& direction = axis == 0 ? view.right : view.up;
    const double slope = axis == 0 ? slope_right : slope_up;
    double above = -INFINITY;
    double below = -INFINITY;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 offset((corner & 1) != 0 ? half.x() : -half.x(),
                        (corner & 2) != 0 ? half.y() : -half.y(),
                        (corner & 4) != 0 ? half.z() : -half.z());
      const double across = direction.dot(offset);
      const double towards = slope * view.backward.dot(offset);
      above = std::max(above, across + towards);
      below = std::max(below, -across + towards);
    }
    shift[axis] = 0.5 * (above - below);
    distance = std::max(distance, 0.5 * (above + below) / slope);
  }
  camera.target += shift[0] * view.right + shift[1] * view.up;
  camera.eye = camera.target + distance * view.backward;
  return camera;
}

}  // namespace weft::gpu
