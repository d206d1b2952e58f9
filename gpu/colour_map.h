// Maps from numbers to colours.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "gpu/renderer.h"

namespace weft::gpu {

// A map from numbers in 0..1 to colours, stored as a table.
class ColourMap {
 public:
  // Interpolates between evenly spaced colours, 0xRRGGBB in sRGB. Precondition: at least two
  // colours.
  explicit ColourMap(std::span<const std::uint32_t> srgb);
  // Returns the colour of the number `place`. A number outside 0..1 has the colour of the nearer
  // end. NaN has no_value_colour().
  const Colour& at(float place) const;

 private:
  static constexpr int steps = 1024;
  std::array<Colour, steps + 1> colours_;
};

// Viridis, from dark violet to yellow. Its lightness (CIE L*) grows evenly, so colour-blind readers
// see the same order.
const ColourMap& sequential_colours();
// Moreland's cool-to-warm map, from blue through a light grey at 0.5 to red. Both ends are equally
// dark.
const ColourMap& diverging_colours();
// The grey that stands for NaN. Neither of the two maps above contains it.
const Colour& no_value_colour();

}  // namespace weft::gpu
