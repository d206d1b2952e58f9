// The colours of bodies, of obstacles, and of spheres that touch each other.
#include <cassert>
#include <cstdint>

#include "gpu/linear_colour.h"

namespace weft::gpu {
namespace {

// Returns the colours of a surface whose back has the hue of the front but is paler.
SurfaceColours with_pale_back(const Colour& front) {
  SurfaceColours colours{front, front};
  for (float& channel : colours.back) channel = 0.45F * channel + 0.55F * 0.62F;
  return colours;
}

}  // namespace

SurfaceColours palette(int index) {
  assert(index >= 0);
  // The hues are far apart at similar lightness. Colour-blind viewers can tell neighbours in the
  // list apart.
  constexpr std::array<std::uint32_t, 8> srgb{0xc8553d, 0x2f6690, 0xe3a12f, 0x3f8f7a,
                                              0x7d4f8c, 0x8aa83c, 0xb8436d, 0x4a9cc4};
  return with_pale_back(linear_colour(srgb[static_cast<std::size_t>(index) % srgb.size()]));
}

SurfaceColours obstacle_colours() {
  const Colour grey = linear_colour(0xa3a6aa);
  return {grey, grey};
}

Colour touching_colour() { return linear_colour(0xd0021b); }

}  // namespace weft::gpu
