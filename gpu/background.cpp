#include "gpu/background.h"

#include <algorithm>
#include <cmath>

namespace weft::gpu {
namespace {

constexpr std::array<float, 3> ground{0.60F, 0.60F, 0.61F};
constexpr std::array<float, 3> horizon{0.90F, 0.91F, 0.92F};
constexpr std::array<float, 3> zenith{0.66F, 0.74F, 0.84F};

std::array<std::uint8_t, 3> colour_at(float elevation, const SrgbTable& srgb) {
  const std::array<float, 3>& end = elevation < 0 ? ground : zenith;
  const float way = std::min(std::abs(elevation) / 0.9F, 1.0F);
  const float share = way * way * (3 - 2 * way);
  std::array<std::uint8_t, 3> colour;
  for (int channel = 0; channel < 3; ++channel) {
    colour[channel] = srgb.of_linear(horizon[channel] + share * (end[channel] - horizon[channel]));
  }
  return colour;
}

}  // namespace

Background::Background(const Perspective& perspective, const Vec3& up, const SrgbTable& srgb)
    : width_(perspective.width),
      start_(static_cast<float>(-perspective.focal_length * perspective.frame.backward.dot(up))),
      across_(static_cast<float>(perspective.frame.right.dot(up))),
      down_(static_cast<float>(-perspective.frame.up.dot(up))),
      middle_x_(0.5F * static_cast<float>(perspective.width)),
      middle_y_(0.5F * static_cast<float>(perspective.height)),
      focal_length_(static_cast<float>(perspective.focal_length)) {
  for (int i = 0; i <= steps; ++i) {
    colours_[i] = colour_at(static_cast<float>(2 * i + 1) / steps - 1, srgb);
  }
}

void Background::draw_row(int row, std::span<std::uint8_t> rgb) const {
  const float y = static_cast<float>(row) + 0.5F - middle_y_;
  const float squares = focal_length_ * focal_length_ + y * y;
  for (int col = 0; col < width_; ++col) {
    const float x = static_cast<float>(col) + 0.5F - middle_x_;
    const float sine = (start_ + across_ * x + down_ * y) / std::sqrt(squares + x * x);
    const float step = std::clamp(0.5F + 0.5F * sine, 0.0F, 1.0F) * steps;
    std::ranges::copy(colours_[static_cast<std::size_t>(step)], &rgb[3 * std::size_t(col)]);
  }
}

}  // namespace weft::gpu
