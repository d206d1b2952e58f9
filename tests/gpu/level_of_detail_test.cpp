// Pictures of surfaces of reduced detail: red outside, blue inside, on a grey background. Blue or
// grey would show through a crack.
#include "bsi/level_of_detail.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>

#include "bsi/shapes.h"
#include "gpu/renderer.h"
#include "gpu/triangle_batch.h"

namespace weft::gpu::level_of_detail_test {
namespace {

constexpr Colour red{0.9F, 0.05F, 0.05F};
constexpr Colour blue{0.05F, 0.05F, 0.9F};
constexpr int size = 160;

Camera camera_from(const Vec3& direction) {
  Camera camera;
  camera.eye = 7 * direction;
  camera.field_of_view_deg = 25;  // sees 1.5 m about the origin
  return camera;
}

const std::array<Vec3, 4> directions{
    Vec3(1, 0.1, 0.2).normalized(), Vec3(-1, 0.7, 0.3).normalized(), Vec3(0.2, 0.3, 1).normalized(),
    Vec3(-0.5, -1, -0.8).normalized()};

using Mask = std::vector<bool>;  // by pixel, row by row

Mask red_pixels(const Picture& picture) {
  Mask mask(static_cast<std::size_t>(size) * size);
  for (std::size_t i = 0; i < mask.size(); ++i) {
    const std::uint8_t* pixel = &picture.rgb[3 * i];
    mask[i] = 2 * pixel[0] > 3 * pixel[2];  // in the shadow too
  }
  return mask;
}

// Keeps only pixels whose neighbours within `reach` are all set.
Mask eroded(const Mask& mask, int reach) {
  Mask result(mask.size(), false);
  for (int row = reach; row < size - reach; ++row) {
    for (int col = reach; col < size - reach; ++col) {
      bool all = true;
      for (int r = row - reach; r <= row + reach && all; ++r) {
        for (int c = col - reach; c <= col + reach && all; ++c) all = mask[r * size + c];
      }
      result[row * size + col] = all;
    }
  }
  return result;
}

int count(const Mask& mask) { return static_cast<int>(std::ranges::count(mask, true)); }

// A closed body, and its picture at full detail from one direction.
class Viewed {
 public:
  Viewed(const bsi::Surface& body, Renderer& renderer, const Vec3& direction)
      : renderer_(renderer), camera_(camera_from(direction)) {
    const bsi::Mesh mesh = bsi::build_mesh(body.atlas);
    clear_ = red_pixels(picture(body.positions, mesh.triangles));
    remove_outlines(body, vertex_normals({body.positions, mesh.triangles, red, blue}));
  }

  const Camera& camera() const { return camera_; }

  // Returns the number of pixels that do not show the outside of the surface although they lie
  // inside the silhouette, farther than the deviation from all outlines.
  int holes(const bsi::DetailSurface& detail) const {
    const double pixel = pixel_tolerance(camera_, size, size, 1).per_distance;
    // The body is at least 5 m from the eye.
    const int reach = 1 + static_cast<int>(std::ceil(detail.deviation / (5 * pixel)));
    const Mask inside = eroded(clear_, reach);
    const Mask shown = red_pixels(picture(detail.positions, detail.triangles));
    EXPECT_GT(count(inside), 3 * size);
    int holes = 0;
    for (std::size_t i = 0; i < inside.size(); ++i) holes += inside[i] && !shown[i];
    return holes;
  }

 private:
  Picture picture(std::span<const Vec3> positions,
                  std::span<const std::array<int, 3>> triangles) const {
    return renderer_.draw(std::array{DrawnSurface{positions, triangles, red, blue}}, camera_);
  }

  // Removes pixels near outlines. Where the surface turns away from the eye, the inside may show by
  // a pixel even at full detail, and one part of the body may cover another.
  void remove_outlines(const bsi::Surface& body, const std::vector<Vec3>& normals) {
    const Vec3 backward = camera_.eye.normalized();
    const Vec3 right = camera_.up.cross(backward).normalized();
    const Vec3 up = backward.cross(right);
    const double slope = std::tan(camera_.field_of_view_deg / 360 * std::numbers::pi);
    for (std::size_t i = 0; i < normals.size(); ++i) {
      const Vec3 ray = body.positions[i] - camera_.eye;
      if (std::abs(normals[i].dot(ray.normalized())) > 0.4) continue;
      const double scale = 0.5 * size / (-ray.dot(backward) * slope);
      const int col = static_cast<int>(0.5 * size + scale * ray.dot(right));
      const int row = static_cast<int>(0.5 * size - scale * ray.dot(up));
      ASSERT_TRUE(row >= 0 && row < size && col >= 0 && col < size);
      clear_[static_cast<std::size_t>(row) * size + col] = false;
    }
  }

