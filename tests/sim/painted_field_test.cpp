#include "sim/view/painted_field.h"

#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>

#include "bsi/shapes.h"
#include "gpu/bitmap_font.h"
#include "sim/view/render_trajectory.h"
#include "tests/sim/field_trajectory.h"

namespace weft::sim::painted_field_test {
namespace {

TEST(ColourScale, GivesTheEndsOfTheMapToTheEndsOfTheRange) {
  const ColourScale scale = scale_between(2, 6);
  EXPECT_FALSE(scale.diverging);
  EXPECT_EQ(scale.place_of(2), 0);
  EXPECT_EQ(scale.place_of(6), 1);
  EXPECT_EQ(scale.place_of(3), 0.25F);
  EXPECT_EQ(scale.place_of(-5), 0);
  EXPECT_EQ(scale.place_of(1e9), 1);
  EXPECT_TRUE(std::isnan(scale.place_of(std::numeric_limits<double>::quiet_NaN())));
}

TEST(ColourScale, HasZeroInTheMiddleOfColoursForBothSigns) {
  const ColourScale scale = scale_between(-2, 6);
  EXPECT_TRUE(scale.diverging);
  EXPECT_EQ(scale.low, -2);
  EXPECT_EQ(scale.high, 6);
  EXPECT_EQ(scale.place_of(0), 0.5F);
  EXPECT_EQ(scale.place_of(6), 1);
  // Equal magnitudes are equally far from the middle.
  EXPECT_FLOAT_EQ(scale.place_of(2) - 0.5F, 0.5F - scale.place_of(-2));
  // Rounding below zero makes no sign.
  EXPECT_FALSE(scale_between(-1e-9, 6).diverging);
  EXPECT_FALSE(scale_between(-6, 0).diverging);
}

TEST(ColourScale, WidensARangeOfOneNumber) {
  for (const auto& [value, low, high] : {std::array<double, 3>{3, 0, 3}, {-3, -3, 0}, {0, 0, 1}}) {
    const ColourScale scale = scale_between(value, value);
    EXPECT_EQ(scale.low, low);
    EXPECT_EQ(scale.high, high);
  }
}

TEST(ColourScale, HasRoundMarksWithinTheRange) {
  EXPECT_EQ(round_marks(scale_between(0, 1), 5),
            (std::vector<double>{0, 0.2, 2 * 0.2, 3 * 0.2, 4 * 0.2, 1}));
  const std::vector<double> fives = round_marks(scale_between(-3, 17), 4);
  EXPECT_EQ(fives, (std::vector<double>{0, 5, 10, 15}));
  EXPECT_FALSE(std::signbit(fives[0]));
  for (const double size : {1e-12, 0.3, 7.7, 1e9}) {
    for (int count = 1; count < 20; ++count) {
      const ColourScale scale = scale_between(size, 2.5 * size);
      const std::vector<double> marks = round_marks(scale, count);
      EXPECT_LE(marks.size(), static_cast<std::size_t>(count) + 1);
      for (const double mark : marks) {
        EXPECT_GE(mark, scale.low * (1 - 1e-12));
        EXPECT_LE(mark, scale.high * (1 + 1e-12));
      }
    }
  }
}

// Returns a picture of one colour, widened by the legend.
gpu::Picture legend_beside(const Legend& legend, int height = least_legend_height) {
  gpu::Picture picture{4, height, {}};
  picture.rgb.assign(std::size_t{12} * height, 7);
  return with_legend(picture, legend);
}

TEST(ColourScale, HasFewMarksAtTheEndsOfWhatDoublesHold) {
  constexpr double most = std::numeric_limits<double>::max();
  constexpr double least = std::numeric_limits<double>::denorm_min();
  constexpr double normal = std::numeric_limits<double>::min();
  const double next = std::nextafter(1.0, 2.0);
  for (const auto& [low, high] : {std::pair(1.0, next),
                                  {-next, -1.0},
                                  {1e300, std::nextafter(1e300, most)},
                                  {0.0, least},
                                  {-least, least},
                                  {0.0, 3 * least},
                                  {-least, 1.0},
                                  {0.0, normal},
                                  {-most, most},
                                  {-most, 0.0},
                                  {0.0, most},
                                  {0.5 * most, most},
                                  {1e-300, most},
                                  {-most, least}}) {
    const ColourScale scale = scale_between(low, high);
    EXPECT_EQ(scale.share_of(low), 0);
    EXPECT_EQ(scale.share_of(high), 1);
    EXPECT_EQ(scale.place_of(low), 0);
    EXPECT_EQ(scale.place_of(high), 1);
    for (int count = 1; count < 20; ++count) {
      const std::vector<double> marks = round_marks(scale, count);
      EXPECT_LE(marks.size(), static_cast<std::size_t>(count) + 1) << low << ' ' << high;
      EXPECT_TRUE(std::ranges::is_sorted(marks));
      for (const double mark : marks) EXPECT_TRUE(low <= mark && mark <= high) << mark;
    }
    // The bar has the first colour at its bottom and the last at its top.
    const gpu::Picture picture = legend_beside({"x", "", false, scale, low, high}, 400);
    const auto pixel = [&](int row) { return &picture.rgb[(row * picture.width + 20) * 3]; };
    const auto is_ink = [&](int row) { return pixel(row)[0] == 34 && pixel(row)[1] == 34; };
    int top = 25, bottom = picture.height - 1;
    while (!is_ink(top)) ++top;
    while (!is_ink(bottom)) --bottom;
    ASSERT_GT(bottom - top, 300);
    EXPECT_NEAR(pixel(top + 1)[0], scale.diverging ? 180 : 253, 1) << low << ' ' << high;
    EXPECT_NEAR(pixel(bottom - 1)[0], scale.diverging ? 59 : 68, 1) << low << ' ' << high;
  }
}

TEST(Legend, HasRoomForNamesAndUnitsOfAnyLength) {
  Legend legend{std::string(5000, 'w'), std::string(3000, 'u'), true, scale_between(0, 1), 0, 1};
  for (const int height : {least_legend_height, 400, 1300}) {
    const gpu::Picture picture = legend_beside(legend, height);
    EXPECT_EQ(picture.rgb.size(), std::size_t{3} * picture.width * height);
    for (int row = 0; row < height; ++row) {
      const auto* start = &picture.rgb[std::size_t{3} * row * picture.width];
      EXPECT_TRUE(std::all_of(start, start + 12, [](int channel) { return channel == 7; }));
    }
  }
}

struct Pixels {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;

