// The background of a picture: a pale sky above the horizon and a ground below it.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "gpu/shading.h"
#include "gpu/view.h"

namespace weft::gpu {

class Background {
 public:
  // `up` is a unit vector.
  Background(const Perspective& perspective, const Vec3& up, const SrgbTable& srgb);
  // Writes row `row` of the picture (0 is the top), 3 bytes of sRGB per pixel.
  void draw_row(int row, std::span<std::uint8_t> rgb) const;

 private:
  static constexpr int steps = 4096;
  int width_;
  // The sine of the elevation of the line of sight at a pixel is (start + across * x + down * y) /
  // distance. x and y are relative to the picture's middle, and `distance` is from the eye, all in
  // pixels.
  float start_, across_, down_;
  float middle_x_, middle_y_, focal_length_;
  std::array<std::array<std::uint8_t, 3>, steps + 1>
      colours_;  // by the sine of the elevation, -1..1
};

}  // namespace weft::gpu
