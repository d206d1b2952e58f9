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
  // The line of sight through a pixel rises at an angle whose sine is
  //   (start_ + across_ * x + down_ * y) / sqrt(focal_length_^2 + x^2 + y^2).
  // x and y (pixels) are counted from the middle of the picture, y downwards.
  float start_, across_, down_;
  float middle_x_, middle_y_, focal_length_;
  // sRGB colours by the sine s of the elevation. The entry for s has the index (1 + s) steps / 2,
  // rounded down.
  std::array<std::array<std::uint8_t, 3>, steps + 1> colours_;
};

}  // namespace weft::gpu
