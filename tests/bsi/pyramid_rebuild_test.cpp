// Rebuilds: the same spheres whoever makes them, and none that a vertex leaves.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "bsi/instruction_set.h"
#include "bsi/level_build.h"
#include "bsi/pyramid.h"
#include "tests/bsi/pyramid_checks.h"
#include "tests/bsi/restored_settings.h"

namespace weft::bsi {
namespace {

// All spheres: of the levels of every patch, then of the groups.
std::vector<Sphere> all_spheres(const Pyramid& pyramid) {
  std::vector<Sphere> all;
  const auto add = [&](std::span<const Sphere> some) {
    all.insert(all.end(), some.begin(), some.end());
  };
  for (int patch = 0; patch < pyramid.patch_count(); ++patch) {
    for (int level = 0; level < pyramid.levels(patch); ++level) {
      add(pyramid.level_spheres(patch, level));
    }
  }
  for (int level = 0; level < pyramid.group_levels(); ++level) add(pyramid.group_spheres(level));
  return all;
}

std::vector<Sphere> rebuilt(const Surface& surface, RadiusPolicy policy, Leaf leaf = Leaf::quad) {
  Pyramid pyramid(surface.atlas, policy, leaf);
  EXPECT_FALSE(pyramid.rebuild(surface.positions));
  return all_spheres(pyramid);
}

// Among them patches large enough for several threads, and such with empty blocks.
std::vector<Surface> small_and_large_surfaces() {
  std::vector<Surface> list = surfaces();
  list.push_back(crumple(make_rectangle(2, 2, 150, 97), 0.01, 21));
  list.push_back(crumple(make_torus(1.0, 0.3, 128, 70), 0.01, 22));
  list.push_back(crumple(make_rectangle(1, 9, 5, 2500), 0.01, 23));
  list.push_back(crumple(make_rectangle(9, 1, 2500, 5), 0.01, 24));
  list.push_back(crumple(make_sphere(1.0, 100), 0.003, 25));
  return list;
}

TEST(PyramidRebuild, HasTheSameBitsForAnyNumberOfThreads) {
  for (const Surface& surface : small_and_large_surfaces()) {
    const Positions end = crumple(surface, 0.1, 26).positions;
    for (const RadiusPolicy policy : {RadiusPolicy::fast, RadiusPolicy::exact}) {
      Pyramid pyramid(surface.atlas, policy, Leaf::triangle);
      std::vector<Sphere> still, swept;
      for (const int count : {1, 2, 3, 0}) {
        ASSERT_FALSE(pyramid.rebuild_swept(surface.positions, end, count));
        if (count == 1) swept = all_spheres(pyramid);
        EXPECT_TRUE(all_spheres(pyramid) == swept) << count << " threads, swept";
        ASSERT_FALSE(pyramid.rebuild(surface.positions, count));
        if (count == 1) still = all_spheres(pyramid);
        EXPECT_TRUE(all_spheres(pyramid) == still) << count << " threads";
      }
    }
  }
}

// Every thread has a workspace, which counts as memory.
TEST(PyramidRebuild, UsesTheThreadsAskedFor) {
  const RestoredSettings restored;
  const Surface surface = make_rectangle(1, 1, 150, 150);
  const auto bytes = [&](int of_openmp, int asked_for) {
    omp_set_num_threads(of_openmp);
    Pyramid pyramid(surface.atlas);
    EXPECT_FALSE(pyramid.rebuild(surface.positions, asked_for));
    return pyramid.bytes();
  };
  EXPECT_EQ(bytes(3, 1), bytes(1, 1));
  EXPECT_EQ(bytes(1, 3), bytes(3, 0));
  EXPECT_GT(bytes(1, 3), bytes(1, 2));
}

TEST(PyramidRebuild, HasTheSameBitsWithEveryInstructionSet) {
  const RestoredSettings restored;
  for (const Surface& surface : small_and_large_surfaces()) {
    for (const RadiusPolicy policy : {RadiusPolicy::fast, RadiusPolicy::exact}) {
      use_instruction_set(InstructionSet::portable);
      const std::vector<Sphere> expected = rebuilt(surface, policy, Leaf::triangle);
      for (const InstructionSet set : available_instruction_sets()) {
        use_instruction_set(set);
        EXPECT_TRUE(rebuilt(surface, policy, Leaf::triangle) == expected) << name(set);
      }
    }
  }
}

// The level alone visits every vertex of every block: the oracle of the pruned exact radii.
TEST(PyramidRebuild, MakesTheSpheresOfEveryLevelBuiltAlone) {
  for (const Surface& surface : small_and_large_surfaces()) {
    for (const RadiusPolicy policy : all_policies) {
      if (policy == RadiusPolicy::tight && surface.atlas.texel_count() > 5000) continue;
      Pyramid pyramid(surface.atlas, policy, Leaf::triangle);
      ASSERT_FALSE(pyramid.rebuild(surface.positions));
      std::vector<Sphere> alone;
      for (int patch = 0; patch < pyramid.patch_count(); ++patch) {
        for (int level = 0; level < pyramid.levels(patch); ++level) {
          ASSERT_FALSE(build_level(surface.atlas, surface.positions, patch, level, policy, alone));
          const auto whole = pyramid.level_spheres(patch, level);
          ASSERT_EQ(alone.size(), whole.size());
          for (std::size_t i = 0; i < alone.size(); ++i) {
            if (policy != RadiusPolicy::fast) {
              ASSERT_EQ(alone[i], whole[i]) << "patch " << patch << " level " << level << " " << i;
              continue;
            }
            EXPECT_EQ(alone[i].radius < 0, whole[i].radius < 0);
            if (alone[i].radius < 0) continue;
            EXPECT_EQ(std::tuple(alone[i].x, alone[i].y, alone[i].z),
                      std::tuple(whole[i].x, whole[i].y, whole[i].z));
            EXPECT_LE(alone[i].radius, whole[i].radius * (1 + 1e-6F) + 1e-6F);
          }
        }
      }
    }
  }
}

TEST(PyramidRebuild, LevelAloneNamesTheTexelThatIsNotFinite) {
  Surface surface = make_sphere(1.0, 5);
  surface.positions[40].y() = std::numeric_limits<double>::quiet_NaN();
  const TexelAddress expected = surface.atlas.particle_address(40);
  std::vector<Sphere> spheres;
  const auto found = build_level(surface.atlas, surface.positions, expected.patch, 1,
                                 RadiusPolicy::exact, spheres);
  ASSERT_TRUE(found);
  EXPECT_EQ(std::tuple(found->row, found->col), std::tuple(expected.row, expected.col));
  EXPECT_TRUE(spheres.empty());
}

TEST(PyramidRebuild, TightSpheresAreNeverLargerThanExactOnes) {
  double smaller = 0, count = 0;
  for (const Surface& surface : surfaces()) {
    const std::vector<Sphere> exact = rebuilt(surface, RadiusPolicy::exact, Leaf::triangle);
    const std::vector<Sphere> tight = rebuilt(surface, RadiusPolicy::tight, Leaf::triangle);
    ASSERT_EQ(exact.size(), tight.size());
    for (std::size_t i = 0; i < exact.size(); ++i) {
      EXPECT_LE(tight[i].radius, exact[i].radius);
      if (exact[i].radius < 0) continue;
      smaller += tight[i].radius < 0.98F * exact[i].radius ? 1 : 0;
      ++count;
    }
  }
  EXPECT_GT(smaller, 0.3 * count);
}

TEST(PyramidRebuild, LeavesOfTrianglesBoundTheirTriangles) {
  for (const Surface& surface : surfaces()) {
    const Positions end = crumple(surface, 0.2, 27).positions;
    for (const RadiusPolicy policy : all_policies) {
      Pyramid pyramid(surface.atlas, policy, Leaf::triangle);
      ASSERT_FALSE(pyramid.rebuild_swept(surface.positions, end));
      std::vector<int> triangles;
      for (const Block& block : all_blocks(pyramid)) {
        if (!pyramid.is_leaf(block)) continue;
        const int triangle = pyramid.triangle_of_leaf(block);
        triangles.push_back(triangle);
        const Sphere& sphere = pyramid.sphere(block);
        const auto corners =
            quad_triangles(surface.atlas.quad_particles(triangle / 2))[triangle % 2];
        double farthest = 0;
        for (const int particle : corners) {
          for (const Vec3& p : {surface.positions[particle], end[particle]}) {
            farthest = std::max(farthest, (p - Vec3(sphere.x, sphere.y, sphere.z)).norm());
          }
        }
        EXPECT_LE(farthest, sphere.radius);
        EXPECT_LE(sphere.radius, farthest * (1 + 1e-6) + 1e-6);
      }
      std::ranges::sort(triangles);
      ASSERT_EQ(static_cast<int>(triangles.size()), 2 * surface.atlas.quad_count());
      for (std::size_t i = 0; i < triangles.size(); ++i)
        EXPECT_EQ(triangles[i], static_cast<int>(i));
    }
  }
}

TEST(PyramidRebuild, FlatIndicesAreThoseOfAQuadtree) {
  std::uint64_t next = 0;
  for (int level = 0; level < 5; ++level) {
    for (std::uint64_t i = 0; i < std::uint64_t{1} << (2 * level); ++i, ++next) {
      const QuadtreePlace place = quadtree_place(next);
      EXPECT_EQ(place.level, level);
      EXPECT_EQ(flat_index(place), next);
      for (std::uint32_t child = 0; child < 4; ++child) {
        const std::uint64_t number = flat_child(next, static_cast<int>(child) + 1);
        EXPECT_EQ(number, 4 * next + child + 1);
        EXPECT_EQ(flat_parent(number), next);
        const QuadtreePlace expected{level + 1, 2 * place.u + child % 2, 2 * place.v + child / 2};
        EXPECT_EQ(quadtree_place(number), expected);
      }
    }
  }
  const QuadtreePlace last{31, (1U << 31) - 1, (1U << 31) - 1};
  EXPECT_EQ(flat_index(last) + 1, flat_index({31, 0, 0}) + (std::uint64_t{1} << 62));
  EXPECT_EQ(quadtree_place(flat_index(last)), last);
}

TEST(PyramidRebuild, FlatIndicesFollowTheTree) {
  for (const Surface& surface : surfaces()) {
    Pyramid pyramid(surface.atlas);
    ASSERT_FALSE(pyramid.rebuild(surface.positions));
    for (const Block& block : all_blocks(pyramid)) {
      if (block.patch == Block::group) continue;
      const std::uint64_t index = pyramid.flat_index(block);
      EXPECT_EQ(pyramid.block_of_flat_index(block.patch, index), block);
      if (block.level == 0) {
        EXPECT_EQ(index, 0U);
      }
      if (pyramid.is_leaf(block)) continue;
      std::array<Block, 4> child;
      const int count = pyramid.children(block, child);
      for (int i = 0; i < count; ++i) EXPECT_EQ(flat_parent(pyramid.flat_index(child[i])), index);
    }
  }
}

TEST(PyramidRebuild, RebuildsManyBodiesAtOnce) {
  std::vector<Surface> list = small_and_large_surfaces();
  list[3].positions[5].x() = std::numeric_limits<double>::infinity();
  std::vector<Pyramid> pyramids;
  std::vector<PyramidRebuild> bodies;
  pyramids.reserve(list.size());
  for (const Surface& surface : list) pyramids.emplace_back(surface.atlas);
  std::vector<Positions> ends;
  ends.reserve(list.size());
  for (const Surface& surface : list) ends.push_back(crumple(surface, 0.1, 28).positions);
  for (std::size_t i = 0; i < list.size(); ++i) {
    bodies.push_back({&pyramids[i], list[i].positions, {}, {}});
    if (i % 2 == 0) bodies.back().end = ends[i];
  }
  rebuild(bodies, 2);
  for (std::size_t i = 0; i < list.size(); ++i) {
    EXPECT_EQ(bodies[i].unbounded.has_value(), i == 3);
    EXPECT_EQ(pyramids[i].is_built(), i != 3);
    if (i == 3) continue;
    Pyramid alone(list[i].atlas);
    ASSERT_FALSE(i % 2 == 0 ? alone.rebuild_swept(list[i].positions, ends[i])
                            : alone.rebuild(list[i].positions));
    EXPECT_TRUE(all_spheres(alone) == all_spheres(pyramids[i]));
  }
}

TEST(PyramidRebuild, HoldsFewBytes) {
  constexpr std::size_t four_megabytes = 4'000'000;
  for (const int n : {256, 257}) {
    const Surface surface = make_rectangle(1, 1, n, n);
    for (const RadiusPolicy policy : all_policies) {
      Pyramid pyramid(surface.atlas, policy);
      const std::size_t before = pyramid.bytes();
      ASSERT_FALSE(pyramid.rebuild(surface.positions));
      EXPECT_GT(pyramid.bytes(), before);  // what a rebuild needs counts
      EXPECT_LE(pyramid.bytes(), four_megabytes);
      if (policy != RadiusPolicy::fast) continue;
      ASSERT_FALSE(pyramid.rebuild_swept(surface.positions, surface.positions));
      EXPECT_LE(pyramid.bytes(), four_megabytes);
    }
  }
}

// Images of every kind that might be bounded wrongly.
class ImageMaker {
 public:
  explicit ImageMaker(unsigned seed) : random_(seed) {}

