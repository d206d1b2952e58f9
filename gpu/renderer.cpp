#include "gpu/renderer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "gpu/background.h"
#include "gpu/depth_map.h"
#include "gpu/picture_rows.h"
#include "gpu/screen_geometry.h"
#include "gpu/sky_light.h"
#include "gpu/triangle_batch.h"
#include "gpu/view.h"

namespace weft::gpu {
namespace {

constexpr int key_shadow_size = 1024;

// Surfaces are cut off where their distance from the eye, measured along the camera's axis, is less
// than this fraction of the distance from the eye to the target.
constexpr double nearest_share = 1e-3;

// Bounds of what is drawn, m. Squares of coordinates beyond are no float32 numbers.
constexpr double farthest_drawn = 1e18, nearest_drawn = 1e-18;

void refuse_out_of_range(std::span<const DrawnSurface> surfaces, const Camera& camera) {
  bool is_within = (camera.eye - camera.target).norm() >= nearest_drawn;
  for (const DrawnSurface& surface : surfaces) {
    for (const Vec3& position : surface.positions)
      is_within = is_within && ((position - camera.target).array().abs() <= farthest_drawn).all();
  }
  if (is_within) return;
  throw std::runtime_error(
      "cannot draw what is not finite, farther than 1e18 m from the middle, or seen from less than "
      "1e-18 m");
}

void refuse_without_view(const Camera& camera) {
  const double distance = (camera.eye - camera.target).norm();
  const bool has_direction = distance > 0 && std::isfinite(distance);
  const bool has_up = camera.up.norm() > 0 && camera.up.allFinite();
  if (!has_direction || !has_up ||
      !(camera.field_of_view_deg > 0 && camera.field_of_view_deg < 180))
    throw std::invalid_argument(
        "a camera needs an eye away from its target, an upward direction, and a field of view "
        "between 0 and 180 degrees");
}

}  // namespace

ViewFrame look_along(const Vec3& backward, const Vec3& up) {
  ViewFrame frame;
  frame.backward = backward.normalized();
  Vec3 right = up.cross(frame.backward);
  if (right.norm() < 1e-6 * up.norm()) right = frame.backward.unitOrthogonal();
  frame.right = right.normalized();
  frame.up = frame.backward.cross(frame.right);
  return frame;
}

// The data from which a picture is drawn. Its memory is reused from picture to picture.
struct Renderer::Implementation {
  Implementation(int picture_width, int picture_height)
      : width(picture_width), height(picture_height) {}

  int width, height;
  TriangleBatch batch;
  ScreenGeometry geometry;
  DepthMap key_shadow{key_shadow_size};
  SrgbTable srgb;
};

Renderer::Renderer(int width, int height) {
  constexpr int largest_size = 8192;
  if (width < 1 || height < 1 || width > largest_size || height > largest_size) {
    throw std::runtime_error("pictures are 1 to 8192 pixels wide and high, not " +
                             std::to_string(width) + " x " + std::to_string(height));
  }
  implementation_ = std::make_unique<Implementation>(width, height);
}

Renderer::~Renderer() = default;

Picture Renderer::draw(std::span<const DrawnSurface> surfaces, const Camera& camera) {
  auto& [width, height, batch, geometry, key_shadow, srgb] = *implementation_;
  refuse_without_view(camera);
  refuse_out_of_range(surfaces, camera);
  const Vec3 up = camera.up.normalized();
  const ViewFrame frame = look_along(camera.eye - camera.target, up);
  const double slope = std::tan(camera.field_of_view_deg * std::numbers::pi / 360);
  const double distance = (camera.eye - camera.target).norm();
  const Perspective perspective{frame,  camera.eye - camera.target, width,
                                height, 0.5 * height / slope,       nearest_share * distance};
  const double widest = slope * std::max(1.0, static_cast<double>(width) / height);
  const double reach = 2 * widest * distance;
  const Vec3 horizontal = up.cross(frame.right);  // horizontal, away from the viewer
  const Vec3 sky = camera.lit_from_below ? Vec3(-up) : up;
  const Vec3 key = (0.80 * sky - 0.52 * frame.right - 0.40 * horizontal).normalized();

  batch.assemble(surfaces, camera.target);
  key_shadow.draw(batch, key, up, reach);
  // The projection adds vertices to the batch, but no triangles that cast shadows. The reach of
  // shadows is therefore computed before it.
  const double reach_of_sky = sky_reach(batch, reach);
  geometry.project(perspective, batch);
  add_sky_light(sky, reach_of_sky, batch);
  const Lights lights{perspective.eye.cast<float>(), sky.cast<float>(), key.cast<float>()};
  return draw_rows({surfaces, batch, geometry, lights, key_shadow, srgb},
                   Background(perspective, up, srgb), width, height);
}

}  // namespace weft::gpu
