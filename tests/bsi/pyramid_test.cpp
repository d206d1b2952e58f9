#include "bsi/pyramid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <tuple>
#include <utility>

#include "bsi/shapes.h"
#include "tests/bsi/pyramid_checks.h"

namespace weft::bsi {
namespace {

TEST(Pyramid, LevelsSplitTheQuadsOfAPatchIntoNestedBlocks) {
  const Surface surface = make_rectangle(1, 1, 6, 12);  // 5 x 11 quads
  const Pyramid pyramid(surface.atlas);
  ASSERT_EQ(pyramid.levels(0), 5);
  const std::vector<std::pair<int, int>> blocks{{1, 1}, {2, 2}, {4, 4}, {8, 8}, {16, 8}};
  for (int level = 0; level < 5; ++level) {
    EXPECT_EQ(pyramid.blocks_u(0, level), blocks[level].first);
    EXPECT_EQ(pyramid.blocks_v(0, level), blocks[level].second);
    EXPECT_EQ(pyramid.level_spheres(0, level).size(),
              static_cast<std::size_t>(blocks[level].first) * blocks[level].second);
  }
  const QuadRange range = pyramid.quads(0, 2, 1, 3);
  EXPECT_EQ(std::tuple(range.row_begin, range.row_end), std::tuple(3, 5));
  EXPECT_EQ(std::tuple(range.col_begin, range.col_end), std::tuple(2, 5));
}

TEST(Pyramid, ChildrenShareOutTheQuadsOfTheirParent) {
  for (const Surface& surface : surfaces()) {
    Pyramid pyramid(surface.atlas);
    ASSERT_FALSE(pyramid.rebuild(surface.positions));
    std::vector<int> all(surface.atlas.quad_count());
    std::iota(all.begin(), all.end(), 0);
    EXPECT_EQ(quads_below(pyramid, pyramid.root()), all);
    for (const Block& block : all_blocks(pyramid)) {
      if (block.patch == Block::group) continue;
      const QuadRange range = pyramid.quads(block.patch, block.level, block.u, block.v);
      std::vector<int> expected;
      for (int row = range.row_begin; row < range.row_end; ++row) {
        for (int col = range.col_begin; col < range.col_end; ++col) {
          expected.push_back(surface.atlas.first_quad(block.patch) + col +
                             row * surface.atlas.patches()[block.patch].quad_cols());
        }
      }
      EXPECT_EQ(quads_below(pyramid, block), expected);
    }
  }
}

TEST(Pyramid, BlocksWithoutQuadsHaveANegativeRadius) {
  for (const Surface& surface : surfaces()) {
    for (const RadiusPolicy policy : all_policies) {
      Pyramid pyramid(surface.atlas, policy);
      ASSERT_FALSE(pyramid.rebuild(surface.positions));
      for (int patch = 0; patch < pyramid.patch_count(); ++patch) {
        for (int level = 0; level < pyramid.levels(patch); ++level) {
          for (int v = 0; v < pyramid.blocks_v(patch, level); ++v) {
            for (int u = 0; u < pyramid.blocks_u(patch, level); ++u) {
              EXPECT_EQ(pyramid.quads(patch, level, u, v).empty(),
                        pyramid.sphere(patch, level, u, v).radius < 0);
            }
          }
        }
      }
    }
  }
}

TEST(Pyramid, BoundsEveryVertexTightly) {
  for (const Surface& surface : surfaces()) {
    Pyramid fast(surface.atlas, RadiusPolicy::fast);
    Pyramid exact(surface.atlas, RadiusPolicy::exact);
    ASSERT_FALSE(fast.rebuild(surface.positions));
    ASSERT_FALSE(exact.rebuild(surface.positions));
    expect_conservative(fast, surface.positions);
    expect_conservative(exact, surface.positions);
    expect_tight(exact, surface.positions, 1 + 1e-6);
    // The half diagonal of a box is at most sqrt(3) times what its faces, each touched by a vertex,
    // demand.
    expect_tight(fast, surface.positions, std::sqrt(3.0) + 1e-5);
  }
}

TEST(Pyramid, FastRadiiOfASmoothSurfaceAreNearlyExact) {
  const Surface surface = make_torus(1.0, 0.3, 64, 64);
  Pyramid pyramid(surface.atlas);
  ASSERT_FALSE(pyramid.rebuild(surface.positions));
  double worst = 1;
  for (const Block& block : all_blocks(pyramid)) {
    if (block.level < 4) continue;
    const auto exact = static_cast<double>(reach(pyramid, block, surface.positions));
    worst = std::max(worst, pyramid.sphere(block).radius / exact);
  }
  EXPECT_LT(worst, 1.07);
}

TEST(Pyramid, RadiiDoNotDependOnThePlace) {
  // Odd sizes: blocks without quads must not draw their parents towards the origin.
  for (const Surface& surface : surfaces()) {
    Positions moved;
    for (const Vec3& position : surface.positions) moved.emplace_back(position + Vec3(8, -16, 4));
    Pyramid here(surface.atlas);
    Pyramid there(surface.atlas);
    ASSERT_FALSE(here.rebuild(surface.positions));
    ASSERT_FALSE(there.rebuild(moved));
    for (const Block& block : all_blocks(here)) {
      // Rounding, up to the sum of the coordinates.
      EXPECT_NEAR(here.sphere(block).radius, there.sphere(block).radius, 28 * 0x1p-22);
    }
  }
}

TEST(Pyramid, RepeatedRebuildsForgetTheLastImage) {
  const Surface surface = crumple(make_sphere(1.0, 7), 0.1, 8);
  Pyramid once(surface.atlas);
  Pyramid twice(surface.atlas);
  ASSERT_FALSE(twice.rebuild(Positions(surface.positions.size(), Vec3(100, 200, -300))));
  ASSERT_FALSE(once.rebuild(surface.positions));
  ASSERT_FALSE(twice.rebuild(surface.positions));
  for (const Block& block : all_blocks(once)) {
    EXPECT_EQ(once.sphere(block).x, twice.sphere(block).x);
    EXPECT_EQ(once.sphere(block).radius, twice.sphere(block).radius);
  }
}

TEST(Pyramid, SweptSpheresBoundStraightPaths) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (const Surface& surface : surfaces()) {
    const Positions end = crumple(surface, 0.3, 9).positions;
    for (const RadiusPolicy policy : all_policies) {
      Pyramid pyramid(surface.atlas, policy);
      ASSERT_FALSE(pyramid.rebuild_swept(surface.positions, end));
      expect_conservative(pyramid, surface.positions);
      expect_conservative(pyramid, end);
      const double t = uniform(random);
      Positions between(end.size());
      for (std::size_t i = 0; i < end.size(); ++i) {
        between[i] = (1 - t) * surface.positions[i] + t * end[i];
      }
      expect_conservative(pyramid, between);
    }
  }
}

TEST(Pyramid, ExactSweptRadiiReachTheFartherEnd) {
  const Surface surface = crumple(make_rectangle(1, 1, 20, 13), 0.05, 12);
  const Positions end = crumple(surface, 0.3, 13).positions;
  Pyramid pyramid(surface.atlas, RadiusPolicy::exact);
  ASSERT_FALSE(pyramid.rebuild_swept(surface.positions, end));
  for (const Block& block : all_blocks(pyramid)) {
    const auto farther =
        std::max(reach(pyramid, block, surface.positions), reach(pyramid, block, end));
    EXPECT_LE(pyramid.sphere(block).radius, farther * (1 + 1e-6L) + 1e-6L);
  }
}

TEST(Pyramid, SweptAlongNoPathIsTheStillPyramid) {
  const Surface surface = crumple(make_torus(1.0, 0.3, 9, 14), 0.05, 14);
  Pyramid still(surface.atlas);
  Pyramid swept(surface.atlas);
  ASSERT_FALSE(still.rebuild(surface.positions));
  ASSERT_FALSE(swept.rebuild_swept(surface.positions, surface.positions));
  for (const Block& block : all_blocks(still)) {
    EXPECT_FLOAT_EQ(still.sphere(block).radius, swept.sphere(block).radius);
  }
}

// Sizes and places from denormal numbers to the limit: bounds hold, and are no looser than the
// spacing of float32 numbers there demands.
TEST(Pyramid, StaysConservativeAtEveryScale) {
  const Surface shape = crumple(make_torus(1.0, 0.4, 11, 6), 0.1, 15);
  const double denormal = std::numeric_limits<double>::denorm_min();
  for (const double size : {1e17, 1e6, 1.0, 1e-6, 1e-15, 1e-20, 1e-30, 1e-42, 1e-310, denormal}) {
    for (const double offset : {0.0, 1e-44, 1e-6, 1.0, 1e6, 1e15}) {
      Positions positions;
      for (const Vec3& point : shape.positions) {
        positions.emplace_back(size * point + Vec3(offset, -offset / 3, offset * 0.7));
      }
      for (const RadiusPolicy policy : all_policies) {
        SCOPED_TRACE("size " + std::to_string(size) + ", offset " + std::to_string(offset));
        Pyramid pyramid(shape.atlas, policy);
        ASSERT_FALSE(pyramid.rebuild(positions));
        expect_conservative(pyramid, positions);
        expect_tight(pyramid, positions, std::sqrt(3.0) + 1e-5);
      }
    }
  }
}

TEST(Pyramid, BoundsCoincidentVertices) {
  const Vec3 point(0.1, -12345.678, 1e-3);
  for (const RadiusPolicy policy : all_policies) {
    Pyramid pyramid(make_sphere(1.0, 6).atlas, policy);
    const Positions positions(pyramid.atlas().particle_count(), point);
    ASSERT_FALSE(pyramid.rebuild(positions));
    expect_conservative(pyramid, positions);
    expect_tight(pyramid, positions, 1);
  }
}

TEST(Pyramid, FindsTheFirstTexelThatIsNotFinite) {
  const double infinity = std::numeric_limits<double>::infinity();
  const std::array bad{std::numeric_limits<double>::quiet_NaN(), infinity, -infinity, 1e300, -1e18};
  for (const Surface& surface : surfaces()) {
    Pyramid pyramid(surface.atlas);
    Positions positions = surface.positions;
    for (int particle = 0; particle < surface.atlas.particle_count(); ++particle) {
      double& coordinate = positions[particle][particle % 3];
      coordinate = bad[particle % bad.size()];
      const auto found = particle % 4 < 2    ? pyramid.rebuild(positions)
                         : particle % 4 == 2 ? pyramid.rebuild_swept(positions, surface.positions)
                                             : pyramid.rebuild_swept(surface.positions, positions);
      const TexelAddress expected = surface.atlas.particle_address(particle);
      ASSERT_TRUE(found);
      EXPECT_FALSE(pyramid.is_built());
      EXPECT_EQ(std::tuple(found->patch, found->row, found->col),
                std::tuple(expected.patch, expected.row, expected.col));
      coordinate = surface.positions[particle][particle % 3];
    }
    EXPECT_FALSE(pyramid.rebuild(positions));
    EXPECT_TRUE(pyramid.is_built());
    expect_conservative(pyramid, surface.positions);
  }
}

TEST(Pyramid, GapIsALowerBoundOfTheDistance) {
  EXPECT_NEAR(bounding_sphere_gap({0, 0, 0, 1}, {3, 4, 0, 1.5F}), 2.5, 1e-13);
  EXPECT_EQ(bounding_sphere_gap({0, 0, 0, 3}, {3, 4, 0, 2.5F}), 0);
  EXPECT_EQ(bounding_sphere_gap({0, 0, 0, -1}, {3, 4, 0, 2.5F}),
            std::numeric_limits<double>::infinity());
  std::mt19937 random(16);
  std::uniform_real_distribution<float> uniform(-1, 1);
  for (int i = 0; i < 1000; ++i) {
    const auto draw = [&] {
      return Sphere{uniform(random), uniform(random), uniform(random), std::abs(uniform(random))};
    };
    const Sphere a = draw();
    const Sphere b = draw();
    const auto x = static_cast<long double>(a.x) - b.x;
    const auto y = static_cast<long double>(a.y) - b.y;
    const auto z = static_cast<long double>(a.z) - b.z;
    const long double gap = std::sqrt(x * x + y * y + z * z) - a.radius - b.radius;
    EXPECT_LE(bounding_sphere_gap(a, b), std::max(gap, 0.0L));
    EXPECT_GE(bounding_sphere_gap(a, b), gap - 1e-14L);
  }
}

}  // namespace
}  // namespace weft::bsi