  std::array<int, 3> at(int col, int row) const {
    const std::uint8_t* pixel = &rgb[3 * (std::size_t{1} * row * width + col)];
    return {pixel[0], pixel[1], pixel[2]};
  }
};

Pixels read_png(const std::string& path) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&image, path.c_str()) == 0) return {};
  image.format = PNG_FORMAT_RGB;
  Pixels pixels{static_cast<int>(image.width), static_cast<int>(image.height),
                std::vector<std::uint8_t>(PNG_IMAGE_SIZE(image))};
  png_image_finish_read(&image, nullptr, pixels.rgb.data(), 0, nullptr);
  return pixels;
}

// True if a line of text stands somewhere in the legend.
bool shows(const Pixels& pixels, const std::string& text) {
  constexpr gpu::PixelColour paper{250, 250, 250}, ink{34, 34, 34};
  const int width = static_cast<int>(text.size()) * gpu::character_width;
  gpu::Picture line{width, gpu::character_height, {}};
  for (int i = 0; i < width * gpu::character_height; ++i)
    line.rgb.insert(line.rgb.end(), paper.begin(), paper.end());
  gpu::draw_text(line, 0, 0, 1, ink, text);
  const auto is_at = [&](int left, int top) {
    for (int y = 0; y < line.height; ++y) {
      const auto* row = &pixels.rgb[3 * (std::size_t{1} * (top + y) * pixels.width + left)];
      if (!std::equal(row, row + 3 * width, &line.rgb[std::size_t{3} * y * width])) return false;
    }
    return true;
  };
  for (int top = 0; top + line.height <= pixels.height; ++top) {
    for (int left = pixels.width - legend_width(pixels.height); left + width <= pixels.width;
         ++left) {
      if (is_at(left, top)) return true;
    }
  }
  return false;
}

// Mean colour, over the scene beside the legend, of the pixels that are neither background nor the
// grey of obstacles: those are the sheet's.
std::array<double, 3> mean_of_sheet(const Pixels& pixels) {
  std::array<double, 3> mean{};
  int count = 0;
  for (int row = 0; row < pixels.height; ++row) {
    for (int col = 0; col < pixels.width - legend_width(pixels.height); ++col) {
      const auto [red, green, blue] = pixels.at(col, row);
      if (std::max({red, green, blue}) - std::min({red, green, blue}) < 45) continue;
      mean[0] += red;
      mean[1] += green;
      mean[2] += blue;
      ++count;
    }
  }
  EXPECT_GT(count, 2000);
  for (double& channel : mean) channel /= std::max(count, 1);
  return mean;
}

