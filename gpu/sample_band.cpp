#include "gpu/sample_band.h"

#include <algorithm>
#include <cmath>

namespace weft::gpu {
namespace {

using Lanes = std::array<float, block_size>;

// Returns the values of a quantity (plus `added`) at the samples of a block whose first pixel is at
// the origin.
Lanes at_samples(const ScreenPlane& plane, float added = 0) {
  Lanes values;
  for (int i = 0; i < block_size; ++i) {
    const int sample = i / pixels_per_block;
    values[i] = added + plane.at(static_cast<float>(i % pixels_per_block) + sample_x[sample],
                                 sample_y[sample]);
  }
  return values;
}

}  // namespace

SampleBand::SampleBand(int width)
    : width_(width),
      blocks_((width + pixels_per_block - 1) / pixels_per_block),
      nearness_(static_cast<std::size_t>(rows) * blocks_ * block_size),
      triangles_(nearness_.size()),
      brightness_(static_cast<std::size_t>(rows) * width) {}

void SampleBand::begin(int top) {
  top_ = top;
  std::ranges::fill(nearness_, 0.0F);
  std::ranges::fill(triangles_, no_triangle);
  std::ranges::fill(brightness_, 1.0F);
}

void SampleBand::draw(const ScreenTriangle& triangle, std::uint32_t number) {
  const ScreenBox& box = triangle.box;
  std::array<Lanes, 3> shares;
  for (int i = 0; i < 3; ++i) shares[i] = at_samples(triangle.shares[i], triangle.slack[i]);
  const Lanes nearness = at_samples(triangle.nearness);
  for (int row = std::max(box.top, top_); row <= std::min(box.bottom, top_ + rows - 1); ++row) {
    const auto y = static_cast<float>(row - box.top);
    for (int block = box.left / pixels_per_block; block <= box.right / pixels_per_block; ++block) {
      const auto x = static_cast<float>(block * pixels_per_block - box.left);
      std::array<float, 3> moved;
      for (int i = 0; i < 3; ++i) {
        moved[i] = triangle.shares[i].across * x + triangle.shares[i].down * y;
      }
      const float moved_nearness = triangle.nearness.across * x + triangle.nearness.down * y;
      const std::size_t first = place(row - top_, block);
      float* const depths = &nearness_[first];
      std::uint32_t* const numbers = &triangles_[first];
      for (int i = 0; i < block_size; ++i) {
        const float least = std::min(std::min(shares[0][i] + moved[0], shares[1][i] + moved[1]),
                                     shares[2][i] + moved[2]);
        const float depth = nearness[i] + moved_nearness;
        const bool is_seen = (least >= 0) & (depth > depths[i]);
        depths[i] = is_seen ? depth : depths[i];
        numbers[i] = is_seen ? number : numbers[i];
      }
    }
  }
}

void SampleBand::draw(const ScreenLine& line) {
  const ScreenBox& box = line.box;
  for (int row = std::max(box.top, top_); row <= std::min(box.bottom, top_ + rows - 1); ++row) {
    for (int col = box.left; col <= box.right; ++col) {
      const auto x = static_cast<float>(col - box.left), y = static_cast<float>(row - box.top);
      if (std::abs(line.aside.at(x + 0.5F, y + 0.5F)) > 1.25F) continue;
      const float* const depths =
          &nearness_[place(row - top_, col / pixels_per_block) + col % pixels_per_block];
      float darkness = 0;
      for (int sample = 0; sample < samples_per_pixel; ++sample) {
        const float along = line.along.at(x + sample_x[sample], y + sample_y[sample]);
        const float aside = line.aside.at(x + sample_x[sample], y + sample_y[sample]);
        if (along < 0 || along > 1 || std::abs(aside) > 0.5F) continue;
        if (line.nearness + along * line.nearness_slope < depths[sample * pixels_per_block])
          continue;
        darkness += (line.darkness + along * line.darkness_slope) / samples_per_pixel;
      }
      brightness_[static_cast<std::size_t>(row - top_) * width_ + col] *= 1 - darkness;
    }
  }
}

}  // namespace weft::gpu
