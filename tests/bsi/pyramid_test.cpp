#include "bsi/pyramid.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include "bsi/detail/instruction_set.h"
#include "bsi/shapes.h"
#include "tests/bsi/crumpled.h"
#include "tests/bsi/restored_settings.h"

namespace weft::bsi::pyramid_test {
namespace {

using Positions = std::vector<Vec3>;

// Returns an atlas of these patches with random positions.
Surface pieces(std::vector<Patch> patches, std::vector<int> texel_to_particle = {}) {
  Surface surface;
  surface.atlas = Atlas(std::move(patches), std::move(texel_to_particle));
  surface.positions = crumpled(Positions(surface.atlas.particle_count(), Vec3::Zero()), 1,
                               surface.atlas.quad_count());
  return surface;
}

// Returns surfaces of all kinds of sizes: the smallest, powers of two and not, long and thin,
// wrapped along either axis and both, several patches, sewn ones. The last four are large enough
// for several threads.
std::vector<Surface> surfaces() {
  std::vector<Surface> list;
  for (const auto& [rows, cols] : {std::pair{2, 2},
                                   {2, 3},
                                   {3, 2},
                                   {3, 3},
                                   {4, 4},
                                   {2, 30},
                                   {41, 3},
                                   {9, 9},
                                   {17, 33},
                                   {13, 23},
                                   {24, 8}}) {
    list.push_back(pieces({{rows, cols}}));
  }
  for (const auto& [rows, cols] : {std::pair{3, 3}, {4, 8}, {5, 3}, {7, 18}, {16, 32}}) {
    list.push_back(pieces({{rows, cols, true, false}}));
    list.push_back(pieces({{rows, cols, false, true}}));
    list.push_back(pieces({{rows, cols, true, true}}));
  }
  list.push_back(pieces({{2, 9}, {5, 5, true, false}, {3, 3}, {12, 2}, {4, 6, true, true}}));
  list.push_back(pieces({{2, 3}, {3, 3}}, {0, 1, 2, 3, 4, 5, 2, 1, 0, 6, 7, 8, 9, 10, 11}));
  for (const int n : {2, 5, 8}) {
    list.push_back(make_sphere(1, n));
    list.back().positions = crumpled(list.back().positions, 0.1, n);
  }
  list.push_back(pieces({{129, 65}}));
  list.push_back(pieces({{91, 100, true, true}}));
  list.push_back(pieces({{3, 6000}, {6000, 3, true, false}, {4, 4}}));
  list.push_back(make_sphere(1, 95));
  return list;
}

std::string describe(const Surface& surface) {
  std::string text;
  for (const Patch& patch : surface.atlas.patches()) {
    text += std::to_string(patch.rows) + " x " + std::to_string(patch.cols) +
            (patch.wrap_u ? " u" : "") + (patch.wrap_v ? " v" : "") + "; ";
  }
  return text;
}

// --- The oracle: straight from the definition ----------------------------------------------------

Box nothing() {
  Box box;
  box.low.fill(std::numeric_limits<float>::infinity());
  box.high.fill(-std::numeric_limits<float>::infinity());
  return box;
}

void enclose(Box& box, const std::array<float, 3>& point) {
  for (int axis = 0; axis < 3; ++axis) {
    box.low[axis] = std::min(box.low[axis], point[axis]);
    box.high[axis] = std::max(box.high[axis], point[axis]);
  }
}

std::array<float, 3> rounded(const Vec3& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

// The positions at the ends of the paths: one set, or two when swept.
using Ends = std::vector<const Positions*>;

Box box_of_quads(const Atlas& atlas, const Ends& ends, int patch, const QuadRange& quads) {
  Box box = nothing();
  for (const Positions* positions : ends) {
    for (int row = quads.row_begin; row <= quads.row_end; ++row) {
      for (int col = quads.col_begin; col <= quads.col_end; ++col) {
        enclose(box, rounded((*positions)[atlas.particle(patch, row, col)]));
      }
    }
  }
  return box;
}

// Low and high steps from vertex to vertex: along u, then along v.
std::array<Box, 2> steps_of_quads(const Atlas& atlas, const Ends& ends, int patch,
                                  const QuadRange& quads) {
  std::array<Box, 2> steps{nothing(), nothing()};
  const auto step = [&](const Positions& positions, Box& box, int from, int to) {
    const auto a = rounded(positions[from]), b = rounded(positions[to]);
    enclose(box, {b[0] - a[0], b[1] - a[1], b[2] - a[2]});
  };
  for (const Positions* positions : ends) {
    for (int quad_row = quads.row_begin; quad_row < quads.row_end; ++quad_row) {
      for (int quad_col = quads.col_begin; quad_col < quads.col_end; ++quad_col) {
        const auto corner = atlas.quad_particles(
            atlas.first_quad(patch) + quad_row * atlas.patches()[patch].quad_cols() + quad_col);
        step(*positions, steps[0], corner[0], corner[1]);
        step(*positions, steps[0], corner[2], corner[3]);
        step(*positions, steps[1], corner[0], corner[2]);
        step(*positions, steps[1], corner[1], corner[3]);
      }
    }
  }
  return steps;
}

std::array<Box, 2> held_steps(const Pyramid& pyramid, int patch, int level, int u, int v) {
  const BoxTree& tree = pyramid.tree();
  const BoxLevel& place = tree.levels[tree.patches[patch].first_level + level];
  const TangentBounds& bounds = place.tangents[v * pyramid.blocks_u(patch, level) + u];
  std::array<Box, 2> steps;
  for (int i = 0; i < 6; ++i) {
    steps[i / 3].low[i % 3] = -bounds.bound[i];
    steps[i / 3].high[i % 3] = bounds.bound[6 + i];
  }
  return steps;
}

using Visit = std::function<void(int patch, int level, int u, int v)>;

void for_each_block(const Pyramid& pyramid, const Visit& visit) {
  for (int patch = 0; patch < pyramid.patch_count(); ++patch) {
    for (int level = 0; level < pyramid.levels(patch); ++level) {
      for (int v = 0; v < pyramid.blocks_v(patch, level); ++v) {
        for (int u = 0; u < pyramid.blocks_u(patch, level); ++u) visit(patch, level, u, v);
      }
    }
  }
}

void expect_bounds(const Pyramid& pyramid, const Ends& ends) {
  const Atlas& atlas = pyramid.atlas();
  ASSERT_TRUE(pyramid.is_built());
  int wrong = 0;
  for_each_block(pyramid, [&](int patch, int level, int u, int v) {
    const QuadRange quads = pyramid.quads(patch, level, u, v);
    const bool leaf = level + 1 == pyramid.levels(patch);
    if (pyramid.box(patch, level, u, v) != box_of_quads(atlas, ends, patch, quads)) ++wrong;
    if (leaf) return;
    const auto held = held_steps(pyramid, patch, level, u, v);
    if (held != steps_of_quads(atlas, ends, patch, quads)) ++wrong;
  });
  EXPECT_EQ(wrong, 0);
  Box whole = nothing();
  for (const Positions* positions : ends) {
    for (const Vec3& position : *positions) enclose(whole, rounded(position));
  }
  EXPECT_EQ(pyramid.top(), whole);
  float magnitude = 0;
  for (const float bound : whole.low) magnitude = std::max(magnitude, std::abs(bound));
  for (const float bound : whole.high) magnitude = std::max(magnitude, std::abs(bound));
  EXPECT_EQ(pyramid.magnitude(), magnitude);
}

void expect_group_bounds(const Pyramid& pyramid) {
  for (int level = 0; level < pyramid.group_levels(); ++level) {
    std::vector<int> seen;
    for (int u = 0; u < 1 << level; ++u) {
      const auto patches = pyramid.patches_of_group(level, u);
      EXPECT_FALSE(patches.empty());
      seen.insert(seen.end(), patches.begin(), patches.end());
      Box whole = nothing();
      for (const int patch : patches) {
        enclose(whole, pyramid.box(patch, 0, 0, 0).low);
        enclose(whole, pyramid.box(patch, 0, 0, 0).high);
      }
      EXPECT_EQ(pyramid.group_box(level, u), whole);
    }
    std::sort(seen.begin(), seen.end());
    for (int patch = 0; patch < pyramid.patch_count(); ++patch) EXPECT_EQ(seen[patch], patch);
    EXPECT_EQ(static_cast<int>(seen.size()), pyramid.patch_count());
  }
  EXPECT_EQ(pyramid.group_levels() == 0, pyramid.patch_count() == 1);
}

// Patches in a row whose numbers jump about: each group is a part of the row.
TEST(Pyramid, GroupsPatchesByPlace) {
  constexpr int patches = 13;
  std::vector<Vec3> texels;
  for (int patch = 0; patch < patches; ++patch) {
    const double place = 5 * patch % patches;
    for (int texel = 0; texel < 4; ++texel)
      texels.emplace_back(0.2 * (texel % 2), 0.1 * place, 0.2 * (texel / 2));
  }
  const Surface row = make_from_texels(patches, 2, 2, texels, false, false);
  Pyramid pyramid(row.atlas);
  ASSERT_EQ(pyramid.rebuild(row.positions), std::nullopt);
  expect_group_bounds(pyramid);
  ASSERT_EQ(pyramid.group_levels(), 4);
  for (int level = 0; level < 4; ++level) {
    for (int u = 0; u < 1 << level; ++u) {
      const auto count = static_cast<float>(pyramid.patches_of_group(level, u).size());
      const Box& box = pyramid.group_box(level, u);
      EXPECT_NEAR(box.high[1] - box.low[1], 0.1F * (count - 1), 1e-5F) << level << ' ' << u;
    }
  }
}

// --- The blocks ----------------------------------------------------------------------------------

TEST(Pyramid, LevelsSplitTheQuadsDownToLeafBlocks) {
  for (const Surface& surface : surfaces()) {
    SCOPED_TRACE(describe(surface));
    const Pyramid pyramid(surface.atlas);
    for (int patch = 0; patch < pyramid.patch_count(); ++patch) {
      const Patch& image = surface.atlas.patches()[patch];
      for (int level = 0; level < pyramid.levels(patch); ++level) {
        std::vector<int> held(image.quad_count(), 0);
        const bool leaf = level + 1 == pyramid.levels(patch);
        for (int v = 0; v < pyramid.blocks_v(patch, level); ++v) {
          for (int u = 0; u < pyramid.blocks_u(patch, level); ++u) {
            const QuadRange quads = pyramid.quads(patch, level, u, v);
            EXPECT_FALSE(quads.empty());
            if (leaf) {
              EXPECT_LE(quads.row_end - quads.row_begin, 2);
              EXPECT_LE(quads.col_end - quads.col_begin, 2);
            }
            for (int row = quads.row_begin; row < quads.row_end; ++row) {
              for (int col = quads.col_begin; col < quads.col_end; ++col) {
                ++held[row * image.quad_cols() + col];
              }
            }
          }
        }
        EXPECT_EQ(std::ranges::count(held, 1), image.quad_count());
      }
    }
  }
}

TEST(Pyramid, BoundsTheFloat32VerticesAndStepsOfEveryBlock) {
  for (const Surface& surface : surfaces()) {
    SCOPED_TRACE(describe(surface));
    Pyramid pyramid(surface.atlas);
    ASSERT_FALSE(pyramid.rebuild(surface.positions));
    expect_bounds(pyramid, {&surface.positions});
    expect_group_bounds(pyramid);
  }
}

TEST(Pyramid, SweptBoundsBothEnds) {
  unsigned seed = 1;
  for (const Surface& surface : surfaces()) {
    SCOPED_TRACE(describe(surface));
    const Positions end = crumpled(surface.positions, 0.3, seed++);
    Pyramid pyramid(surface.atlas);
    ASSERT_FALSE(pyramid.rebuild_swept(surface.positions, end));
    expect_bounds(pyramid, {&surface.positions, &end});
    expect_group_bounds(pyramid);
    // After a plain rebuild and another swept one, nothing of the other remains.
    ASSERT_FALSE(pyramid.rebuild(end));
    expect_bounds(pyramid, {&end});
    ASSERT_FALSE(pyramid.rebuild_swept(end, surface.positions));
    expect_bounds(pyramid, {&surface.positions, &end});
  }
}

TEST(Pyramid, BlocksLieInsideTheirParents) {
  const auto inside = [](const Box& inner, const Box& outer) {
    for (int axis = 0; axis < 3; ++axis) {
      if (inner.low[axis] < outer.low[axis] || inner.high[axis] > outer.high[axis]) return false;
    }
    return true;
  };
  for (const Surface& surface : surfaces()) {
    Pyramid pyramid(surface.atlas);
    ASSERT_FALSE(pyramid.rebuild(surface.positions));
    int outside = 0;
    for_each_block(pyramid, [&](int patch, int level, int u, int v) {
      if (level == 0) return;
      const bool split_u = pyramid.blocks_u(patch, level) > pyramid.blocks_u(patch, level - 1);
      const bool split_v = pyramid.blocks_v(patch, level) > pyramid.blocks_v(patch, level - 1);
      const int parent_u = split_u ? u / 2 : u;
      const int parent_v = split_v ? v / 2 : v;
      if (!inside(pyramid.box(patch, level, u, v),
                  pyramid.box(patch, level - 1, parent_u, parent_v))) {
        ++outside;
      }
      const QuadRange child = pyramid.quads(patch, level, u, v);
      const QuadRange parent = pyramid.quads(patch, level - 1, parent_u, parent_v);
      if (child.row_begin < parent.row_begin || child.row_end > parent.row_end ||
          child.col_begin < parent.col_begin || child.col_end > parent.col_end) {
        ++outside;
      }
    });
    EXPECT_EQ(outside, 0) << describe(surface);
  }
}

TEST(Pyramid, BoundsEverySizeThatFloat32Holds) {
  for (const double size : {9e17, 1e17, 1e6, 1e-6, 1e-20, 1e-38, 1e-44, 1e-310}) {
    Surface surface = pieces({{18, 11, true, false}, {3, 5}});
    for (Vec3& position : surface.positions) {
      position = size * position.cwiseMax(Vec3(-1, -1, -1)).cwiseMin(Vec3(1, 1, 1));
    }
    surface.positions[3] = surface.positions[4];
    Pyramid pyramid(surface.atlas);
    ASSERT_FALSE(pyramid.rebuild(surface.positions));
    expect_bounds(pyramid, {&surface.positions});
  }
}

TEST(Pyramid, RefusesAnAxisOfTooManyQuads) {
  EXPECT_NO_THROW(Pyramid(Atlas({{2, Pyramid::quad_limit + 1}})));
  try {
    const Pyramid pyramid(Atlas({{3, 3}, {Pyramid::quad_limit + 2, 2}}));
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("patch 1"), std::string::npos) << error.what();
  }
}

TEST(Pyramid, RefusesPoints) {
  try {
    const Pyramid pyramid(Atlas::of_points(3));
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "patch 0 has no quads");
  }
}

TEST(Pyramid, RefusesAnAtlasWithoutPatches) {
  EXPECT_THROW(Pyramid{Atlas()}, std::invalid_argument);
}

TEST(Pyramid, IsSmall) {
  constexpr std::size_t limit = 4'000'000;
  Pyramid pyramid(Atlas({{256, 256}}));
  EXPECT_LE(pyramid.bytes(), limit);
  // The least it must hold: a float32 position per vertex and a box per leaf block.
  EXPECT_GE(pyramid.bytes(), 256 * 256 * 12 + 128 * 128 * sizeof(Box));
  const Positions positions(256 * 256, Vec3::Zero());
  const std::size_t plain = pyramid.bytes();
  ASSERT_FALSE(pyramid.rebuild_swept(positions, positions));
  EXPECT_GE(pyramid.bytes(), plain + 256 * 256 * 12);
}

// --- Positions that are not finite ---------------------------------------------------------------

void expect_place(const std::optional<TexelAddress>& found, const TexelAddress& expected) {
  ASSERT_TRUE(found);
  EXPECT_EQ(std::tuple(found->patch, found->row, found->col),
            std::tuple(expected.patch, expected.row, expected.col));
}

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::array bad_values{std::numeric_limits<double>::quiet_NaN(),
                                infinity,
                                -infinity,
                                1e300,
                                1e18,
                                -1e18,
                                0.99999999e18};  // which rounds to 1e18 in float32

// Sets one coordinate of one particle to a bad number, at either end or both, and rebuilds.
void expect_bad_particle_found(Pyramid& pyramid, const Positions& good, Positions& spoiled,
                               int particle, int variant) {
  const TexelAddress expected = pyramid.atlas().particle_address(particle);
  double& coordinate = spoiled[particle][variant % 3];
  coordinate = bad_values[variant % bad_values.size()];
  const auto found = variant % 4 < 2    ? pyramid.rebuild_swept(good, spoiled)
                     : variant % 4 == 2 ? pyramid.rebuild(spoiled)
                                        : pyramid.rebuild_swept(spoiled, good);
  expect_place(found, expected);
  EXPECT_FALSE(pyramid.is_built());
  coordinate = good[particle][variant % 3];
}

TEST(Pyramid, FindsTheFirstTexelThatIsNotFinite) {
  for (const Surface& surface : surfaces()) {
    SCOPED_TRACE(describe(surface));
    const int count = surface.atlas.particle_count();
    Pyramid pyramid(surface.atlas);
    Positions spoiled = surface.positions;
    const int stride = std::max(1, count / 60);
    for (int particle = 0; particle < count; particle += stride) {
      expect_bad_particle_found(pyramid, surface.positions, spoiled, particle,
                                particle / stride + particle);
    }
    EXPECT_FALSE(pyramid.rebuild(spoiled));
    expect_bounds(pyramid, {&surface.positions});
  }
}

// Tests every row of an image that several threads share, including the rows where they meet.
TEST(Pyramid, FindsATexelInEveryRowOfAnImageOfManyThreads) {
  for (const bool wrap : {false, true}) {
    const Surface surface = pieces({{131, 70, wrap, wrap}});
    Pyramid pyramid(surface.atlas);
    Positions spoiled = surface.positions;
    for (int row = 0; row < 131; ++row) {
      const int particle = row * 70 + row * 37 % 70;
      expect_bad_particle_found(pyramid, surface.positions, spoiled, particle, row);
    }
  }
}

TEST(Pyramid, OfSeveralBadTexelsTheFirstIsNamed) {
  const Surface surface = pieces({{100, 90}, {90, 100}});
  std::mt19937 random(3);
  Pyramid pyramid(surface.atlas);
  for (int sample = 0; sample < 20; ++sample) {
    Positions start = surface.positions, end = surface.positions;
    int first = surface.atlas.particle_count();
    for (int i = 0; i < 4; ++i) {
      const int particle = static_cast<int>(random() % start.size());
      (i % 2 == 0 ? start : end)[particle].y() = bad_values[random() % bad_values.size()];
      first = std::min(first, particle);
    }
    expect_place(pyramid.rebuild_swept(start, end), surface.atlas.texel_address(first));
  }
}

TEST(Pyramid, TakesCoordinatesUpToTheLimit) {
  Surface surface = pieces({{5, 5}});
  surface.positions[7] = Vec3(9.9999e17, -9.9999e17, 0);
  Pyramid pyramid(surface.atlas);
  EXPECT_FALSE(pyramid.rebuild(surface.positions));
  expect_bounds(pyramid, {&surface.positions});
}

// --- The same bits -------------------------------------------------------------------------------

// Everything that a pyramid holds.
std::vector<float> contents(const Pyramid& pyramid) {
  std::vector<float> all;
  const auto add = [&](const Box& box) {
    all.insert(all.end(), box.low.begin(), box.low.end());
    all.insert(all.end(), box.high.begin(), box.high.end());
  };
  for_each_block(pyramid, [&](int patch, int level, int u, int v) {
    add(pyramid.box(patch, level, u, v));
    if (level + 1 == pyramid.levels(patch)) return;
    for (const Box& steps : held_steps(pyramid, patch, level, u, v)) add(steps);
  });
  for (int patch = 0; patch < pyramid.patch_count(); ++patch) {
    const BoxPatch& image = pyramid.tree().patches[patch];
    for (int end = 0; end <= pyramid.tree().swept; ++end) {
      for (const float* component : image.vertices[end].component) {
        for (int row = 0; row <= image.quad_rows; ++row) {
          const float* first = component + row * image.vertices[end].stride;
          all.insert(all.end(), first, first + image.quad_cols + 1);
        }
      }
    }
  }
  add(pyramid.top());
  return all;
}

// Distinguishes -0 from 0 too.
bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::ranges::equal(a, b, [](float x, float y) {
           return std::bit_cast<std::uint32_t>(x) == std::bit_cast<std::uint32_t>(y);
         });
}

