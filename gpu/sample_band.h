// A band of rows of a picture: the triangles seen at four samples per pixel.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "gpu/screen_geometry.h"

namespace weft::gpu {

inline constexpr int samples_per_pixel = 4;
// Positions of the samples within a pixel: a rotated grid, in which no two share a row or a column.
inline constexpr std::array<float, samples_per_pixel> sample_x{0.375F, 0.875F, 0.125F, 0.625F};
inline constexpr std::array<float, samples_per_pixel> sample_y{0.125F, 0.375F, 0.625F, 0.875F};
inline constexpr std::uint32_t no_triangle = ~std::uint32_t{0};

// A block is four pixels side by side, processed together by vector instructions. Its samples are
// ordered: the first samples of all four pixels, then their second samples, and so on.
inline constexpr int pixels_per_block = 4;
inline constexpr int block_size = pixels_per_block * samples_per_pixel;

class SampleBand {
 public:
  static constexpr int rows = 16;  // few enough for the processor's cache

  explicit SampleBand(int width);

  // Empties the band and places it at row `top` of the picture.
  void begin(int top);
  // Draws a triangle where it is the nearest so far. There triangles() returns `number`.
  void draw(const ScreenTriangle& triangle, std::uint32_t number);
  // Draws a line on the triangles. Precondition: all triangles of the band have been drawn.
  void draw(const ScreenLine& line);

  // Returns the triangles seen at the samples of a block, or no_triangle where there is none.
  const std::uint32_t* triangles(int row, int block) const {
    return &triangles_[place(row, block)];
  }
  // Returns the share of a pixel's light that lines let through, 0..1.
  float brightness(int row, int col) const {
    return brightness_[static_cast<std::size_t>(row) * width_ + col];
  }

 private:
  std::size_t place(int row, int block) const {
    return (static_cast<std::size_t>(row) * blocks_ + block) * block_size;
  }

  int width_, blocks_, top_ = 0;
  std::vector<float> nearness_;           // by sample, 1/m
  std::vector<std::uint32_t> triangles_;  // by sample
  std::vector<float> brightness_;         // by pixel
};

}  // namespace weft::gpu
