#include "gpu/colour_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "gpu/bitmap_font.h"
#include "gpu/renderer.h"

namespace weft::gpu::colour_map_test {
namespace {

// The lightness L* of CIELAB, 0..100, from the luminance of linear sRGB (IEC 61966-2-1).
double lightness(const Colour& colour) {
  const double y = 0.2126 * colour[0] + 0.7152 * colour[1] + 0.0722 * colour[2];
  return y > 216.0 / 24389 ? 116 * std::cbrt(y) - 16 : 24389.0 / 27 * y;
}

TEST(ColourMap, SequentialColoursGrowEvenlyInLightness) {
  const ColourMap& map = sequential_colours();
  constexpr int steps = 10;
  const double rise = (lightness(map.at(1)) - lightness(map.at(0))) / steps;
  EXPECT_GT(rise, 7);
  for (int i = 0; i < steps; ++i) {
    const float from = static_cast<float>(i) / steps, to = static_cast<float>(i + 1) / steps;
    EXPECT_NEAR(lightness(map.at(to)) - lightness(map.at(from)), rise, 0.2 * rise) << i;
  }
}

TEST(ColourMap, DivergingColoursAreAlikeOnBothSidesAndLightInTheMiddle) {
  const ColourMap& map = diverging_colours();
  for (int i = 0; i < 8; ++i) {
    const float place = static_cast<float>(i) / 16;
    EXPECT_NEAR(lightness(map.at(place)), lightness(map.at(1 - place)), 1) << i;
    EXPECT_GT(lightness(map.at(place + 0.0625F)), lightness(map.at(place)) + 1) << i;
    EXPECT_GT(map.at(place)[2], map.at(place)[0]) << "blue below";
    EXPECT_GT(map.at(1 - place)[0], map.at(1 - place)[2]) << "red above";
  }
  const Colour& middle = map.at(0.5F);
  EXPECT_NEAR(middle[0], middle[2], 1e-3);
}

TEST(ColourMap, HasTheEndsBeyondThemAndAGreyForNoNumber) {
  for (const ColourMap* map : {&sequential_colours(), &diverging_colours()}) {
    EXPECT_EQ(map->at(-3), map->at(0));
    EXPECT_EQ(map->at(7), map->at(1));
    EXPECT_EQ(map->at(std::numeric_limits<float>::quiet_NaN()), no_value_colour());
    for (int i = 0; i <= 100; ++i)
      EXPECT_NE(map->at(0.01F * static_cast<float>(i)), no_value_colour());
  }
}

// Looks at two triangles of a square from straight above. Its left side has the place 0 and its
// right side 1.
TEST(ColourMap, PaintsPlacesBetweenVerticesUnderTheSameLight) {
  const std::vector<Vec3> positions{{-1, -1, 0}, {1, -1, 0}, {-1, 1, 0}, {1, 1, 0}};
  const std::vector<std::array<int, 3>> triangles{{0, 1, 3}, {0, 3, 2}};
  std::vector<float> places{0, 1, 0, 1};
  Camera camera;
  camera.eye = {0, 0, 10};
  camera.up = {0, 1, 0};
  camera.field_of_view_deg = 9;
  Renderer renderer(64, 64);
  DrawnSurface surface{.positions = positions, .triangles = triangles};
  surface.places = places;
  surface.colour_map = &sequential_colours();
  const Picture painted = renderer.draw({&surface, 1}, camera);
  for (const int col : {4, 31, 60}) {
    // A surface of one colour, the one at this column, looks the same there.
    const float place =
        static_cast<float>(0.5 + (col + 0.5 - 32) / 64 * 10 * std::tan(4.5 * M_PI / 180));
    DrawnSurface plain{.positions = positions, .triangles = triangles};
    plain.front_colour = plain.back_colour = sequential_colours().at(place);
    const Picture expected = renderer.draw({&plain, 1}, camera);
    for (const int row : {8, 32, 55}) {
      for (int channel = 0; channel < 3; ++channel) {
        const std::size_t at = 3 * (64 * std::size_t(row) + col) + channel;
        EXPECT_NEAR(painted.rgb[at], expected.rgb[at], 2) << row << ' ' << col;
      }
    }
  }
  // Beside a surface without places, the painted one stays as it is.
  const std::vector<Vec3> far{{40, 40, 0}, {41, 40, 0}, {40, 41, 0}};
  const std::array<std::array<int, 3>, 1> one{{{0, 1, 2}}};
  const std::vector<DrawnSurface> both{{.positions = far, .triangles = one}, surface};
  EXPECT_EQ(renderer.draw(both, camera).rgb, painted.rgb);
  // A vertex without a number leaves its triangles without a colour of the map.
  places[0] = std::numeric_limits<float>::quiet_NaN();
  DrawnSurface grey{.positions = positions, .triangles = triangles};
  grey.front_colour = grey.back_colour = no_value_colour();
  EXPECT_EQ(renderer.draw({&surface, 1}, camera).rgb, renderer.draw({&grey, 1}, camera).rgb);
}

// Returns the pixels of a picture as text: '#' for ink, '.' for paper.
std::vector<std::string> rows_of(const Picture& picture) {
  std::vector<std::string> rows;
  for (int y = 0; y < picture.height; ++y) {
    std::string& row = rows.emplace_back();
    for (int x = 0; x < picture.width; ++x) {
      row += picture.rgb[3 * (std::size_t{1} * y * picture.width + x)] == 0 ? '#' : '.';
    }
  }
  return rows;
}

TEST(BitmapFont, WritesCharactersWithinThePicture) {
  Picture picture{12, 13, std::vector<std::uint8_t>(std::size_t{3} * 12 * 13, 255)};
  draw_text(picture, 0, 0, 1, {0, 0, 0}, "-7");
  const std::vector<std::string> expected{
      "............", "............", "......#####.", "..........#.", ".........#..",
      ".........#..", "#####...#...", "........#...", ".......#....", ".......#....",
      ".......#....", "............", "............"};
  EXPECT_EQ(rows_of(picture), expected);
  Picture doubled{12, 26, std::vector<std::uint8_t>(std::size_t{3} * 12 * 26, 255)};
  draw_text(doubled, -12, 0, 2, {0, 0, 0}, "-7-");
  const std::vector<std::string> large = rows_of(doubled);
  for (int y = 0; y < 26; ++y) {
    for (int x = 0; x < 12; ++x) EXPECT_EQ(large[y][x], expected[y / 2][6 + x / 2]) << y << x;
  }
  Picture unknown = doubled, question = doubled;
  draw_text(unknown, 0, 0, 1, {0, 0, 0}, "\xc2");
  draw_text(question, 0, 0, 1, {0, 0, 0}, "?");
  EXPECT_EQ(unknown.rgb, question.rgb);
}

}  // namespace
}  // namespace weft::gpu::colour_map_test