  Surface next() {
    Surface surface;
    surface.atlas = Atlas(patches());
    surface.positions.resize(surface.atlas.particle_count());
    fill(surface);
    return surface;
  }
  // Moves every vertex by about as much as neighbours are apart.
  Positions moved(const Surface& surface) {
    Positions end = surface.positions;
    for (std::size_t i = 0; i < end.size(); ++i) {
      end[i] += uniform(-2, 2) * (end[(i + 1) % end.size()] - end[i]);
    }
    return end;
  }

 private:
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }

  std::vector<Patch> patches() {
    std::vector<Patch> list(integer(0, 3) == 0 ? integer(2, 5) : 1);
    for (Patch& patch : list) {
      const int limit = integer(0, 9) == 0 ? 40 : 12;
      patch.wrap_u = integer(0, 3) == 0;
      patch.wrap_v = integer(0, 3) == 0;
      patch.rows = integer(patch.wrap_v ? 3 : 2, limit);
      patch.cols = integer(patch.wrap_u ? 3 : 2, limit);
    }
    return list;
  }

  Vec3 noise(double size) {
    return {uniform(-size, size), uniform(-size, size), uniform(-size, size)};
  }

  void fill(Surface& surface) {
    const std::array sizes{1.0, 1e-6, 1e6, 1e-12, 1e-19, 1e-23, 1e-40, 1e-310, 1e15};
    const std::array offsets{0.0, 0.0, 1.0, 1e6, -1e6, 1e-6, 1e12};
    const double size = sizes[integer(0, sizes.size() - 1)];
    const Vec3 offset = offsets[integer(0, offsets.size() - 1)] * noise(1);
    const int kind = integer(0, 5);
    const Vec3 u = noise(size), v = noise(size), common = noise(size);
    for (int texel = 0; texel < surface.atlas.texel_count(); ++texel) {
      const TexelAddress at = surface.atlas.texel_address(texel);
      Vec3& p = surface.positions[texel];
      p = offset;
      if (kind == 0) p += noise(size);                                   // no surface at all
      if (kind == 1) p += at.row * v + at.col * u;                       // a plane askew
      if (kind == 2) p += common;                                        // one point
      if (kind == 3) p += at.row * v + at.col * u + noise(1e-7 * size);  // nearly a plane
      if (kind == 4) p += integer(0, 3) == 0 ? noise(size) : common;     // coincident vertices
      if (kind == 5) p += at.row * v * 1e-3 + (at.col % 2) * u;          // pleats
      if (integer(0, 99) == 0) p += noise(100 * size);                   // a spike
    }
  }

