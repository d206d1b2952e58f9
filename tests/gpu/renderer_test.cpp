#include "gpu/renderer.h"

#include <gtest/gtest.h>
#include <png.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <random>
#include <stdexcept>
#include <thread>

#include "bsi/shapes.h"
#include "gpu/gl_context.h"
#include "gpu/triangle_batch.h"
#include "tests/temporary_folder.h"

namespace weft::gpu::renderer_test {
namespace {

constexpr Colour red{0.7F, 0.05F, 0.05F};
constexpr Colour green{0.05F, 0.5F, 0.05F};
constexpr Colour blue{0.05F, 0.05F, 0.7F};
constexpr std::array<std::array<int, 3>, 1> one_triangle{{{0, 1, 2}}};

// Looks straight down on the square -1..1 of the plane z = 0, x to the right and y upwards.
Camera camera_from_above() {
  Camera camera;
  camera.eye = {0, 0, 10};
  camera.up = {0, 1, 0};
  camera.field_of_view_deg = 2 * std::atan(0.1) * 180 / std::numbers::pi;
  return camera;
}

// Returns the dominant channel: 'r', 'g' or 'b'; ' ' for the greys of the background.
char hue(const Picture& picture, int col, int row) {
  const std::uint8_t* pixel =
      &picture.rgb[3 * (static_cast<std::size_t>(row) * picture.width + col)];
  const auto largest = std::max_element(pixel, pixel + 3);
  const auto smallest = std::min_element(pixel, pixel + 3);
  if (*largest - *smallest < 40) return ' ';
  return "rgb"[largest - pixel];
}

// How much of a pixel is inside the triangle; pixels partly inside are anti-aliased.
enum class Coverage { none, part, full };
Coverage coverage(const std::array<Eigen::Vector2d, 3>& triangle, int col, int row, int size) {
  bool inside = true;
  bool outside = false;
  for (int edge = 0; edge < 3; ++edge) {
    const Eigen::Vector2d& from = triangle[edge];
    const Eigen::Vector2d along = (triangle[(edge + 1) % 3] - from).normalized();
    const Eigen::Vector2d centre((col + 0.5) * 2 / size - 1, 1 - (row + 0.5) * 2 / size);
    const double distance = along.x() * (centre - from).y() - along.y() * (centre - from).x();
    const double half_diagonal = 1.5 / size;
    inside = inside && distance > half_diagonal;
    outside = outside || distance < -half_diagonal;
  }
  return inside ? Coverage::full : outside ? Coverage::none : Coverage::part;
}

// Draws, and ends the process: with 0 if it has neither a context nor a library of OpenGL.
void draw_and_exit() {
  Renderer renderer(8, 8);
  renderer.draw({}, camera_from_above());
  std::string found = context_count() == 0 ? "" : "a context";
  std::string line;
  for (std::ifstream maps("/proc/self/maps"); std::getline(maps, line);) {
    for (const char* library : {"libOSMesa", "libEGL"})
      if (line.find(library) != std::string::npos) found = library;
  }
  if (!found.empty()) std::fprintf(stderr, "found %s\n", found.c_str());
  std::_Exit(found.empty() ? 0 : 1);
}

// In a process of its own, since other tests make contexts.
TEST(Renderer, NeedsNoOpenGl) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(draw_and_exit(), testing::ExitedWithCode(0), "");
}

TEST(Renderer, RefusesCamerasWithoutAView) {
  Renderer renderer(8, 8);
  Camera inside, lying, blind, wide;
  inside.eye = inside.target;
  lying.up.setZero();
  blind.field_of_view_deg = 0;
  wide.field_of_view_deg = 180;
  for (const Camera& camera : {inside, lying, blind, wide})
    EXPECT_THROW(renderer.draw({}, camera), std::invalid_argument);
  EXPECT_NO_THROW(renderer.draw({}, Camera()));
}

TEST(Renderer, RefusesWhatFloatsCannotHold) {
  Renderer renderer(8, 8);
  const std::vector<std::array<int, 3>> triangle{{0, 1, 2}};
  for (const double far : {1e19, 1e60, std::numeric_limits<double>::quiet_NaN()}) {
    const std::vector<Vec3> positions{{0, 0, 0}, {1, 0, 0}, {0, far, 0}};
    const DrawnSurface surface{.positions = positions, .triangles = triangle};
    EXPECT_THROW(renderer.draw(std::span(&surface, 1), Camera()), std::runtime_error) << far;
  }
  Camera near;
  near.eye = near.target + Vec3(0, 0, 1e-19);
  EXPECT_THROW(renderer.draw({}, near), std::runtime_error);
}

TEST(Renderer, CoversThePixelsOfATriangle) {
  constexpr int size = 64;
  const std::array<Vec3, 3> corners{Vec3(-0.8, -0.7, 0), Vec3(0.9, -0.2, 0), Vec3(-0.1, 0.85, 0)};
  const std::array<Eigen::Vector2d, 3> flat{corners[0].head<2>(), corners[1].head<2>(),
                                            corners[2].head<2>()};
  const DrawnSurface surface{corners, one_triangle, red, blue};
  Renderer renderer(size, size);
  const Picture picture = renderer.draw(std::array{surface}, camera_from_above());
  ASSERT_EQ(picture.rgb.size(), 3U * size * size);
  int full = 0;
  for (int row = 0; row < size; ++row) {
    for (int col = 0; col < size; ++col) {
      const Coverage expected = coverage(flat, col, row, size);
      full += expected == Coverage::full;
      if (expected == Coverage::part) continue;
      EXPECT_EQ(hue(picture, col, row), expected == Coverage::full ? 'r' : ' ')
          << col << ' ' << row;
    }
  }
  EXPECT_GT(full, size * size / 5);
}

TEST(Renderer, ShowsEachSideInItsColour) {
  const std::array<Vec3, 3> corners{Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(0, 1, 0)};
  const DrawnSurface surface{corners, one_triangle, red, blue};
  Renderer renderer(32, 32);
  Camera camera = camera_from_above();
  EXPECT_EQ(hue(renderer.draw(std::array{surface}, camera), 16, 16), 'r');
  camera.eye.z() = -10;
  EXPECT_EQ(hue(renderer.draw(std::array{surface}, camera), 16, 16), 'b');
}

// From below, a level square is as bright as from above if the light comes from below, too.
TEST(Renderer, LightsFromBelow) {
  const std::array<Vec3, 4> corners{Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(1, 1, 0), Vec3(-1, 1, 0)};
  const std::array<std::array<int, 3>, 2> triangles{{{0, 1, 2}, {0, 2, 3}}};
  const DrawnSurface square{.positions = corners,
                            .triangles = triangles,
                            .front_colour = {0.5F, 0.5F, 0.5F},
                            .back_colour = {0.5F, 0.5F, 0.5F}};
  Renderer renderer(9, 9);
  const auto middle = [&](double height, bool lit_from_below) {
    Camera camera{.eye = {0, -5, height}};
    camera.lit_from_below = lit_from_below;
    return int{renderer.draw(std::array{square}, camera).rgb[3 * (4 * 9 + 4)]};
  };
  const int above = middle(5, false);
  EXPECT_NEAR(middle(-5, true), above, 2);
  EXPECT_LT(middle(-5, false), 0.7 * above);
}

TEST(Renderer, HidesWhatIsBehind) {
  const auto sheet = [](double height) {
    bsi::Surface surface = bsi::make_rectangle(1.5, 1.5, 3, 3);
    for (Vec3& position : surface.positions) position.z() += height;
    return surface;
  };
  const bsi::Surface low = sheet(0);
  const bsi::Surface high = sheet(1e-3);
  const bsi::Mesh mesh = bsi::build_mesh(low.atlas);
  const DrawnSurface red_low{low.positions, mesh.triangles, red, red};
  const DrawnSurface green_high{high.positions, mesh.triangles, green, green};
  Renderer renderer(32, 32);
  Camera camera = camera_from_above();
  EXPECT_EQ(hue(renderer.draw(std::array{red_low, green_high}, camera), 16, 16), 'g');
  EXPECT_EQ(hue(renderer.draw(std::array{green_high, red_low}, camera), 16, 16), 'g');
  camera.eye.z() = -10;
  EXPECT_EQ(hue(renderer.draw(std::array{red_low, green_high}, camera), 16, 16), 'r');
}

// The eye is above the middle of a floor much larger than the picture. No part of the floor behind
// the eye or far away may cover others, and the shadow of a ball is visible.
TEST(Renderer, DrawsAHugeFloorAndTheShadowOnIt) {
  const bsi::Surface floor = bsi::make_rectangle(1000, 1000, 2, 2);
  bsi::Surface ball = bsi::make_sphere(0.3, 9);
  for (Vec3& position : ball.positions) position.z() += 0.4;
  const bsi::Mesh floor_mesh = bsi::build_mesh(floor.atlas);
  const bsi::Mesh ball_mesh = bsi::build_mesh(ball.atlas);
  constexpr Colour grey{0.4F, 0.4F, 0.4F};
  const DrawnSurface drawn_floor{floor.positions, floor_mesh.triangles, grey, grey};
  const DrawnSurface drawn_ball{ball.positions, ball_mesh.triangles, red, red};
  Renderer renderer(96, 96);
  const Camera camera = camera_for_box({-1, -1, 0}, {1, 1, 0.7}, 1);
  const Picture alone = renderer.draw(std::array{drawn_floor}, camera);
  const Picture both = renderer.draw(std::array{drawn_floor, drawn_ball}, camera);
  int shaded = 0;
  int brightest = 0;
  int darkest = 255;
  for (std::size_t i = 0; i < alone.rgb.size(); i += 3) {
    const int col = static_cast<int>(i / 3) % 96;
    const int row = static_cast<int>(i / 3) / 96;
    brightest = std::max<int>(brightest, alone.rgb[i]);
    darkest = std::min<int>(darkest, alone.rgb[i]);
    shaded += hue(both, col, row) == ' ' && both.rgb[i] + 25 < alone.rgb[i];
  }
  EXPECT_LT(brightest - darkest, 12);  // the floor alone is lit evenly, to the horizon
  EXPECT_GT(shaded, 96 * 96 / 100);
}

// Large triangles are cut for their light. No background may show where they or their parts meet.
TEST(Renderer, ShowsNoCracksBetweenLargeTriangles) {
  constexpr int size = 200;
  bsi::Surface sheet = bsi::make_rectangle(4, 4, 7, 7);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> shift(-0.2, 0.2);
  for (Vec3& position : sheet.positions) position += Vec3(shift(random), shift(random), 0);
  const bsi::Mesh mesh = bsi::build_mesh(sheet.atlas);
  const DrawnSurface surface{sheet.positions, mesh.triangles, red, blue};
  Renderer renderer(size, size);
  for (const Vec3& eye : {Vec3(0, 0, 10), Vec3(0.1, -5, 8), Vec3(4, 3, 9)}) {
    Camera camera = camera_from_above();
    camera.eye = eye;
    const Picture picture = renderer.draw(std::array{surface}, camera);
    int brightest_green = 0, darkest_red = 255;
    for (std::size_t i = 0; i < picture.rgb.size(); i += 3) {
      darkest_red = std::min<int>(darkest_red, picture.rgb[i]);
      brightest_green = std::max<int>(brightest_green, picture.rgb[i + 1]);
    }
    EXPECT_LT(brightest_green + 60, darkest_red);
  }
}

TEST(Renderer, DrawsWhatIsAllAroundTheEye) {
  constexpr int size = 64;
  const bsi::Surface ball = bsi::make_sphere(1, 9);
  const bsi::Mesh mesh = bsi::build_mesh(ball.atlas);
  const DrawnSurface around{ball.positions, mesh.triangles, red, blue};
  // A floor through the eye is not visible.
  const bsi::Surface floor = bsi::make_rectangle(3, 3, 4, 4);
  const bsi::Mesh floor_mesh = bsi::build_mesh(floor.atlas);
  const DrawnSurface edge_on{floor.positions, floor_mesh.triangles, green, green};
  Renderer renderer(size, size);
  Camera camera;
  camera.eye = {0, 0, 0};
  camera.target = {0.5, 0.2, 0};
  const Picture picture = renderer.draw(std::array{around, edge_on}, camera);
  for (int row = 0; row < size; ++row) {
    for (int col = 0; col < size; ++col)
      EXPECT_EQ(hue(picture, col, row), 'b') << col << ' ' << row;
  }
}

// Six patches that meet at shared particles have one normal there, so brightness changes smoothly
// along any line over the ball. (With a normal per patch, the largest step is 20.)
TEST(Renderer, ShowsNoSeamsOnASphere) {
  const bsi::Surface ball = bsi::make_sphere(0.9, 9);
  const bsi::Mesh mesh = bsi::build_mesh(ball.atlas);
  const DrawnSurface surface{ball.positions, mesh.triangles, red, red};
  Renderer renderer(200, 200);
  Camera camera = camera_from_above();
  camera.eye = {6, 5, 6};  // towards a corner of the cube, where three patches meet
  camera.up = {0, 0, 1};
  const Picture picture = renderer.draw(std::array{surface}, camera);
  int steepest = 0;
  for (int row = 30; row < 170; ++row) {
    for (int col = 30; col < 170; ++col) {
      if (std::hypot(row - 100, col - 100) > 60) continue;
      const std::size_t pixel = 3 * (std::size_t{200} * row + col);
      steepest = std::max(steepest, std::abs(picture.rgb[pixel + 3] - picture.rgb[pixel]));
      steepest = std::max(steepest, std::abs(picture.rgb[pixel + 600] - picture.rgb[pixel]));
    }
  }
  EXPECT_GT(steepest, 0);
  EXPECT_LE(steepest, 8);
}

// By symmetry, normals of a torus point along the radius at all particles, also where the patch is
// closed.
TEST(VertexNormals, PointAlongTheRadiusOfATorus) {
  const bsi::Surface torus = bsi::make_torus(1.0, 0.3, 120, 120);
  const bsi::Mesh mesh = bsi::build_mesh(torus.atlas);
  const std::vector<Vec3> normals = vertex_normals({torus.positions, mesh.triangles, red, red});
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const Vec3 axis = Vec3(torus.positions[i].x(), torus.positions[i].y(), 0).normalized();
    EXPECT_GT(normals[i].dot((torus.positions[i] - axis).normalized()), std::cos(0.02));
  }
}

