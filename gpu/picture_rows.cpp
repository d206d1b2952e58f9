#include "gpu/picture_rows.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "gpu/colour_map.h"
#include "gpu/sample_band.h"

namespace weft::gpu {
namespace {

// Lists, for each band of rows, the indices of the triangles or lines that may touch the band.
std::vector<std::vector<std::uint32_t>> by_band(const auto& drawn, int height) {
  std::vector<std::vector<std::uint32_t>> bands((height + SampleBand::rows - 1) / SampleBand::rows);
  for (std::uint32_t number = 0; number < drawn.size(); ++number) {
    const ScreenBox& box = drawn[number].box;
    for (int band = box.top / SampleBand::rows; band <= box.bottom / SampleBand::rows; ++band) {
      bands[band].push_back(number);
    }
  }
  return bands;
}

// Samples of a pixel that see one triangle or its neighbours. They are lit as one point, at the
// mean position of the samples that see `triangle` itself.
struct Fragment {
  std::uint32_t triangle = no_triangle;
  int samples = 0, samples_in_triangle = 0;
  // Sums of the positions (pixels, within the pixel) of the samples that see `triangle`.
  float x = 0, y = 0;
};

// Lights the surfaces seen in a row of pixels and draws them over the background.
class RowPainter {
 public:
  RowPainter(const LitScene& scene, int width)
      : scene_(scene), seen_(width), sums_(std::size_t{3} * width) {}

  void paint(const SampleBand& band, int row_in_band, int row, std::span<std::uint8_t> rgb);

 private:
  void add_pixel(const std::uint32_t* triangles, int col, int row);
  bool are_neighbours(std::uint32_t first, std::uint32_t second) const;
  void add_fragment(const Fragment& fragment, int col, int row);
  void light_fragments();