TEST(Pyramid, HoldsTheSameBitsForAnyThreadsAndInstructionSet) {
  const RestoredSettings restored;
  for (const Surface& surface : surfaces()) {
    SCOPED_TRACE(describe(surface));
    Positions start = surface.positions;
    const Positions end = crumpled(start, 0.2, 99);
    // Zeros have both signs, whose order a maximum may ignore.
    for (std::size_t i = 0; i < start.size(); i += 3) start[i].z() = i % 2 == 0 ? 0.0 : -0.0;
    std::vector<float> plain, swept;
    for (const InstructionSet set : available_instruction_sets()) {
      use_instruction_set(set);
      for (const int threads : {1, 2, 3}) {
        omp_set_num_threads(threads);
        Pyramid pyramid(surface.atlas);
        ASSERT_FALSE(pyramid.rebuild(start));
        if (plain.empty()) plain = contents(pyramid);
        EXPECT_TRUE(same_bits(contents(pyramid), plain)) << name(set) << ", " << threads;
        ASSERT_FALSE(pyramid.rebuild_swept(start, end));
        if (swept.empty()) swept = contents(pyramid);
        EXPECT_TRUE(same_bits(contents(pyramid), swept)) << name(set) << ", " << threads;
      }
    }
  }
}

}  // namespace
}  // namespace weft::bsi::pyramid_test
