// A band of rows of a picture: the triangles seen at four samples per pixel.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "gpu/screen_geometry.h"

namespace weft::gpu {

inline constexpr int samples_per_pixel = 4;
// Positions of the samples within a pixel. They form a rotated grid: no two samples have the same x
// or the same y.
inline constexpr std::array<float, samples_per_pixel> sample_x{0.375F, 0.875F, 0.125F, 0.625F};
inline constexpr std::array<float, samples_per_pixel> sample_y{0.125F, 0.375F, 0.625F, 0.875F};
inline constexpr std::uint32_t no_triangle = ~std::uint32_t{0};

// A block is four pixels side by side, processed together by vector instructions. Its samples are
// ordered: the first samples of all four pixels, then their second samples, and so on.
inline constexpr int pixels_per_block = 4;
inline constexpr int block_size = pixels_per_block * samples_per_pixel;

class SampleBand {
 public:
  static constexpr int rows = 16;  // few enough that the samples stay in the processor's cache

  explicit SampleBand(int width);

  // Empties the band. Its first row becomes row `top` of the picture.
  void begin(int top);
  // Draws a triangle: stores `number` at the samples where the triangle is the nearest so far.
  void draw(const ScreenTriangle& triangle, std::uint32_t number);
  // Draws a line, except where a triangle is nearer. Precondition: all triangles of the band have
  // been drawn.
  void draw(const ScreenLine& line);

  // Returns the numbers of the triangles seen at the samples of a block, or no_triangle at samples
  // without one. `row` is counted within the band.
  const std::uint32_t* triangles(int row, int block) const {
    return &triangles_[place(row, block)];
  }
  // Returns the factor (0..1) by which the lines darken a pixel. `row` is counted within the band.
  float brightness(int row, int col) const {
    return brightness_[static_cast<std::size_t>(row) * width_ + col];
  }

 private:
  std::size_t place(int row, int block) const {
    return (static_cast<std::size_t>(row) * blocks_ + block) * block_size;
  }

  int width_, blocks_, top_ = 0;
  std::vector<float> nearness_;           // nearness of the surface seen, by sample, 1/m
  std::vector<std::uint32_t> triangles_;  // number of the triangle seen, by sample
  std::vector<float> brightness_;         // factor by which lines darken, by pixel
};

}  // namespace weft::gpu
