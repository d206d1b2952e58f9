#include "gpu/shading.h"

#include <algorithm>
#include <cmath>

namespace weft::gpu {
namespace {

using Eigen::Vector3f;

float dot(float x, float y, float z, const Vector3f& v) {
  return x * v.x() + y * v.y() + z * v.z();
}

constexpr std::array<float, 3> key_colour{0.93F, 0.88F, 0.80F};
constexpr std::array<float, 3> sky_colour{0.42F, 0.46F, 0.52F};
constexpr std::array<float, 3> ground_colour{0.22F, 0.21F, 0.20F};

}  // namespace

SrgbTable::SrgbTable() {
  for (int i = 0; i <= steps; ++i) {
    const double value = std::min((i + 0.5) / steps, 1.0);
    const double encoded =
        value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
    values_[i] = static_cast<std::uint8_t>(std::lround(255 * encoded));
  }
}

void shade(const Lights& lights, const DepthMap& key_shadow, LitPoints& points) {
  LitPoints::Values key;
  for (int i = 0; i < points.count; ++i) {
    auto& [nx, ny, nz] = points.normal;
    const float scale =
        1 / std::sqrt(std::max(nx[i] * nx[i] + ny[i] * ny[i] + nz[i] * nz[i], 1e-30F));
    nx[i] *= scale;
    ny[i] *= scale;
    nz[i] *= scale;
    key[i] = std::max(dot(nx[i], ny[i], nz[i], lights.key), 0.0F);
  }
  // The shadow map is sampled slightly off the surface, so that a surface does not shade itself.
  const float offset = 2.5F * key_shadow.texel();
  for (int i = 0; i < points.count; ++i) {
    if (key[i] == 0) continue;
    const Vector3f position(points.position[0][i], points.position[1][i], points.position[2][i]);
    const Vector3f normal(points.normal[0][i], points.normal[1][i], points.normal[2][i]);
    key[i] *= key_shadow.softly_lit(position + offset * normal);
  }
  for (int i = 0; i < points.count; ++i) {
    const float nx = points.normal[0][i], ny = points.normal[1][i], nz = points.normal[2][i];
    float vx = lights.eye.x() - points.position[0][i];
    float vy = lights.eye.y() - points.position[1][i];
    float vz = lights.eye.z() - points.position[2][i];
    const float view_scale = 1 / std::sqrt(vx * vx + vy * vy + vz * vz);
    vx *= view_scale;
    vy *= view_scale;
    vz *= view_scale;
    const float ground = 0.5F - 0.5F * dot(nx, ny, nz, lights.up);
    const float fill = std::max(nx * vx + ny * vy + nz * vz, 0.0F);

    const float hx = vx + lights.key.x(), hy = vy + lights.key.y(), hz = vz + lights.key.z();
    const float half = std::max(nx * hx + ny * hy + nz * hz, 0.0F) /
                       std::sqrt(std::max(hx * hx + hy * hy + hz * hz, 1e-30F));
    const float half_4 = half * half * half * half, half_8 = half_4 * half_4;
    const float sheen = 0.05F * half_8 * half_8 * half_8 * key[i];
    const float grazing = (1 - fill) * (1 - fill);
    const float rim = 0.15F * grazing * grazing * (0.25F + 0.75F * points.sky[i]);
    for (int channel = 0; channel < 3; ++channel) {
      const float light = key[i] * key_colour[channel] + points.sky[i] * sky_colour[channel] +
                          ground * ground_colour[channel] + 0.10F * fill;
      points.light[channel][i] = points.albedo[channel][i] * (light + rim) + sheen;
    }
  }
}

}  // namespace weft::gpu