  Renderer& renderer_;
  Camera camera_;
  Mask clear_;  // the outside is seen there, and no outline
};

struct NamedBody {
  std::string name;
  bsi::Surface body;
};

std::vector<NamedBody> closed_bodies() {
  return {{"sphere", bsi::make_sphere(1, 29)},
          {"blob", bsi::make_blob(1, 13)},
          {"torus", bsi::make_torus(0.8, 0.3, 60, 33)}};
}

bsi::Pyramid pyramid_of(const bsi::Surface& body) {
  bsi::Pyramid pyramid(body.atlas, {.tangents = false, .spheres = true});
  EXPECT_FALSE(pyramid.rebuild(body.positions));
  return pyramid;
}

TEST(LevelOfDetail, ShowsNoBackgroundThroughTheSurface) {
  Renderer renderer(size, size);
  std::mt19937 random(5);
  for (const auto& [name, body] : closed_bodies()) {
    const bsi::Pyramid pyramid = pyramid_of(body);
    for (const Vec3& direction : directions) {
      SCOPED_TRACE(name + " from " + std::to_string(direction.x()));
      const Viewed viewed(body, renderer, direction);
      for (const double pixels : {0.5, 2.0}) {
        const bsi::DetailTolerance tolerance = pixel_tolerance(viewed.camera(), size, size, pixels);
        const bsi::DetailSurface detail = bsi::detail_within(pyramid, body.positions, tolerance);
        EXPECT_EQ(viewed.holes(detail), 0) << pixels << " pixels";
      }
      if (pyramid.patch_count() == 1) continue;
      // Coarse and fine patches side by side.
      std::vector<int> levels(pyramid.patch_count());
      for (int& level : levels) level = 3 + static_cast<int>(random() % 3);
      bsi::DetailSurface detail = bsi::detail_at_levels(pyramid, body.positions, levels);
      detail.deviation = bsi::deviation_at_levels(pyramid, body.positions, levels);
      EXPECT_EQ(viewed.holes(detail), 0);
    }
  }
}

// The test above would detect a single triangle missing from the strips between patches.
TEST(LevelOfDetail, AMissingTriangleWouldBeSeen) {
  Renderer renderer(size, size);
  const bsi::Surface body = bsi::make_blob(1, 9);
  const bsi::Pyramid pyramid = pyramid_of(body);
  const Viewed viewed(body, renderer, directions[0]);
  const std::vector<int> levels(pyramid.patch_count(), 2);
  bsi::DetailSurface detail = bsi::detail_at_levels(pyramid, body.positions, levels);
  detail.deviation = bsi::deviation_at_levels(pyramid, body.positions, levels);
  ASSERT_EQ(viewed.holes(detail), 0);
  // Removes the triangle nearest to the axis of the picture among those that face the camera.
  const auto distance = [&](const std::array<int, 3>& triangle) {
    const Vec3 middle = (detail.positions[triangle[0]] + detail.positions[triangle[1]] +
                         detail.positions[triangle[2]]) /
                        3;
    return (middle - directions[0]).norm();
  };
  detail.triangles.erase(std::ranges::min_element(detail.triangles, {}, distance));
  EXPECT_GT(viewed.holes(detail), 3);
}

TEST(LevelOfDetail, KeepsEveryPointWithinThePixels) {
  const bsi::Surface body = bsi::make_blob(1, 65);
  const bsi::Pyramid pyramid = pyramid_of(body);
  const Camera camera = camera_for_points(body.positions, 1);
  const Vec3 forward = (camera.target - camera.eye).normalized();
  const double pixel = 2 * std::tan(camera.field_of_view_deg / 360 * std::numbers::pi) / size;
  // Returns the place in the picture, in pixels from its middle.
  const auto seen = [&](const Vec3& point) -> Vec3 {
    const Vec3 ray = point - camera.eye;
    return (ray / ray.dot(forward) - forward) / pixel;
  };
  std::size_t triangles = 2U * body.atlas.quad_count();
  for (const double pixels : {0.2, 0.6, 2.0}) {
    const bsi::DetailSurface detail =
        bsi::detail_within(pyramid, body.positions, pixel_tolerance(camera, size, size, pixels));
    EXPECT_LT(detail.triangles.size(), triangles);
    triangles = detail.triangles.size();
    double farthest = 0;
    for (std::size_t i = 0; i < detail.positions.size(); ++i) {
      const Vec3& counterpart = body.positions[detail.particles[i]];
      farthest = std::max(farthest, (seen(detail.positions[i]) - seen(counterpart)).norm());
    }
    // The particle may be half a quad, which is a fifth of a pixel, off the middle of a block.
    EXPECT_LT(farthest, pixels + 0.2);
    EXPECT_GT(farthest, 0.3 * pixels);
  }
}

// With the original's normals, a surface is lit like the original, however coarse its triangles.
TEST(LevelOfDetail, IsLitLikeTheOriginal) {
  Renderer renderer(size, size);
  const bsi::Surface body = bsi::make_sphere(1, 33);
  const bsi::Mesh mesh = bsi::build_mesh(body.atlas);
  const bsi::Pyramid pyramid = pyramid_of(body);
  const Camera camera = camera_from(directions[1]);
  const DrawnSurface full{body.positions, mesh.triangles, red, blue};
  const bsi::DetailSurface detail =
      bsi::detail_within(pyramid, body.positions, pixel_tolerance(camera, size, size, 1));
  ASSERT_LT(2 * detail.triangles.size(), mesh.triangles.size());
  const std::vector<Vec3> normals = detail_normals(detail, full);
  DrawnSurface reduced{detail.positions, detail.triangles, red, blue};
  const auto difference = [&](const DrawnSurface& surface) {
    const Picture picture = renderer.draw(std::array{surface}, camera);
    const Picture original = renderer.draw(std::array{full}, camera);
    const Mask inside = eroded(red_pixels(original), 3);
    double sum = 0;
    for (std::size_t i = 0; i < inside.size(); ++i) {
      if (inside[i]) sum += std::abs(picture.rgb[3 * i] - original.rgb[3 * i]);
    }
    return sum / count(inside);
  };
  const double without = difference(reduced);
  reduced.normals = normals;
  EXPECT_LT(difference(reduced), 0.5);
  EXPECT_LT(difference(reduced), without);
}

}  // namespace
}  // namespace weft::gpu::level_of_detail_test
