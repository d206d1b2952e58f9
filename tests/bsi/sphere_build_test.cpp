#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "bsi/pyramid.h"
#include "bsi/shapes.h"
#include "bsi/traversal.h"
#include "tests/bsi/crumpled.h"

namespace weft::bsi::sphere_build_test {
namespace {

using Positions = std::vector<Vec3>;

Surface moved(Surface surface, double noise, const Vec3& offset, double scale = 1) {
  surface.positions = crumpled(surface.positions, noise, surface.atlas.texel_count());
  for (Vec3& p : surface.positions) p = scale * p + offset;
  return surface;
}

// Returns surfaces of sizes that are powers of two and not; long, wrapped, of several patches,
// sewn; near and far from the origin, large and small.
std::vector<Surface> surfaces() {
  return {moved(make_rectangle(1, 1, 2, 2), 0.1, {0, 0, 0}),
          moved(make_rectangle(1, 1, 3, 3), 0, {0, 0, 0}),
          moved(make_rectangle(1, 2, 12, 15), 0.05, {0, 0, 0}),
          moved(make_rectangle(1, 0.1, 3, 40), 0.01, {1e4, -2e4, 3}),
          moved(make_torus(0.5, 0.2, 17, 9), 0.01, {0, 0, 0}),
          moved(make_sphere(0.4, 6), 0.01, {1, 2, 3}),
          moved(make_rectangle(1, 1, 20, 20), 0.1, {0, 0, 0}, 1e17),
          moved(make_rectangle(1, 1, 9, 9), 0.1, {0, 0, 0}, 1e-19),
          moved(make_rectangle(1, 1, 9, 12), 0, {1, -2, 3}, 0),  // all vertices in one place
          moved(make_rectangle(1, 1, 200, 200), 0.003, {0, 0, 0})};
}

// Visits every block of the pyramid except the groups.
template <class Visit>
void for_each_block(const Pyramid& pyramid, const Visit& visit) {
  for (int patch = 0; patch < pyramid.patch_count(); ++patch) {
    for (int level = 0; level < pyramid.levels(patch); ++level) {
      for (int v = 0; v < pyramid.blocks_v(patch, level); ++v) {
        for (int u = 0; u < pyramid.blocks_u(patch, level); ++u) visit(patch, level, u, v);
      }
    }
  }
}

Vec3 centre_of(const Sphere& sphere) {
  return Eigen::Vector3f(sphere.x, sphere.y, sphere.z).cast<double>();
}

Vec3 corner_of(const Box& box, int corner) {
  Vec3 result;
  for (int axis = 0; axis < 3; ++axis) {
    const float bound = (corner >> axis & 1) != 0 ? box.high[axis] : box.low[axis];
    result[axis] = static_cast<double>(bound);
  }
  return result;
}

double half_diagonal(const Box& box) { return (corner_of(box, 7) - corner_of(box, 0)).norm() / 2; }

// Returns the distance by which a block's farthest vertex lies outside its sphere, m.
double vertices_beyond(const Pyramid& pyramid, const Positions& positions, int patch, int level,
                       int u, int v) {
  const Sphere sphere = pyramid.sphere(patch, level, u, v);
  const QuadRange quads = pyramid.quads(patch, level, u, v);
  const Patch& image = pyramid.atlas().patches()[patch];
  double farthest = 0;
  for (int row = quads.row_begin; row <= quads.row_end; ++row) {
    for (int col = quads.col_begin; col <= quads.col_end; ++col) {
      const int particle = pyramid.atlas().particle(patch, row % image.rows, col % image.cols);
      farthest = std::max(farthest, (positions[particle] - centre_of(sphere)).norm());
    }
  }
  return farthest - static_cast<double>(sphere.radius);
}

TEST(PyramidSpheres, HoldEveryVertexAtBothEnds) {
  for (const Surface& surface : surfaces()) {
    Pyramid pyramid(surface.atlas, {.tangents = false, .spheres = true});
    const Positions end = crumpled(surface.positions, 0.02, 7);
    ASSERT_FALSE(pyramid.rebuild(surface.positions));
    for_each_block(pyramid, [&](int patch, int level, int u, int v) {
      ASSERT_LE(vertices_beyond(pyramid, surface.positions, patch, level, u, v), 0);
    });
    ASSERT_FALSE(pyramid.rebuild_swept(surface.positions, end));
    for_each_block(pyramid, [&](int patch, int level, int u, int v) {
      ASSERT_LE(vertices_beyond(pyramid, surface.positions, patch, level, u, v), 0);
      ASSERT_LE(vertices_beyond(pyramid, end, patch, level, u, v), 0);
    });
  }
}

// If spheres did not contain these boxes, a traversal by spheres would lose pairs that one by boxes
// finds.
TEST(PyramidSpheres, HoldTheBoxesOfAllTheirLeafBlocks) {
  for (const Surface& surface : surfaces()) {
    Pyramid pyramid(surface.atlas, {.tangents = false, .spheres = true});
    ASSERT_FALSE(pyramid.rebuild(surface.positions));
    for_each_block(pyramid, [&](int patch, int level, int u, int v) {
      const int leaf_level = pyramid.levels(patch) - 1;
      if (level != leaf_level) return;
      const Box box = pyramid.box(patch, level, u, v);
      // Checks the leaf block and all its ancestors.
      for (int at = level; at >= 0; --at) {
        const auto shift = [&](int blocks_here, int blocks_above, int place) {
          return blocks_above < blocks_here ? place / 2 : place;
        };
        const Sphere sphere = pyramid.sphere(patch, at, u, v);
        for (int corner = 0; corner < 8; ++corner) {
          ASSERT_LE((corner_of(box, corner) - centre_of(sphere)).norm(),
                    static_cast<double>(sphere.radius));
        }
        if (at == 0) break;
        u = shift(pyramid.blocks_u(patch, at), pyramid.blocks_u(patch, at - 1), u);
        v = shift(pyramid.blocks_v(patch, at), pyramid.blocks_v(patch, at - 1), v);
      }
    });
  }
}

TEST(PyramidSpheres, HaveTheirCentresInTheMiddleOfTheBoxesAndReachNoFartherThanThem) {
  for (const Surface& surface : surfaces()) {
    Pyramid pyramid(surface.atlas, {.tangents = false, .spheres = true});
    ASSERT_FALSE(pyramid.rebuild(surface.positions));
    for_each_block(pyramid, [&](int patch, int level, int u, int v) {
      const Sphere sphere = pyramid.sphere(patch, level, u, v);
      const Box box = pyramid.box(patch, level, u, v);
      const double size = corner_of(box, 0).cwiseAbs().cwiseMax(corner_of(box, 7).cwiseAbs()).sum();
      const double rounding = 1e-6 * (half_diagonal(box) + size) + 1e-17;
      const Vec3 middle = 0.5 * (corner_of(box, 0) + corner_of(box, 7));
      ASSERT_LE((centre_of(sphere) - middle).norm(), rounding);
      ASSERT_LE(static_cast<double>(sphere.radius), half_diagonal(box) + rounding);
    });
  }
}

// A square that stands on a corner fills half its box: its sphere must be the smaller one.
TEST(PyramidSpheres, AreSmallerThanTheirBoxesWhereTheChildrenAre) {
  Surface sheet = make_rectangle(1, 1, 65, 65);
  const double c = std::sqrt(0.5);
  for (Vec3& p : sheet.positions) p = Vec3(c * p.x() - c * p.y(), c * p.x() + c * p.y(), p.z());
  Pyramid pyramid(sheet.atlas, {.tangents = false, .spheres = true});
  ASSERT_FALSE(pyramid.rebuild(sheet.positions));
  const double exact = std::sqrt(0.5);  // half the diagonal of the sheet
  EXPECT_GE(static_cast<double>(pyramid.sphere(0, 0, 0, 0).radius), exact);
  EXPECT_LE(static_cast<double>(pyramid.sphere(0, 0, 0, 0).radius), 1.05 * exact);
  EXPECT_NEAR(half_diagonal(pyramid.box(0, 0, 0, 0)), std::sqrt(2.0) * exact, 1e-6);
}

// Half the diagonal of the box is 1.44 times as much; spheres around the children's need 1.36
// times.
TEST(PyramidSpheres, AreTightAtTheTop) {
  const Surface torus = make_torus(0.3, 0.1, 64, 64);
  Pyramid pyramid(torus.atlas, {.tangents = false, .spheres = true});
  ASSERT_FALSE(pyramid.rebuild(torus.positions));
  EXPECT_GE(static_cast<double>(pyramid.sphere(0, 0, 0, 0).radius), 0.4);
  EXPECT_LE(static_cast<double>(pyramid.sphere(0, 0, 0, 0).radius), 1.1 * 0.4);
}

TEST(PyramidSpheres, AreTheSameOnAnyNumberOfThreads) {
  const Surface surface = moved(make_rectangle(1, 1, 300, 280), 0.003, {0, 0, 0});
  Pyramid one(surface.atlas, {.spheres = true}), four(surface.atlas, {.spheres = true});
  ASSERT_FALSE(one.rebuild(surface.positions, 1));
  ASSERT_FALSE(four.rebuild(surface.positions, 4));
  for_each_block(one, [&](int patch, int level, int u, int v) {
    ASSERT_EQ(one.sphere(patch, level, u, v), four.sphere(patch, level, u, v));
  });
}

// Two sheets whose distance is the margin, rotated so that corners of leaves meet: rounding of
// spheres would lose these pairs first.
TEST(PyramidSpheres, LoseNoPairAtTheMarginHoweverFarFromTheOrigin) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int found = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const Vec3 away =
        std::pow(10.0, trial % 6) * Vec3(uniform(random), uniform(random), uniform(random));
    Surface first = make_rectangle(1, 1, 9, 9), second = make_rectangle(1, 1, 9, 9);
    const Eigen::Matrix3d turn = Eigen::Quaterniond::UnitRandom().toRotationMatrix();
    const double margin = 0.01 + 0.1 * std::abs(uniform(random));
    for (Vec3& p : first.positions) p = turn * p + away;
    for (Vec3& p : second.positions) p = turn * (p + Vec3(0.9, 0.9, margin)) + away;
    Pyramid a(first.atlas, {.spheres = true}), b(second.atlas, {.spheres = true});
    ASSERT_FALSE(a.rebuild(first.positions));
    ASSERT_FALSE(b.rebuild(second.positions));
    std::vector<LeafPair> by_spheres, by_boxes;
    TraversalCounters counters;
    dual_traversal(a, b, {.margin = margin, .bound = Bound::sphere}, by_spheres, counters);
    dual_traversal(a, b, {.margin = margin, .bound = Bound::box}, by_boxes, counters);
    std::ranges::sort(by_spheres);
    std::ranges::sort(by_boxes);
    ASSERT_EQ(by_spheres, by_boxes) << "trial " << trial;
    found += static_cast<int>(by_boxes.size());
  }
  EXPECT_GT(found, 1000);
}

TEST(PyramidSpheres, OfAnotherImageForgetTheLast) {
  const Surface wide = make_rectangle(4, 4, 20, 20), small = make_rectangle(0.1, 0.1, 20, 20);
  Pyramid again(wide.atlas, {.spheres = true}), fresh(wide.atlas, {.spheres = true});
  ASSERT_FALSE(again.rebuild_swept(wide.positions, small.positions));
  ASSERT_FALSE(again.rebuild(small.positions));
  ASSERT_FALSE(fresh.rebuild(small.positions));
  for_each_block(fresh, [&](int patch, int level, int u, int v) {
    ASSERT_EQ(again.sphere(patch, level, u, v), fresh.sphere(patch, level, u, v));
  });
}

TEST(Sphere, GapIsALowerBoundOfTheDistance) {
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
}  // namespace weft::bsi::sphere_build_test