// Colours of the map under the light of a picture: brighter or darker, of the same hue.
void expect_violet(const std::array<double, 3>& mean) {
  EXPECT_GT(mean[0], 1.3 * mean[1]);
  EXPECT_GT(mean[2], 1.5 * mean[1]);
}
void expect_teal(const std::array<double, 3>& mean) {
  EXPECT_GT(mean[1], 2 * mean[0]);
  EXPECT_GT(mean[2], 2 * mean[0]);
}
void expect_yellow(const std::array<double, 3>& mean) {
  EXPECT_GT(mean[0], 2 * mean[2]);
  EXPECT_GT(mean[1], 2 * mean[2]);
}

class PaintedPictures : public FieldTrajectory {
 protected:
  RenderOptions painted(const std::string& field) const {
    RenderOptions options;
    options.width = 320;
    options.height = 240;
    options.movie = false;
    options.colour_field = field;
    return options;
  }
  std::string pictures() const { return path("pictures"); }
  Pixels picture(int frame) const {
    return read_png(pictures() + "/frame_0000" + std::to_string(frame) + ".png");
  }
  std::string refusal(const RenderOptions& options) const {
    try {
      render_trajectory(path("run.h5"), pictures(), options);
      return "";
    } catch (const RenderUsageError& error) {
      return error.what();
    }
  }
};

// The field is 0, 1 and 2 on the whole sheet in three frames: both ends of the colours and their
// middle, since all frames have one range.
TEST_F(PaintedPictures, ShowAKnownFieldInKnownColours) {
  write_frames(3, [](int frame, const Vec3&) { return static_cast<double>(frame); });
  const RenderReport report = render_trajectory(path("run.h5"), pictures(), painted("strain"));
  EXPECT_EQ(report.pictures, 3);
  EXPECT_EQ(report.least, 0);
  EXPECT_EQ(report.most, 2);
  EXPECT_EQ(report.plain_bodies, (std::vector<std::string>{"floor"}));
  expect_violet(mean_of_sheet(picture(0)));
  expect_teal(mean_of_sheet(picture(1)));
  expect_yellow(mean_of_sheet(picture(2)));
}

TEST_F(PaintedPictures, HaveTheRangeOfTheFramesDrawnOrTheOneGiven) {
  write_frames(4, [](int frame, const Vec3&) { return frame == 1 ? 100.0 : frame; });
  RenderOptions options = painted("strain");
  options.every = 2;  // frames 0, 2 and 3
  EXPECT_EQ(render_trajectory(path("run.h5"), pictures(), options).most, 3);
  expect_yellow(mean_of_sheet(picture(3)));
  EXPECT_FALSE(std::filesystem::exists(pictures() + "/frame_00001.png"));

  options.every = 1;
  options.colour_range = {2, 4};
  EXPECT_EQ(render_trajectory(path("run.h5"), pictures(), options).most, 100);
  expect_violet(mean_of_sheet(picture(0)));
  expect_yellow(mean_of_sheet(picture(1)));
  expect_violet(mean_of_sheet(picture(2)));
  expect_teal(mean_of_sheet(picture(3)));
  EXPECT_TRUE(shows(picture(0), "<2"));
  EXPECT_TRUE(shows(picture(0), ">4"));
}

// Colours go from one end to the other across the sheet, in the direction of the field.
TEST_F(PaintedPictures, ChangeColourAcrossABody) {
  write_frames(1, [](int, const Vec3& place) { return place.x(); });
  render_trajectory(path("run.h5"), pictures(), painted("strain"));
  const Pixels pixels = picture(0);
  // The camera sees x grow to the right.
  Pixels left = pixels, right = pixels;
  const auto keep = [&](Pixels& part, int first, int last) {
    for (int row = 0; row < part.height; ++row) {
      for (int col = 0; col < part.width; ++col) {
        if (col >= first && col < last) continue;
        std::fill_n(&part.rgb[3 * (std::size_t{1} * row * part.width + col)], 3, 255);
      }
    }
  };
  keep(left, 0, 70);
  keep(right, 140, 320);
  const auto mean = [](const Pixels& part) {
    std::array<double, 3> sum{};
    for (int row = 0; row < part.height; ++row) {
      for (int col = 0; col < part.width - legend_width(part.height); ++col) {
        const auto [red, green, blue] = part.at(col, row);
        if (std::max({red, green, blue}) - std::min({red, green, blue}) < 45) continue;
        sum[0] += red;
        sum[1] += green;
        sum[2] += blue;
      }
    }
    return sum;
  };
  EXPECT_GT(mean(left)[2], 1.3 * mean(left)[0]);
  EXPECT_GT(mean(right)[0], 1.3 * mean(right)[2]);
}

