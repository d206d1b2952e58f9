#include "gpu/colour_map.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>

#include "gpu/linear_colour.h"

namespace weft::gpu {
namespace {

// Every fifteenth colour of viridis (S. van der Walt and N. Smith, 2015, released as CC0).
constexpr std::array<std::uint32_t, 18> viridis{
    0x440154, 0x481769, 0x472a7a, 0x433d84, 0x3d4e8a, 0x355e8d, 0x2e6d8e, 0x297b8e, 0x23898e,
    0x1f978b, 0x21a585, 0x2eb37c, 0x46c06f, 0x65cb5e, 0x89d548, 0xb0dd2f, 0xd8e219, 0xfde725};

// Every second of the 33 tabulated colours of K. Moreland, "Diverging color maps for scientific
// visualization", ISVC 2009.
constexpr std::array<std::uint32_t, 17> cool_to_warm{
    0x3b4cc0, 0x4d68d7, 0x6282ea, 0x779af7, 0x8db0fe, 0xa3c2ff, 0xb8d0f9, 0xccd9ee, 0xdddddd,
    0xecd3c5, 0xf5c4ad, 0xf7b194, 0xf49a7b, 0xec7f63, 0xde604d, 0xcb3e38, 0xb40426};

}  // namespace

ColourMap::ColourMap(std::span<const std::uint32_t> srgb) {
  assert(srgb.size() >= 2);
  const auto intervals = static_cast<double>(srgb.size() - 1);
  for (int i = 0; i <= steps; ++i) {
    const double at = intervals * i / steps;
    const auto below = std::min(static_cast<std::size_t>(at), srgb.size() - 2);
    const double share = at - static_cast<double>(below);
    for (int channel = 0; channel < 3; ++channel) {
      const int shift = 16 - 8 * channel;
      const double low = srgb[below] >> shift & 0xff, high = srgb[below + 1] >> shift & 0xff;
      colours_[i][channel] =
          linear_of_srgb(static_cast<float>((low + share * (high - low)) / 255.0));
    }
  }
}

const Colour& ColourMap::at(float place) const {
  if (std::isnan(place)) return no_value_colour();
  return colours_[static_cast<std::size_t>(std::lround(steps * std::clamp(place, 0.0F, 1.0F)))];
}

const ColourMap& sequential_colours() {
  static const ColourMap map(viridis);
  return map;
}

const ColourMap& diverging_colours() {
  static const ColourMap map(cool_to_warm);
  return map;
}

const Colour& no_value_colour() {
  static const Colour grey = linear_colour(0x707070);
  return grey;
}

}  // namespace weft::gpu
