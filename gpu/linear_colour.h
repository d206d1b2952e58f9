// Conversion of sRGB to linear colours.
#pragma once

#include <cmath>
#include <cstdint>

#include "gpu/renderer.h"

namespace weft::gpu {

// Returns the linear value of an sRGB value, 0..1.
inline float linear_of_srgb(float value) {
  return value <= 0.04045F ? value / 12.92F : std::pow((value + 0.055F) / 1.055F, 2.4F);
}

// Returns the linear colour of 0xRRGGBB in sRGB.
inline Colour linear_colour(std::uint32_t srgb) {
  const auto channel = [srgb](int shift) {
    return linear_of_srgb(static_cast<float>(srgb >> shift & 0xff) / 255.0F);
  };
  return {channel(16), channel(8), channel(0)};
}

}  // namespace weft::gpu
