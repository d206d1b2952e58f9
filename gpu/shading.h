// The light that surfaces send to the eye.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "gpu/depth_map.h"

namespace weft::gpu {

// A table of the 8-bit sRGB values of linear ones.
class SrgbTable {
 public:
  SrgbTable();
  // Values outside 0..1 count as the nearer end.
  std::uint8_t of_linear(float value) const {
    return values_[static_cast<int>(std::clamp(value, 0.0F, 1.0F) * steps)];
  }

 private:
  static constexpr int steps = 1 << 14;
  std::array<std::uint8_t, steps + 1> values_;  // each for the middle of a step
};

// Points of surfaces that vector instructions light together: each quantity is an array.
struct LitPoints {
  static constexpr int capacity = 256;
  using Values = std::array<float, capacity>;

  int count = 0;
  std::array<Values, 3> position;  // m
  std::array<Values, 3> normal;    // towards the eye, any length
  Values sky;                      // light of the sky (gpu/sky_light.h)
  std::array<Values, 3> albedo;    // linear
  std::array<Values, 3> light;     // result of shade(): linear red, green and blue
};

struct Lights {
  Eigen::Vector3f eye, up, key;  // the eye's position; directions up and towards the key light
};

// Lights the points by Lambert's law under a key light with the shadows of `key_shadow`, the sky
// and the ground, with a faint sheen and a rim.
void shade(const Lights& lights, const DepthMap& key_shadow, LitPoints& points);

}  // namespace weft::gpu
