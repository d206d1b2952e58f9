#include "gpu/compute_pyramid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "bsi/shapes.h"
#include "tests/gpu/test_context.h"

namespace weft::gpu::compute_pyramid_test {
namespace {

using bsi::Atlas;
using bsi::Patch;

// Returns bodies of every kind: wrapped, sewn, not square, of sizes that are no powers of two, of
// one quad.
std::vector<bsi::Surface> bodies_of_every_kind() {
  std::vector<bsi::Surface> bodies;
  bodies.push_back(bsi::make_torus(1.0, 0.3, 17, 23));
  bodies.push_back(bsi::make_sphere(0.7, 6));
  bodies.push_back(bsi::make_rectangle(2.0, 1.0, 2, 41));
  bodies.push_back(bsi::make_rectangle(1.0, 1.0, 33, 33));
  bodies.push_back(bsi::make_rectangle(1.0, 1.0, 2, 2));
  bodies.push_back(bsi::make_cylinder(0.5, 1.0, 9, 5));
  return bodies;
}

std::vector<const Atlas*> atlases(const std::vector<bsi::Surface>& bodies) {
  std::vector<const Atlas*> result;
  result.reserve(bodies.size());
  for (const bsi::Surface& body : bodies) result.push_back(&body.atlas);
  return result;
}

std::vector<Vec3> shaken(std::vector<Vec3> positions, double by, std::mt19937& random) {
  std::uniform_real_distribution<double> shift(-by, by);
  for (Vec3& p : positions) p += Vec3(shift(random), shift(random), shift(random));
  return positions;
}

// Visits all vertices of a block, at both ends of their paths.
template <typename Visit>
void visit_vertices(const Atlas& atlas, const BodyImage& image, int patch,
                    const bsi::QuadRange& range, const Visit& visit) {
  for (int row = range.row_begin; row <= range.row_end; ++row) {
    for (int col = range.col_begin; col <= range.col_end; ++col) {
      const int particle = atlas.particle(patch, row, col);
      visit(image.start[particle]);
      if (!image.end.empty()) visit(image.end[particle]);
    }
  }
}

// visit(patch, level, quads, block)
template <typename Visit>
void visit_blocks(const ComputePyramid& pyramid, int body, const Visit& visit) {
  for (int patch = 0; patch < static_cast<int>(pyramid.atlas(body).patches().size()); ++patch) {
    const Patch& image = pyramid.atlas(body).patches()[patch];
    for (int level = 0; level < pyramid.levels(body, patch); ++level) {
      const bsi::BlockLevel& place = pyramid.level(body, patch, level);
      for (int v = 0; v < 1 << place.log_v; ++v) {
        for (int u = 0; u < 1 << place.log_u; ++u) {
          const auto row = [&](int k) {
            return bsi::block_boundary(k, image.quad_rows(), place.log_v);
          };
          const auto col = [&](int k) {
            return bsi::block_boundary(k, image.quad_cols(), place.log_u);
          };
          visit(patch, level, bsi::QuadRange{row(v), row(v + 1), col(u), col(u + 1)},
                place.block(u, v));
        }
      }
    }
  }
}

// Counts the boxes that are not the minima and maxima of their rounded vertices.
int wrong_boxes(const ComputePyramid& pyramid, const BodyImage& image) {
  const std::vector<BlockBox> boxes = pyramid.read_boxes(image.body);
  const Atlas& atlas = pyramid.atlas(image.body);
  int wrong = 0;
  visit_blocks(pyramid, image.body,
               [&](int patch, int, const bsi::QuadRange& range, std::size_t block) {
                 constexpr float far = std::numeric_limits<float>::max();
                 BlockBox expected{{far, far, far}, {-far, -far, -far}};
                 visit_vertices(atlas, image, patch, range, [&](const Vec3& p) {
                   for (int axis = 0; axis < 3; ++axis) {
                     const auto rounded = static_cast<float>(p[axis]);
                     expected.low[axis] = std::min(expected.low[axis], rounded);
                     expected.high[axis] = std::max(expected.high[axis], rounded);
                   }
                 });
                 wrong += boxes[block] == expected ? 0 : 1;
               });
  return wrong;
}

// Counts vertices outside the spheres of their blocks, in float64, and spheres that are larger than
// the half diagonal of their boxes.
int wrong_spheres(const ComputePyramid& pyramid, const BodyImage& image) {
  const std::vector<bsi::Sphere> spheres = pyramid.read_spheres(image.body);
  const std::vector<BlockBox> boxes = pyramid.read_boxes(image.body);
  const Atlas& atlas = pyramid.atlas(image.body);
  int wrong = 0;
  visit_blocks(
      pyramid, image.body, [&](int patch, int, const bsi::QuadRange& range, std::size_t block) {
        const bsi::Sphere& sphere = spheres[block];
        const Vec3 centre(sphere.x, sphere.y, sphere.z);
        visit_vertices(atlas, image, patch, range, [&](const Vec3& p) {
          if ((p - centre).norm() > static_cast<double>(sphere.radius)) ++wrong;
        });
        Vec3 low, high;
        for (int axis = 0; axis < 3; ++axis) {
          low[axis] = static_cast<double>(boxes[block].low[axis]);
          high[axis] = static_cast<double>(boxes[block].high[axis]);
        }
        // Allows for the least radius that every level adds, and for the rounding of the vertices.
        const double allowed = 2e-17 + 1e-6 * low.cwiseAbs().cwiseMax(high.cwiseAbs()).maxCoeff();
        if (static_cast<double>(sphere.radius) > (high - low).norm() / 2 * (1 + 2e-6) + allowed) {
          ++wrong;
        }
      });
  return wrong;
}

TEST(ComputePyramid, BoundsBodiesOfEveryKindInOneBatch) {
  WEFT_NEEDS_CONTEXT();
  std::mt19937 random(1);
  const std::vector<bsi::Surface> bodies = bodies_of_every_kind();
  ComputePyramid pyramid(context, atlases(bodies));
  std::vector<std::vector<Vec3>> starts, ends;
  std::vector<BodyImage> images;
  images.reserve(bodies.size());
  for (const bsi::Surface& body : bodies) {
    starts.push_back(shaken(body.positions, 0.02, random));
    ends.push_back(shaken(body.positions, 0.2, random));
  }
  for (int b = 0; b < static_cast<int>(bodies.size()); ++b) {
    // Every other body is swept.
    images.push_back({.body = b,
                      .start = starts[b],
                      .end = b % 2 == 0 ? std::span<const Vec3>() : ends[b],
                      .spheres = true});
  }
  pyramid.rebuild(images);
  EXPECT_FALSE(pyramid.first_unbounded());
  for (const BodyImage& image : images) {
    EXPECT_EQ(wrong_boxes(pyramid, image), 0) << "body " << image.body;
    EXPECT_EQ(wrong_spheres(pyramid, image), 0) << "body " << image.body;
  }
}

TEST(ComputePyramid, RebuildsSomeBodiesAndLeavesTheOthers) {
  WEFT_NEEDS_CONTEXT();
  std::mt19937 random(2);
  const std::vector<bsi::Surface> bodies = bodies_of_every_kind();
  ComputePyramid pyramid(context, atlases(bodies));
  std::vector<BodyImage> images;
  images.reserve(bodies.size());
  for (int b = 0; b < static_cast<int>(bodies.size()); ++b) {
    images.push_back({b, bodies[b].positions});
  }
  pyramid.rebuild(images);
  const std::vector<Vec3> moved = shaken(bodies[1].positions, 0.1, random);
  const std::vector<Vec3> further = shaken(bodies[1].positions, 0.1, random);
  images[1] = {1, moved, further};
  pyramid.rebuild(std::span(&images[1], 1));
  for (const BodyImage& image : images) {
    EXPECT_EQ(wrong_boxes(pyramid, image), 0) << "body " << image.body;
  }
  EXPECT_TRUE(pyramid.is_swept(1));
  // The body is plain again.
  images[1] = {1, moved};
  pyramid.rebuild(std::span(&images[1], 1));
  EXPECT_EQ(wrong_boxes(pyramid, images[1]), 0);
}

TEST(ComputePyramid, SpheresBoundWhateverTheSize) {
  WEFT_NEEDS_CONTEXT();
  std::mt19937 random(3);
  const bsi::Surface sheet = bsi::make_rectangle(1.0, 1.0, 20, 13);
  const std::array<const Atlas*, 1> atlas{&sheet.atlas};
  ComputePyramid pyramid(context, atlas);
  struct Place {
    double scale;
    double distance;
  };
  for (const Place& place : {Place{1e6, 1e6}, Place{1, 1e6}, Place{1e-6, 0}, Place{1e-6, 1},
                             Place{1e-30, 0}, Place{1e-41, 0}, Place{0, 3}, Place{1e17, 0}}) {
    std::vector<Vec3> positions = shaken(sheet.positions, 0.3, random);
    for (Vec3& p : positions) p = place.scale * p + Vec3::Constant(place.distance);
    const BodyImage image{.body = 0, .start = positions, .spheres = true};
    pyramid.rebuild(std::span(&image, 1));
    EXPECT_FALSE(pyramid.first_unbounded()) << place.scale;
    EXPECT_EQ(wrong_spheres(pyramid, image), 0) << place.scale << " at " << place.distance;
  }
}

// Spheres agree to the last bit if roots round as on the CPU, except on the four top levels, which
// the CPU tightens further.
TEST(ComputePyramid, SpheresAreThoseOfTheCpu) {
  WEFT_NEEDS_CONTEXT();
  std::mt19937 random(4);
  const std::vector<bsi::Surface> bodies = bodies_of_every_kind();
  ComputePyramid pyramid(context, atlases(bodies));
  int compared = 0;
  for (int b = 0; b < static_cast<int>(bodies.size()); ++b) {
    const std::vector<Vec3> positions = shaken(bodies[b].positions, 0.01, random);
    const BodyImage image{.body = b, .start = positions, .spheres = true};
    pyramid.rebuild(std::span(&image, 1));
    const std::vector<bsi::Sphere> spheres = pyramid.read_spheres(b);
    bsi::Pyramid expected(bodies[b].atlas, {.tangents = false, .spheres = true});
    ASSERT_FALSE(expected.rebuild(positions));
    for (int patch = 0; patch < expected.patch_count(); ++patch) {
      for (int level = 0; level < expected.levels(patch); ++level) {
        const bsi::BlockLevel& place = pyramid.level(b, patch, level);
        for (std::size_t i = 0; i < place.count(); ++i, ++compared) {
          const int u = static_cast<int>(i) & ((1 << place.log_u) - 1);
          const int v = static_cast<int>(i) >> place.log_u;
          const bsi::Sphere& ours = spheres[place.first + i];
          const bsi::Sphere theirs = expected.sphere(patch, level, u, v);
          if (context.backend() == GlBackend::hardware || level < 4) {
            ASSERT_GE(ours.radius, 0.99999F * theirs.radius) << level << " " << i;
            ASSERT_LE(ours.radius, 1.5F * theirs.radius) << level << " " << i;
          } else {
            ASSERT_EQ(ours, theirs) << level << " " << i;
          }
        }
      }
    }
  }
  EXPECT_GT(compared, 800);
}

TEST(ComputePyramid, NamesTheFirstTexelThatIsNotFinite) {
  WEFT_NEEDS_CONTEXT();
  const std::vector<bsi::Surface> bodies = bodies_of_every_kind();
  ComputePyramid pyramid(context, atlases(bodies));
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::quiet_NaN(),
        std::numeric_limits<double>::infinity(), -1e19}) {
    for (int b = 0; b < static_cast<int>(bodies.size()); ++b) {
      const Atlas& atlas = bodies[b].atlas;
      const int particle = 2 * atlas.particle_count() / 3;
      std::vector<Vec3> positions = bodies[b].positions;
      positions[particle].y() = bad;
      positions.back().z() = bad;
      for (const bool at_end : {false, true}) {
        const BodyImage image{b, at_end ? bodies[b].positions : positions,
                              at_end ? std::span<const Vec3>(positions) : std::span<const Vec3>()};
        pyramid.rebuild(std::span(&image, 1));
        const auto found = pyramid.first_unbounded();
        ASSERT_TRUE(found) << bad << " in body " << b;
        const bsi::TexelAddress expected = atlas.particle_address(particle);
        EXPECT_EQ(found->body, b);
        EXPECT_EQ(found->texel.patch, expected.patch);
        EXPECT_EQ(found->texel.row, expected.row);
        EXPECT_EQ(found->texel.col, expected.col);
      }
      const BodyImage good{b, bodies[b].positions};
      pyramid.rebuild(std::span(&good, 1));
      EXPECT_FALSE(pyramid.first_unbounded());
    }
  }
}

TEST(ComputePyramid, RefusesWhatTheDeviceCannotHold) {
  WEFT_NEEDS_CONTEXT();
  const Atlas long_strip({Patch{2, ComputePyramid::quad_limit + 2, false, false}});
  const std::array<const Atlas*, 1> bodies{&long_strip};
  EXPECT_THROW(ComputePyramid(context, bodies), std::runtime_error);
}

}  // namespace
}  // namespace weft::gpu::compute_pyramid_test
