#include "gpu/sky_light.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "gpu/depth_map.h"

namespace weft::gpu {
namespace {

using Eigen::Vector3f;

constexpr int light_count = 16;
constexpr int map_size = 192;

// Returns directions spread evenly over the upper hemisphere (a Fibonacci lattice), except near the
// horizon.
std::array<Vec3, light_count> sky_directions(const Vec3& up) {
  const Vec3 across = up.unitOrthogonal();
  const Vec3 along = up.cross(across);
  const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));
  std::array<Vec3, light_count> directions;
  for (int i = 0; i < light_count; ++i) {
    const double height = 1 - 0.9 * (i + 0.5) / light_count;
    const double radius = std::sqrt(1 - height * height);
    directions[i] = height * up + radius * (std::cos(golden_angle * i) * across +
                                            std::sin(golden_angle * i) * along);
  }
  return directions;
}

}  // namespace

double sky_reach(const TriangleBatch& batch, double reach) {
  const auto most = static_cast<float>(reach * reach);
  float farthest = 1e-6F * most;
  for (const BatchVertex& vertex : batch.vertices) {
    const float square = vertex.position().matrix().squaredNorm();
    if (square <= most) farthest = std::max(farthest, square);
  }
  constexpr float step = 1.2F;
  while (reach * reach > step * step * farthest) reach /= step;
  return reach;
}

void add_sky_light(const Vec3& up, double reach, TriangleBatch& batch) {
  DepthMap map(map_size);
  float full = 0;
  for (const Vec3& direction : sky_directions(up)) {
    map.draw(batch, direction, up, reach);
    const Vector3f light = direction.cast<float>();
    full += up.cast<float>().dot(light);
    for (BatchVertex& vertex : batch.vertices) {
      const Vector3f normal = vertex.normal().matrix();
      const float cosine = normal.dot(light);
      // The shadow map is sampled slightly off the surface, so that a surface does not shade
      // itself.
      const float offset = std::copysign(1.5F * map.texel(), cosine);
      const float lit = std::abs(cosine) * map.lit(vertex.position().matrix() + offset * normal);
      (cosine > 0 ? vertex.front_sky() : vertex.back_sky()) += lit;
    }
  }
  for (BatchVertex& vertex : batch.vertices) vertex.values.tail<2>() /= full;
}

}  // namespace weft::gpu