TEST(Renderer, DrawsLinesDarkerThanTheSurface) {
  const bsi::Surface sheet = bsi::make_rectangle(1.8, 1.8, 3, 3);
  const bsi::Mesh mesh = bsi::build_mesh(sheet.atlas);
  DrawnSurface surface{sheet.positions, mesh.triangles, red, red};
  Renderer renderer(65, 65);
  const Picture plain = renderer.draw(std::array{surface}, camera_from_above());
  const auto lines = grid_lines(sheet.atlas, sheet.positions);
  surface.lines = lines;
  const Picture lined = renderer.draw(std::array{surface}, camera_from_above());
  const auto red_at = [](const Picture& picture, int col, int row) {
    return picture.rgb[3 * (std::size_t{65} * row + col)];
  };
  EXPECT_LT(red_at(lined, 32, 20) + 8, red_at(plain, 32, 20));  // on the middle column
  EXPECT_EQ(red_at(lined, 20, 20), red_at(plain, 20, 20));      // between the lines
}

// A cloth lies 2 mm above an obstacle and rises from it in a fold whose walls are seen edge-on. Its
// grid lines stay visible.
TEST(Renderer, ShowsNothingOfAnObstacleThroughTheClothOnIt) {
  constexpr int size = 400;
  bsi::Surface obstacle = bsi::make_rectangle(0.24, 0.24, 2, 2);
  for (Vec3& position : obstacle.positions) position.z() -= 0.002;
  bsi::Surface cloth = bsi::make_rectangle(0.26, 0.26, 9, 6);
  constexpr std::array<std::array<double, 2>, 6> profile{
      {{-0.13, 0}, {-0.03, 0}, {-0.029, 0.02}, {0.029, 0.02}, {0.03, 0}, {0.13, 0}}};
  for (std::size_t i = 0; i < cloth.positions.size(); ++i) {
    const auto [x, z] = profile[i % profile.size()];
    cloth.positions[i].x() = x;
    cloth.positions[i].z() = z;
  }
  const bsi::Mesh obstacle_mesh = bsi::build_mesh(obstacle.atlas);
  const bsi::Mesh cloth_mesh = bsi::build_mesh(cloth.atlas);
  const auto lines = grid_lines(cloth.atlas, cloth.positions);
  const DrawnSurface hidden{obstacle.positions, obstacle_mesh.triangles, green, green};
  DrawnSurface cover{cloth.positions, cloth_mesh.triangles, red, red};
  Renderer renderer(size, size);
  Camera camera = camera_from_above();
  camera.field_of_view_deg /= 10;  // the square -0.1..0.1
  const Picture plain = renderer.draw(std::array{hidden, cover}, camera);
  cover.lines = lines;
  const Picture lined = renderer.draw(std::array{hidden, cover}, camera);
  int shining_through = 0, darkened = 0;
  for (std::size_t pixel = 0; pixel < plain.rgb.size(); pixel += 3) {
    // A pixel that shows some of the green obstacle has more green than blue.
    shining_through += plain.rgb[pixel + 1] > plain.rgb[pixel + 2] + 8;
    darkened += lined.rgb[pixel] + 8 < plain.rgb[pixel];
  }
  EXPECT_EQ(shining_through, 0);
  EXPECT_GT(darkened, size * 3);
}

