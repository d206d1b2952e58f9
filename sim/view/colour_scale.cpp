#include "sim/view/colour_scale.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>
#include <sstream>

#include "gpu/bitmap_font.h"
#include "gpu/shading.h"

namespace weft::sim {
namespace {

// A scale is diverging only if the magnitude of each end is at least this share of the other end's.
constexpr double share_of_sign = 0.01;

// Longest line of text in characters, and sizes in pixels at text scale 1.
constexpr int characters_per_line = 16, margin = 10, line_height = gpu::character_height + 2;
// Sizes at text scale 1 (pixels). mark_gap separates a mark from its number, which may begin with a
// minus sign.
constexpr int bar_width = 18, mark_length = 3, mark_gap = 6;
constexpr int pixels_per_mark = 48;

constexpr gpu::PixelColour paper{250, 250, 250}, ink{34, 34, 34};

int text_scale(int height) { return std::max(1, height / 600); }

// Returns the text, or its beginning with dots if it is longer than a line.
std::string shortened(const std::string& text) {
  if (text.size() <= characters_per_line) return text;
  return text.substr(0, characters_per_line - 3) + "...";
}

// Splits a name into at most `most` lines, after underscores or spaces if possible. The last line
// of a longer name ends in dots.
std::vector<std::string> lines_of(const std::string& text, std::size_t most) {
  std::vector<std::string> lines;
  std::string rest = text.substr(0, most * characters_per_line + 1);
  while (rest.size() > characters_per_line) {
    if (lines.size() + 1 == most) {
      lines.push_back(shortened(rest));
      return lines;
    }
    const auto gap = rest.find_last_of("_ ", characters_per_line - 1);
    const std::size_t length = gap == std::string::npos ? characters_per_line : gap + 1;
    lines.push_back(rest.substr(0, length));
    rest.erase(0, length);
  }
  lines.push_back(rest);
  return lines;
}

// Returns the number as text, with enough digits to distinguish it from value + step, and for those
// before its point up to six, but with at most 9 digits.
std::string label_of(double value, double step) {
  // Infinite if the step is too small or too large for the quotient.
  const double digits = value == 0 ? 1 : std::ceil(std::log10(std::abs(value) / step)) + 1;
  const double before_point = std::floor(std::log10(std::max(std::abs(value), 1.0))) + 1;
  const double least = before_point <= 6 ? std::max(before_point, 2.0) : 2.0;
  std::ostringstream text;
  text.precision(static_cast<int>(std::clamp(digits, least, 9.0)));
  text << value;
  return text.str();
}

void fill(gpu::Picture& picture, int left, int top, int width, int height,
          const gpu::PixelColour& colour) {
  for (int y = top; y < top + height; ++y) {
    for (int x = left; x < left + width; ++x) {
      std::ranges::copy(colour, &picture.rgb[3 * (std::size_t{1} * y * picture.width + x)]);
    }
  }
}

gpu::PixelColour pixel_of(const gpu::Colour& colour) {
  static const gpu::SrgbTable srgb;
  return {srgb.of_linear(colour[0]), srgb.of_linear(colour[1]), srgb.of_linear(colour[2])};
}

// The bar of a legend, with its marks and their numbers, between the pixel rows `top` and `bottom`.
class Bar {
 public:
  Bar(gpu::Picture& picture, const Legend& legend, int left, int top, int bottom, int scale)
      : picture_(picture),
        legend_(legend),
        left_(left),
        top_(top),
        bottom_(bottom),
        scale_(scale) {}

  void draw() {
    const ColourScale& colours = legend_.scale;
    fill(picture_, left_ - 1, top_ - 1, width() + 2, bottom_ - top_ + 2, ink);
    for (int row = top_; row < bottom_; ++row) {
      const double share = (bottom_ - 1 - row) / static_cast<double>(bottom_ - 1 - top_);
      const double value = std::lerp(colours.low, colours.high, share);
      fill(picture_, left_, row, width(), 1, pixel_of(colours.map().at(colours.place_of(value))));
    }
    const std::vector<double> marks =
        round_marks(colours, (bottom_ - top_) / (scale_ * pixels_per_mark));
    // The difference of the ends may exceed the largest double.
    const double end_step = 0.01 * colours.high - 0.01 * colours.low;
    const double step = marks.size() > 1 ? marks[1] - marks[0] : 100 * end_step;
    mark(colours.low, (legend_.least < colours.low ? "<" : "") + label_of(colours.low, end_step));
    mark(colours.high, (legend_.most > colours.high ? ">" : "") + label_of(colours.high, end_step));
    const int space = scale_ * line_height;
    for (const double value : marks) {
      const int row = row_of(value);
      if (row - top_ < space || bottom_ - 1 - row < space) continue;
      mark(value, label_of(value, step));
    }
  }