  LitScene scene_;
  LitPoints points_;
  std::array<int, LitPoints::capacity> columns_;  // column of the pixel, by point
  std::array<int, LitPoints::capacity> samples_;  // number of samples, by point
  std::vector<int> seen_;                         // number of samples that see a surface, by column
  std::vector<int> sums_;  // by column and channel: sum of sRGB values over the samples in seen_
};

// Returns true if two triangles share a corner and show the same side. Samples that see such
// triangles are lit together.
bool RowPainter::are_neighbours(std::uint32_t first, std::uint32_t second) const {
  const ScreenTriangle& a = scene_.geometry.triangles[first];
  const ScreenTriangle& b = scene_.geometry.triangles[second];
  if (a.is_front != b.is_front) return false;
  return std::ranges::any_of(a.corners, [&b](std::uint32_t corner) {
    return (corner == b.corners[0]) | (corner == b.corners[1]) | (corner == b.corners[2]);
  });
}

void RowPainter::add_pixel(const std::uint32_t* triangles, int col, int row) {
  const std::uint32_t first = triangles[0];
  if (first != no_triangle && first == triangles[pixels_per_block] &&
      first == triangles[2 * pixels_per_block] && first == triangles[3 * pixels_per_block]) {
    add_fragment({first, samples_per_pixel, samples_per_pixel, 2, 2}, col, row);
    return;
  }
  std::array<Fragment, samples_per_pixel> fragments;
  int count = 0;
  for (int sample = 0; sample < samples_per_pixel; ++sample) {
    const std::uint32_t triangle = triangles[sample * pixels_per_block];
    if (triangle == no_triangle) continue;
    int i = 0;
    while (i < count && fragments[i].triangle != triangle &&
           !are_neighbours(fragments[i].triangle, triangle)) {
      ++i;
    }
    Fragment& fragment = fragments[i];
    if (i == count) {
      ++count;
      fragment.triangle = triangle;
    }
    ++fragment.samples;
    if (fragment.triangle != triangle) continue;
    ++fragment.samples_in_triangle;
    fragment.x += sample_x[sample];
    fragment.y += sample_y[sample];
  }
  for (int i = 0; i < count; ++i) add_fragment(fragments[i], col, row);
}

void RowPainter::add_fragment(const Fragment& fragment, int col, int row) {
  const ScreenTriangle& triangle = scene_.geometry.triangles[fragment.triangle];
  const auto divisor = static_cast<float>(fragment.samples_in_triangle);
  const float x = static_cast<float>(col - triangle.box.left) + fragment.x / divisor;
  const float y = static_cast<float>(row - triangle.box.top) + fragment.y / divisor;
  std::array<float, 3> weights;
  float sum = 0;
  for (int i = 0; i < 3; ++i) {
    weights[i] = std::max(triangle.shares[i].at(x, y), 0.0F) * triangle.corner_nearness[i];
    sum += weights[i];
  }
  Eigen::Array<float, 8, 1> values = Eigen::Array<float, 8, 1>::Zero();
  for (int i = 0; i < 3; ++i) {
    values += weights[i] * scene_.batch.vertices[triangle.corners[i]].values;
  }
  values /= sum;
  const int point = points_.count++;
  const float side = triangle.is_front ? 1.0F : -1.0F;
  const DrawnSurface& surface = scene_.surfaces[triangle.surface];
  Colour albedo = triangle.is_front ? surface.front_colour : surface.back_colour;
  if (surface.colour_map != nullptr) {
    float place = 0;
    for (int i = 0; i < 3; ++i) place += weights[i] * scene_.batch.places[triangle.corners[i]];
    albedo = surface.colour_map->at(place / sum);
  }
  for (int axis = 0; axis < 3; ++axis) {
    points_.position[axis][point] = values[axis];
    points_.normal[axis][point] = side * values[3 + axis];
    points_.albedo[axis][point] = albedo[axis];
  }
  points_.sky[point] = triangle.is_front ? values[6] : values[7];
  columns_[point] = col;
  samples_[point] = fragment.samples;
  if (points_.count == LitPoints::capacity) light_fragments();
}

void RowPainter::light_fragments() {
  shade(scene_.lights, scene_.key_shadow, points_);
  for (int point = 0; point < points_.count; ++point) {
    const int col = columns_[point];
    seen_[col] += samples_[point];
    for (int channel = 0; channel < 3; ++channel) {
      sums_[3 * col + channel] +=
          samples_[point] * scene_.srgb.of_linear(points_.light[channel][point]);
    }
  }
  points_.count = 0;
}

void RowPainter::paint(const SampleBand& band, int row_in_band, int row,
                       std::span<std::uint8_t> rgb) {
  std::ranges::fill(seen_, 0);
  std::ranges::fill(sums_, 0);
  const int width = static_cast<int>(seen_.size());
  for (int first = 0; first < width; first += pixels_per_block) {
    const std::uint32_t* const triangles = band.triangles(row_in_band, first / pixels_per_block);
    std::uint32_t all = no_triangle;
    for (int i = 0; i < block_size; ++i) all &= triangles[i];
    if (all == no_triangle) continue;
    for (int col = first; col < std::min(first + pixels_per_block, width); ++col) {
      add_pixel(triangles + (col - first), col, row);
    }
  }
  light_fragments();
  for (int col = 0; col < width; ++col) {
    // A line at the edge of a surface also covers background. Pixels without surface or line are
    // skipped.
    const float brightness = band.brightness(row_in_band, col);
    if (seen_[col] == 0 && brightness == 1) continue;
    const float share = brightness / samples_per_pixel;
    for (int channel = 0; channel < 3; ++channel) {
      const int behind = (samples_per_pixel - seen_[col]) * rgb[3 * col + channel];
      const auto sum = static_cast<float>(sums_[3 * col + channel] + behind);
      rgb[3 * col + channel] = static_cast<std::uint8_t>(std::nearbyint(share * sum));
    }
  }
}

}  // namespace

Picture draw_rows(const LitScene& scene, const Background& background, int width, int height) {
  const auto triangles = by_band(scene.geometry.triangles, height);
  const auto lines = by_band(scene.geometry.lines, height);
  const std::size_t row_bytes = std::size_t{3} * width;
  Picture picture{width, height, std::vector<std::uint8_t>(row_bytes * height)};
  SampleBand band(width);
  RowPainter painter(scene, width);
  for (std::size_t number = 0; number < triangles.size(); ++number) {
    const int top = static_cast<int>(number) * SampleBand::rows;
    band.begin(top);
    for (const std::uint32_t triangle : triangles[number]) {
      band.draw(scene.geometry.triangles[triangle], triangle);
    }
    for (const std::uint32_t line : lines[number]) band.draw(scene.geometry.lines[line]);
    for (int row = top; row < std::min(top + SampleBand::rows, height); ++row) {
      const auto rgb = std::span(picture.rgb).subspan(row_bytes * row, row_bytes);
      background.draw_row(row, rgb);
      painter.paint(band, row - top, row, rgb);
    }
  }
  return picture;
}

}  // namespace weft::gpu