TEST(Renderer, DrawsTheSameBytesAgain) {
  const bsi::Surface torus = bsi::make_torus(0.6, 0.25, 24, 32);
  const bsi::Mesh mesh = bsi::build_mesh(torus.atlas);
  const DrawnSurface surface{torus.positions, mesh.triangles, green, blue};
  const Camera camera = camera_for_box({-1, -1, -0.3}, {1, 1, 0.3}, 4.0 / 3);
  Renderer renderer(160, 120);
  const Picture first = renderer.draw(std::array{surface}, camera);
  EXPECT_EQ(renderer.draw(std::array{surface}, camera).rgb, first.rgb);
  // The bytes are the same with another renderer alive, after an empty picture, and on another
  // thread.
  Renderer other(160, 120);
  other.draw({}, camera);
  EXPECT_EQ(other.draw(std::array{surface}, camera).rgb, first.rgb);
  EXPECT_EQ(renderer.draw(std::array{surface}, camera).rgb, first.rgb);
  Picture on_thread;
  std::thread([&] { on_thread = Renderer(160, 120).draw(std::array{surface}, camera); }).join();
  EXPECT_EQ(on_thread.rgb, first.rgb);
}

TEST(Renderer, RefusesImpossibleSizes) {
  EXPECT_THROW(Renderer(0, 10), std::runtime_error);
  EXPECT_THROW(Renderer(10, 8193), std::runtime_error);
}