 private:
  int width() const { return scale_ * bar_width; }
  int row_of(double value) const {
    const double share = legend_.scale.share_of(value);
    return bottom_ - 1 - static_cast<int>(std::lround(share * (bottom_ - 1 - top_)));
  }
  void mark(double value, const std::string& label) {
    const int row = row_of(value), length = scale_ * mark_length;
    fill(picture_, left_ + width(), row, length, 1, ink);
    gpu::draw_text(picture_, left_ + width() + length + scale_ * mark_gap,
                   row - scale_ * gpu::character_height / 2, scale_, ink, label);
  }

  gpu::Picture& picture_;
  const Legend& legend_;
  int left_, top_, bottom_, scale_;
};

}  // namespace

const gpu::ColourMap& ColourScale::map() const {
  return diverging ? gpu::diverging_colours() : gpu::sequential_colours();
}

double ColourScale::share_of(double value) const {
  const int exponent = -std::ilogb(std::max(std::abs(low), std::abs(high)));
  const double from = std::scalbn(low, exponent);
  return (std::scalbn(value, exponent) - from) / (std::scalbn(high, exponent) - from);
}

float ColourScale::place_of(double value) const {
  if (std::isnan(value)) return std::numeric_limits<float>::quiet_NaN();
  const double within = std::clamp(value, low, high);
  const double place = diverging ? 0.5 + 0.5 * (within / std::max(-low, high)) : share_of(within);
  return static_cast<float>(place);
}

ColourScale scale_between(double low, double high) {
  assert(low <= high && std::isfinite(low) && std::isfinite(high));
  if (low == high) {
    const double value = low;
    low = std::min(value, 0.0);
    high = value == 0 ? 1 : std::max(value, 0.0);
  }
  const bool diverging =
      low < 0 && high > 0 && std::min(-low, high) >= share_of_sign * std::max(-low, high);
  return {low, high, diverging};
}

std::vector<double> round_marks(const ColourScale& scale, int count) {
  // The difference of the ends may exceed the largest double.
  const double least_step = scale.high / std::max(count, 1) - scale.low / std::max(count, 1);
  const double power = std::pow(10, std::floor(std::log10(least_step)));
  double step = 10 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * power >= least_step) step = factor * power;
  }
  if (!std::isfinite(step))  // beyond the largest double, zero is the only round number
    return scale.low <= 0 && scale.high >= 0 ? std::vector<double>{0} : std::vector<double>{};
  // From this multiple of the step on, doubles do not distinguish neighbouring multiples.
  constexpr double most_steps = 1e15;
  if (!(std::max(std::abs(scale.low), std::abs(scale.high)) < most_steps * step)) return {};
  std::vector<double> marks;
  const auto first = static_cast<std::int64_t>(std::ceil(scale.low / step));
  const auto last = static_cast<std::int64_t>(std::floor(scale.high / step));
  for (std::int64_t number = first; number <= last; ++number)
    marks.push_back(std::clamp(static_cast<double>(number) * step, scale.low, scale.high));
  return marks;
}

int legend_width(int height) {
  return text_scale(height) * (2 * margin + characters_per_line * gpu::character_width);
}

gpu::Picture with_legend(const gpu::Picture& picture, const Legend& legend) {
  assert(picture.height >= least_legend_height);
  const int scale = text_scale(picture.height);
  gpu::Picture result{picture.width + legend_width(picture.height), picture.height, {}};
  result.rgb.resize(std::size_t{3} * result.width * result.height);
  const std::size_t from = std::size_t{3} * picture.width, to = std::size_t{3} * result.width;
  for (int row = 0; row < picture.height; ++row) {
    std::copy_n(&picture.rgb[from * row], from, &result.rgb[to * row]);
  }
  fill(result, picture.width, 0, result.width - picture.width, result.height, paper);

  // At most a third of the strip, which leaves room for the bar.
  const int most_lines = picture.height / (3 * scale * line_height) - 2;
  std::vector<std::string> head = lines_of(legend.name, std::max(1, most_lines));
  if (legend.magnitude) head.emplace_back("magnitude");
  if (!legend.units.empty() && legend.units != "1")
    head.push_back(shortened("[" + legend.units + "]"));
  const int left = picture.width + scale * margin;
  int top = scale * margin;
  for (const std::string& line : head) {
    gpu::draw_text(result, left, top, scale, ink, line);
    top += scale * line_height;
  }
  const int bottom = result.height - scale * (margin + gpu::character_height / 2);
  Bar(result, legend, left, top + scale * gpu::character_height, bottom, scale).draw();
  return result;
}

}  // namespace weft::sim
