// The light that surfaces reflect to the eye.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "gpu/depth_map.h"

namespace weft::gpu {

// A table of 8-bit sRGB values by linear value.
class SrgbTable {
 public:
  SrgbTable();
  // Returns the sRGB value of a linear value, which is clamped to 0..1.
  std::uint8_t of_linear(float value) const {
    return values_[static_cast<int>(std::clamp(value, 0.0F, 1.0F) * steps)];
  }

 private:
  static constexpr int steps = 1 << 14;
  // Entry i is the sRGB value at the middle of step i of the linear values.
  std::array<std::uint8_t, steps + 1> values_;
};

// Points of surfaces that are lit together. Every quantity is an array, for vector instructions.
struct LitPoints {
  static constexpr int capacity = 256;
  using Values = std::array<float, capacity>;

  int count = 0;
  std::array<Values, 3> position;  // m
  std::array<Values, 3> normal;    // points to the eye's side of the surface; any length
  Values sky;                      // light of the sky (gpu/sky_light.h)
  std::array<Values, 3> albedo;    // linear red, green and blue
  std::array<Values, 3> light;     // result of shade(): linear red, green and blue
};

struct Lights {
  // Position of the eye (m), unit vector upwards, unit vector towards the key light.
  Eigen::Vector3f eye, up, key;
};

// Lights the points by Lambert's law, with a faint sheen and a rim. The light comes from the key
// light (shadowed by `key_shadow`), the sky, the ground and, faintly, the eye.
void shade(const Lights& lights, const DepthMap& key_shadow, LitPoints& points);

}  // namespace weft::gpu