TEST_F(PaintedPictures, HaveALegendAtTheirRight) {
  write_frames(2, [](int frame, const Vec3&) { return -1.5 * frame; });
  render_trajectory(path("run.h5"), pictures(), painted("strain"));
  const Pixels pixels = picture(1);
  EXPECT_EQ(pixels.width, 320);
  EXPECT_EQ(pixels.height, 240);
  for (const char* text : {"strain", "-1.5", "-1.0", "0"}) {
    EXPECT_EQ(shows(pixels, text), std::string(text) != "-1.0") << text;
  }
  EXPECT_TRUE(shows(pixels, "-1"));
  EXPECT_FALSE(shows(pixels, "[1]"));
  EXPECT_FALSE(shows(pixels, "magnitude"));
  // The bar goes from yellow down to violet; its ends are the first and the last of their colours.
  const int col = pixels.width - legend_width(pixels.height) + 14;
  int first = 0, last = pixels.height - 1;
  const auto near = [&](int row, const std::array<int, 3>& colour) {
    const auto pixel = pixels.at(col, row);
    for (int i = 0; i < 3; ++i) {
      if (std::abs(pixel[i] - colour[i]) > 3) return false;
    }
    return true;
  };
  while (first < last && !near(first, {253, 231, 37})) ++first;
  while (last > first && !near(last, {68, 1, 84})) --last;
  EXPECT_GT(last - first, 100);
  EXPECT_TRUE(near((first + last) / 2, {34, 145, 140}));
}

TEST_F(PaintedPictures, ShowVectorsByTheirMagnitude) {
  write_frames(2, [](int, const Vec3&) { return 0.0; });
  const RenderReport report = render_trajectory(path("run.h5"), pictures(), painted("velocity"));
  EXPECT_NEAR(report.least, 0, 1e-6);
  EXPECT_NEAR(report.most, 5, 1e-6);
  EXPECT_EQ(report.units, "m/s");
  for (const char* text : {"velocity", "magnitude", "[m/s]", "5"})
    EXPECT_TRUE(shows(picture(1), text)) << text;
  expect_violet(mean_of_sheet(picture(0)));
  expect_yellow(mean_of_sheet(picture(1)));
}

TEST_F(PaintedPictures, PutZeroInTheMiddleOfSignedFields) {
  write_frames(3, [](int frame, const Vec3&) { return frame == 0 ? -1.0 : 2.0 * frame; });
  render_trajectory(path("run.h5"), pictures(), painted("strain"));
  const auto blue = mean_of_sheet(picture(0)), red = mean_of_sheet(picture(2));
  EXPECT_GT(blue[2], 1.1 * blue[0]);
  EXPECT_GT(red[0], 2 * red[2]);
}

TEST_F(PaintedPictures, KeepTheirColoursAtReducedDetail) {
  write_frames(1, [](int, const Vec3&) { return 3.0; });
  for (const bool by_level : {false, true}) {
    RenderOptions options = painted("strain");
    if (by_level) options.surface_of_level = 2;
    if (!by_level) options.detail_pixels = 1;
    const RenderReport report = render_trajectory(path("run.h5"), pictures(), options);
    EXPECT_LT(report.triangles, report.all_triangles);
    expect_yellow(mean_of_sheet(picture(0)));
  }
}

TEST_F(PaintedPictures, AreNotMadeOfAFieldThatIsNotThere) {
  write_frames(1, [](int, const Vec3&) { return 0.0; });
  EXPECT_EQ(refusal(painted("velocty")),
            "there is no field \"velocty\" in the file; did you mean \"velocity\"? It has "
            "\"strain\", \"velocity\"");
  EXPECT_EQ(refusal(painted("temperature")),
            "there is no field \"temperature\" in the file; it has \"strain\", \"velocity\"");
  EXPECT_FALSE(std::filesystem::exists(pictures()));
  RenderOptions small = painted("strain");
  small.width = 200;
  EXPECT_EQ(refusal(small),
            "pictures with a legend are at least 240 x 180 pixels large, not 200 x 240");
  EXPECT_FALSE(std::filesystem::exists(pictures()));
}

TEST_F(PaintedPictures, NeedANumber) {
  write_frames(1, [](int, const Vec3&) { return std::numeric_limits<double>::quiet_NaN(); });
  EXPECT_THROW(render_trajectory(path("run.h5"), pictures(), painted("strain")),
               std::runtime_error);
}

}  // namespace
}  // namespace weft::sim::painted_field_test