  std::mt19937 random_;
};

// Every vertex of every block, in float64, whose own rounding is far below that of float32. In
// units of the radius, so that no square underflows.
int violations(const Pyramid& pyramid, const Positions& positions) {
  int count = 0;
  const Atlas& atlas = pyramid.atlas();
  const auto check = [&](const Sphere& sphere, const Vec3& p) {
    const Vec3 offset = (p - Vec3(sphere.x, sphere.y, sphere.z)) / sphere.radius;
    if (!(offset.squaredNorm() <= 1 + 1e-15)) ++count;
  };
  for (int patch = 0; patch < pyramid.patch_count(); ++patch) {
    for (int level = 0; level < pyramid.levels(patch); ++level) {
      for (int v = 0; v < pyramid.blocks_v(patch, level); ++v) {
        for (int u = 0; u < pyramid.blocks_u(patch, level); ++u) {
          const QuadRange range = pyramid.quads(patch, level, u, v);
          const Sphere& sphere = pyramid.sphere(patch, level, u, v);
          if (range.empty()) {
            count += sphere.radius < 0 ? 0 : 1;
            continue;
          }
          for (int row = range.row_begin; row <= range.row_end; ++row) {
            for (int col = range.col_begin; col <= range.col_end; ++col) {
              check(sphere, positions[atlas.particle(patch, row, col)]);
            }
          }
        }
      }
    }
  }
  for (int level = 0; level < pyramid.group_levels(); ++level) {
    for (int group = 0; group < 1 << level; ++group) {
      const int patches = pyramid.patch_count();
      for (int patch = block_boundary(group, patches, level);
           patch < block_boundary(group + 1, patches, level); ++patch) {
        const int first = atlas.first_texel(patch);
        for (int texel = 0; texel < atlas.patches()[patch].texel_count(); ++texel) {
          check(pyramid.group_spheres(level)[group], positions[first + texel]);
        }
      }
    }
  }
  return count;
}

TEST(PyramidRebuild, BoundsEveryVertexOfRandomAndAdversarialImages) {
  ImageMaker make(29);
  for (int image = 0; image < 1200; ++image) {
    const Surface surface = make.next();
    const Positions end = make.moved(surface);
    for (const RadiusPolicy policy : all_policies) {
      SCOPED_TRACE("image " + std::to_string(image));
      Pyramid pyramid(surface.atlas, policy);
      ASSERT_FALSE(pyramid.rebuild(surface.positions));
      ASSERT_EQ(violations(pyramid, surface.positions), 0);
      ASSERT_FALSE(pyramid.rebuild_swept(surface.positions, end));
      ASSERT_EQ(violations(pyramid, surface.positions), 0);
      ASSERT_EQ(violations(pyramid, end), 0);
    }
  }
}

}  // namespace
}  // namespace weft::bsi