Picture read_png(const std::string& path) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  Picture picture;
  if (png_image_begin_read_from_file(&image, path.c_str()) == 0) return picture;
  image.format = PNG_FORMAT_RGB;
  picture = {static_cast<int>(image.width), static_cast<int>(image.height),
             std::vector<std::uint8_t>(PNG_IMAGE_SIZE(image))};
  png_image_finish_read(&image, nullptr, picture.rgb.data(), 0, nullptr);
  return picture;
}

TEST(PngFile, IsReadAsItWasWritten) {
  Picture picture{37, 23, {}};
  for (int i = 0; i < 37 * 23 * 3; ++i) {
    picture.rgb.push_back(static_cast<std::uint8_t>((i * 7919) >> 3));
  }
  const TemporaryFolder folder;
  const std::string path = folder.path("picture.png");
  write_png(path, picture);
  const Picture read = read_png(path);
  EXPECT_EQ(read.width, 37);
  EXPECT_EQ(read.height, 23);
  EXPECT_EQ(read.rgb, picture.rgb);
}

TEST(PngFile, NamesTheFileThatCannotBeWritten) {
  const Picture picture{2, 2, std::vector<std::uint8_t>(12)};
  // A folder that is not there, and a device that is always full.
  for (const std::string path : {"/nowhere/picture.png", "/dev/full"}) {
    try {
      write_png(path, picture);
      ADD_FAILURE() << path;
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find(path), std::string::npos) << error.what();
    }
  }
}

// Without room for the picture, an earlier one stays and nothing unfinished is left.
TEST(PngFile, LeavesNothingUnfinished) {
  Picture picture{200, 200, {}};
  for (int i = 0; i < 200 * 200 * 3; ++i)
    picture.rgb.push_back(static_cast<std::uint8_t>((i * 7919) >> 3));
  const TemporaryFolder folder;
  const std::string path = folder.path("picture.png");
  write_png(path, {2, 2, std::vector<std::uint8_t>(12)});
  // Writing beyond the limit fails as on a full disk.
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{4096, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  EXPECT_THROW(write_png(path, picture), std::runtime_error);
  EXPECT_THROW(write_png(folder.path("other.png"), picture), std::runtime_error);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(read_png(path).width, 2);
  const std::filesystem::directory_iterator left(folder.path());
  EXPECT_EQ(std::distance(begin(left), end(left)), 1);
}

}  // namespace
}  // namespace weft::gpu::renderer_test
