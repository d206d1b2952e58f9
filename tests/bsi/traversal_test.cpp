#include "bsi/traversal.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <utility>

#include "bsi/detail/instruction_set.h"
#include "bsi/proximity.h"
#include "bsi/shapes.h"
#include "tests/bsi/crumpled.h"
#include "tests/bsi/restored_settings.h"

namespace weft::bsi::traversal_test {
namespace {

using Positions = std::vector<Vec3>;

// A surface at rest, or moving to `end`.
struct Body {
  std::string name;
  Surface surface;
  Positions end;  // empty: at rest
  Pyramid pyramid;
};

Body make_body(const std::string& name, Surface surface, double noise, const Vec3& offset,
               bool swept) {
  const auto seed = static_cast<unsigned>(surface.atlas.texel_count());
  if (noise > 0) surface.positions = crumpled(surface.positions, noise, seed);
  for (Vec3& position : surface.positions) position += offset;
  Body body{name + (swept ? " swept" : ""), std::move(surface), {}, Pyramid(Atlas({{2, 2}}))};
  body.pyramid = Pyramid(body.surface.atlas, {.spheres = true});
  if (swept) {
    body.end = crumpled(body.surface.positions, 0.03, seed + 1);
    for (Vec3& position : body.end) position.z() += 0.1;
    EXPECT_FALSE(body.pyramid.rebuild_swept(body.surface.positions, body.end));
  } else {
    EXPECT_FALSE(body.pyramid.rebuild(body.surface.positions));
  }
  return body;
}

// A patch folded onto itself; two of its borders and its corners are sewn together.
Surface make_sewn_patch() {
  std::vector<int> particle;
  for (int row = 0; row < 6; ++row) {
    for (int col = 0; col < 7; ++col) particle.push_back(col == 6 ? 6 * row : 6 * row + col);
  }
  Surface surface;
  surface.atlas = Atlas({{6, 7}}, particle);
  surface.positions.resize(surface.atlas.particle_count(), Vec3::Zero());
  return surface;
}

// Bodies of every kind around one place: smooth and crumpled, of odd sizes, of one quad, wrapped,
// of several patches, sewn.
void add_bodies(std::vector<Body>& list, bool swept) {
  const auto add = [&](const char* name, Surface surface, double noise, const Vec3& offset) {
    list.push_back(make_body(name, std::move(surface), noise, offset, swept));
  };
  add("sheet", make_rectangle(1, 1, 12, 15), 0.05, {0, 0, 0.1});
  add("flat sheet", make_rectangle(1, 1, 17, 17), 0, {0.05, 0, 0.1});
  add("strip", make_rectangle(2, 0.2, 3, 34), 0.01, {0, 0, 0.12});
  add("quad", make_rectangle(0.7, 0.7, 2, 2), 0, {0, 0.1, 0.15});
  add("torus", make_torus(0.5, 0.2, 17, 9), 0, {0.1, 0, 0});
  add("crumpled torus", make_torus(0.5, 0.2, 6, 16), 0.03, {0.1, 0, 0});
  add("least torus", make_torus(0.5, 0.2, 3, 3), 0.01, {0, 0, 0});
  add("sphere", make_sphere(0.4, 6), 0.01, {0, 0, 0});
  add("sewn patch", make_sewn_patch(), 0.3, {0, 0, 0});
  Surface pieces;
  pieces.atlas = Atlas({{2, 9}, {5, 5, true, false}, {3, 3}, {12, 2}, {4, 6, true, true}});
  pieces.positions.resize(pieces.atlas.particle_count(), Vec3::Zero());
  add("pieces", std::move(pieces), 0.3, {0, 0, 0});
}

const std::vector<Body>& bodies() {
  static const std::vector<Body> all = [] {
    std::vector<Body> list;
    add_bodies(list, false);
    add_bodies(list, true);
    return list;
  }();
  return all;
}

// --- The oracle: every pair of leaves, straight from the rule of traversal.h ---------------------

std::array<int, 3> corners_of_triangle(const Atlas& atlas, int triangle) {
  return quad_triangles(atlas.quad_particles(triangle / 2))[triangle % 2];
}

std::vector<int> particles_of_leaf(const Atlas& atlas, Leaf kind, int leaf) {
  if (kind == Leaf::quad) {
    const auto corners = atlas.quad_particles(leaf);
    return {corners.begin(), corners.end()};
  }
  const auto corners = corners_of_triangle(atlas, leaf);
  return {corners.begin(), corners.end()};
}

int leaf_count(const Atlas& atlas, Leaf kind) {
  return kind == Leaf::quad ? atlas.quad_count() : 2 * atlas.quad_count();
}

Box box_around(const Body& body, const std::vector<int>& particles) {
  Box box;
  box.low.fill(std::numeric_limits<float>::infinity());
  box.high.fill(-std::numeric_limits<float>::infinity());
  for (const Positions* positions : {&body.surface.positions, &body.end}) {
    if (positions->empty()) continue;
    for (const int particle : particles) {
      for (int axis = 0; axis < 3; ++axis) {
        const auto coordinate = static_cast<float>((*positions)[particle][axis]);
        box.low[axis] = std::min(box.low[axis], coordinate);
        box.high[axis] = std::max(box.high[axis], coordinate);
      }
    }
  }
  return box;
}

Box widened(Box box, float half) {
  for (float& bound : box.low) bound -= half;
  for (float& bound : box.high) bound += half;
  return box;
}

bool overlap(const Box& a, const Box& b) {
  for (int axis = 0; axis < 3; ++axis) {
    if (a.low[axis] > b.high[axis] || b.low[axis] > a.high[axis]) return false;
  }
  return true;
}

std::vector<Box> widened_leaves(const Body& body, Leaf kind, float half) {
  std::vector<Box> boxes;
  boxes.reserve(leaf_count(body.surface.atlas, kind));
  for (int leaf = 0; leaf < leaf_count(body.surface.atlas, kind); ++leaf) {
    boxes.push_back(
        widened(box_around(body, particles_of_leaf(body.surface.atlas, kind, leaf)), half));
  }
  return boxes;
}

bool share_a_particle(const Atlas& atlas, int a, int b) {
  const auto of_a = corners_of_triangle(atlas, a), of_b = corners_of_triangle(atlas, b);
  return std::ranges::find_first_of(of_a, of_b) != of_a.end();
}

std::vector<LeafPair> all_dual_pairs(const Body& first, const Body& second,
                                     const TraversalOptions& options) {
  const float half =
      half_margin(options.margin, first.pyramid.magnitude(), second.pyramid.magnitude());
  const auto of_first = widened_leaves(first, options.leaf, half);
  const auto of_second = widened_leaves(second, options.leaf, half);
  std::vector<LeafPair> pairs;
  for (std::size_t a = 0; a < of_first.size(); ++a) {
    for (std::size_t b = 0; b < of_second.size(); ++b) {
      if (overlap(of_first[a], of_second[b]))
        pairs.push_back({static_cast<int>(a), static_cast<int>(b)});
    }
  }
  return pairs;
}

std::vector<LeafPair> all_self_pairs(const Body& body, const TraversalOptions& options) {
  std::vector<LeafPair> pairs = all_dual_pairs(body, body, options);
  std::erase_if(pairs, [&](const LeafPair& pair) {
    if (options.leaf == Leaf::quad) return pair.a > pair.b;
    return pair.a >= pair.b || share_a_particle(body.surface.atlas, pair.a, pair.b);
  });
  return pairs;
}

// Returns the pairs in order, each once.
std::vector<LeafPair> sorted(std::vector<LeafPair> pairs) {
  std::ranges::sort(pairs);
  EXPECT_EQ(std::ranges::adjacent_find(pairs), pairs.end()) << "a pair was found twice";
  return pairs;
}

constexpr std::array leaf_kinds{Leaf::quad, Leaf::triangle};
constexpr std::array bounds{Bound::sphere, Bound::box, Bound::sphere_then_box};

std::string describe(const TraversalOptions& options) {
  constexpr std::array names{"spheres", "boxes", "spheres, then boxes"};
  return std::string(options.leaf == Leaf::quad ? "quads" : "triangles") + ", margin " +
         std::to_string(options.margin) + ", by " + names[static_cast<int>(options.bound)];
}

// --- Sets ----------------------------------------------------------------------------------------

TEST(Traversal, DualFindsEveryPairOfLeaves) {
  constexpr std::array margins{0.0, 1e-3, 0.02, 0.02, 0.0, 0.2, 1e300};
  std::size_t turn = 0, found = 0;
  for (std::size_t i = 0; i < bodies().size(); ++i) {
    // Takes every third pair of bodies, which covers each kind with each other, at rest and moving.
    for (std::size_t j = i % 3; j < bodies().size(); j += 3) {
      const Body &first = bodies()[i], &second = bodies()[j];
      for (const Leaf leaf : leaf_kinds) {
        TraversalOptions options{.margin = margins[turn++ % margins.size()], .leaf = leaf};
        const std::vector<LeafPair> expected = all_dual_pairs(first, second, options);
        for (const Bound bound : bounds) {
          options.bound = bound;
          SCOPED_TRACE(first.name + " and " + second.name + ", " + describe(options));
          std::vector<LeafPair> pairs;
          TraversalCounters counters;
          dual_traversal(first.pyramid, second.pyramid, options, pairs, counters);
          ASSERT_TRUE(sorted(pairs) == expected);
          EXPECT_GE(counters.bound_tests, pairs.empty() ? 0 : 1);
          EXPECT_EQ(counters.certificate_tests, 0);
          found += pairs.size();
        }
      }
    }
  }
  EXPECT_GT(found, 3000000U);
}

TEST(Traversal, SelfFindsEveryPairOfLeaves) {
  for (const Body& body : bodies()) {
    for (const Leaf leaf : leaf_kinds) {
      for (const double margin : {0.0, 1e-3, 0.02, 0.2, 1e300}) {
        if (margin > 1 && body.surface.atlas.quad_count() > 100) continue;
        TraversalOptions options{.margin = margin, .leaf = leaf};
        const std::vector<LeafPair> expected = all_self_pairs(body, options);
        std::vector<LeafPair> excused_by_first;
        for (const Bound bound : bounds) {
          options.bound = bound;
          options.certificate = false;
          SCOPED_TRACE(body.name + ", " + describe(options));
          std::vector<LeafPair> all, excused;
          TraversalCounters counters;
          self_traversal(body.pyramid, options, all, counters);
          ASSERT_TRUE(sorted(all) == expected);
          EXPECT_EQ(counters.certificate_tests, 0);
          // The certificate only removes pairs (tangent_certificate_test.cpp checks which).
          options.certificate = true;
          self_traversal(body.pyramid, options, excused, counters);
          EXPECT_TRUE(std::ranges::includes(sorted(all), sorted(excused)));
          if (counters.certified == 0) {
            EXPECT_EQ(excused.size(), all.size());
          }
          if (bound == bounds.front()) excused_by_first = sorted(excused);
          EXPECT_TRUE(sorted(excused) == excused_by_first);
        }
      }
    }
  }
}

std::vector<int> leaves_near(const Body& body, Leaf leaf, const Vec3& point, double reach) {
  const auto x = static_cast<float>(point.x()), y = static_cast<float>(point.y()),
             z = static_cast<float>(point.z());
  // The magnitude must be at least the largest coordinate in float32.
  auto magnitude = static_cast<float>(point.cwiseAbs().maxCoeff());
  if (static_cast<double>(magnitude) < point.cwiseAbs().maxCoeff())
    magnitude = std::nextafter(magnitude, std::numeric_limits<float>::infinity());
  const float half = half_margin(reach, body.pyramid.magnitude(), magnitude);
  const auto leaves = widened_leaves(body, leaf, half);
  const Box ball = widened({{x, y, z}, {x, y, z}}, half);
  std::vector<int> near;
  for (std::size_t l = 0; l < leaves.size(); ++l) {
    if (overlap(ball, leaves[l])) near.push_back(static_cast<int>(l));
  }
  return near;
}

TEST(Traversal, SingleFindsEveryLeafNearABall) {
  std::mt19937 random(21);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const Body& body : bodies()) {
    Positions points;
    for (int i = 0; i < 24; ++i) {
      points.emplace_back(uniform(random), uniform(random), 0.3 * uniform(random));
    }
    points.push_back(body.surface.positions[body.surface.positions.size() / 2]);
    points.emplace_back(1e17, -3e3, 0);
    for (const Leaf leaf : leaf_kinds) {
      for (const auto& [radius, margin] :
           {std::pair{0.0, 0.0}, {0.1, 0.0}, {0.0, 0.05}, {0.2, 0.03}, {3e17, 1e17}}) {
        std::vector<LeafPair> expected;
        for (std::size_t i = 0; i < points.size(); ++i) {
          for (const int l : leaves_near(body, leaf, points[i], margin + radius))
            expected.push_back({static_cast<int>(i), l});
        }
        for (const Bound bound : bounds) {
          const TraversalOptions options{.margin = margin, .leaf = leaf, .bound = bound};
          SCOPED_TRACE(body.name + ", " + describe(options));
          std::vector<LeafPair> together, one_by_one;
          for (std::size_t i = 0; i < points.size(); ++i) {
            std::vector<int> found;
            TraversalCounters counters;
            single_traversal(body.pyramid, points[i], radius, options, found, counters);
            for (const int l : found) one_by_one.push_back({static_cast<int>(i), l});
          }
          TraversalCounters counters;
          single_traversal(body.pyramid, points, radius, options, together, counters);
          ASSERT_EQ(sorted(one_by_one), expected);
          ASSERT_EQ(sorted(together), expected);
        }
      }
    }
  }
}

TEST(Traversal, SingleFindsEveryLeafNearEachOfManyPoints) {
  std::mt19937 random(22);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const Body body = make_body("torus", make_torus(0.5, 0.2, 7, 6), 0.01, Vec3::Zero(), false);
  Positions points;
  std::vector<LeafPair> expected, found;
  // There are more points than a batch holds, and their number is no multiple of a vector's.
  for (int i = 0; i < 70001; ++i) {
    points.emplace_back(uniform(random), uniform(random), 0.3 * uniform(random));
    for (const int leaf : leaves_near(body, Leaf::quad, points.back(), 0.01))
      expected.push_back({i, leaf});
  }
  TraversalCounters counters;
  single_traversal(body.pyramid, points, 0.01, {.leaf = Leaf::quad}, found, counters);
  EXPECT_TRUE(sorted(found) == expected);
}

TEST(Traversal, HalfMarginIsTheMarginAndTheRoundingOfVertices) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> exponent(-45, 18);
  for (int i = 0; i < 20000; ++i) {
    const double margin = i % 5 == 0 ? 0.0 : std::pow(10.0, exponent(random));
    const auto a = static_cast<float>(std::pow(10.0, std::min(17.9, exponent(random))));
    const auto b = i % 3 == 0 ? 0.0F : static_cast<float>(std::pow(10.0, 0.4 * exponent(random)));
    const auto half = static_cast<double>(half_margin(margin, a, b));
    // Rounding to float32 moves a number by 2^-24 of it, or by 2^-150 among the smallest.
    const double least =
        margin + 0x1p-24 * (static_cast<double>(a) + static_cast<double>(b)) + 0x1p-149;
    EXPECT_GE(2 * half, least);
    EXPECT_LE(2 * half, 2 * least * (1 + 0x1p-22) + 0x1p-123);
  }
}

// --- Order ---------------------------------------------------------------------------------------

// The leaves that a body finds with itself, with another and with points, in order.
struct Findings {
  std::vector<LeafPair> self, dual, single;
  std::vector<BlockPair> blocks;
  TraversalCounters counters;
  bool operator==(const Findings& other) const {
    return self == other.self && dual == other.dual && single == other.single &&
           blocks == other.blocks && counters.bound_tests == other.counters.bound_tests &&
           counters.certificate_tests == other.counters.certificate_tests &&
           counters.certified == other.counters.certified;
  }
};

Findings find_all(const Body& first, const Body& second, const TraversalOptions& options) {
  Findings found;
  self_traversal(first.pyramid, options, found.self, found.counters);
  dual_traversal(first.pyramid, second.pyramid, options, found.dual, found.counters);
  single_traversal(first.pyramid, second.surface.positions, 0.01, options, found.single,
                   found.counters);
  self_traversal_of_blocks(first.pyramid, 3, options, found.blocks, found.counters);
  dual_traversal_of_blocks(first.pyramid, second.pyramid, 2, options, found.blocks, found.counters);
  return found;
}

TEST(Traversal, OrderAndCountersDependOnThePyramidsAlone) {
  const RestoredSettings restored;
  std::vector<Body> list;
  for (const bool swept : {false, true}) {
    list.push_back(make_body("large sheet", make_rectangle(1, 1, 40, 37), 0.002, {0, 0, 0}, swept));
    list.push_back(make_body("sphere", make_sphere(0.4, 9), 0.004, {0.1, 0, 0}, swept));
    list.push_back(make_body("torus", make_torus(0.4, 0.2, 30, 17), 0, {0, 0.1, 0}, swept));
  }
  std::int64_t certified = 0;
  std::size_t self_pairs = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    for (const Leaf leaf : leaf_kinds) {
      const TraversalOptions options{.margin = 0.003, .leaf = leaf};
      const Body& other = list[(i + 1) % list.size()];
      omp_set_num_threads(1);
      const Findings expected = find_all(list[i], other, options);
      certified += expected.counters.certified;
      self_pairs += expected.self.size();
      EXPECT_FALSE(expected.dual.empty() || expected.single.empty());
      for (const InstructionSet set : available_instruction_sets()) {
        use_instruction_set(set);
        for (const int threads : {1, 2, 3}) {
          omp_set_num_threads(threads);
          EXPECT_TRUE(find_all(list[i], other, options) == expected)
              << list[i].name << ", " << name(set) << ", " << threads << " threads";
        }
      }
    }
  }
  EXPECT_GT(self_pairs, 0U);
  EXPECT_GT(certified, 100);
}

TEST(Traversal, PairsOfLeafBlocksAreTheSamePairsInTheSameOrder) {
  const RestoredSettings restored;
  for (const Body& body : bodies()) {
    const Body& other = bodies()[3];
    for (const Leaf leaf : leaf_kinds) {
      const TraversalOptions options{.margin = 0.1, .leaf = leaf, .threads = 2};
      std::vector<LeafPair> pairs{{-1, -1}}, listed{{-1, -1}};
      std::vector<LeafBlockPair> self, dual;
      TraversalCounters counters, counters_of_blocks;
      self_traversal(body.pyramid, options, pairs, counters);
      dual_traversal(body.pyramid, other.pyramid, options, pairs, counters);
      self_traversal(body.pyramid, options, self, counters_of_blocks);
      dual_traversal(body.pyramid, other.pyramid, options, dual, counters_of_blocks);
      EXPECT_EQ(count_pairs(self) + count_pairs(dual), pairs.size() - 1);
      for (const InstructionSet set : available_instruction_sets()) {
        use_instruction_set(set);
        listed.resize(1);
        append_pairs(body.pyramid, leaf, self, 2, listed);
        append_pairs(body.pyramid, other.pyramid, leaf, dual, 1, listed);
        EXPECT_EQ(pairs, listed) << body.name << ", " << name(set);
      }
      EXPECT_EQ(counters.bound_tests, counters_of_blocks.bound_tests);
      EXPECT_EQ(counters.certified, counters_of_blocks.certified);
    }
  }
}

// --- Blocks of a level ---------------------------------------------------------------------------

std::vector<PatchBlock> blocks_of_level(const Pyramid& pyramid, int level) {
  std::vector<PatchBlock> blocks;
  for (int patch = 0; patch < pyramid.patch_count(); ++patch) {
    const int there = std::min(level, pyramid.levels(patch) - 1);
    for (int v = 0; v < pyramid.blocks_v(patch, there); ++v) {
      for (int u = 0; u < pyramid.blocks_u(patch, there); ++u) {
        blocks.push_back({patch, there, u, v});
      }
    }
  }
  return blocks;
}

using BlockKey = std::array<int, 8>;

BlockKey key_of(const PatchBlock& a, const PatchBlock& b) {
  return {a.patch, a.level, a.v, a.u, b.patch, b.level, b.v, b.u};
}

std::set<BlockKey> all_block_pairs(const Pyramid& first, const Pyramid& second, int level,
                                   double margin, bool self) {
  const float half = half_margin(margin, first.magnitude(), second.magnitude());
  std::set<BlockKey> pairs;
  for (const PatchBlock& a : blocks_of_level(first, level)) {
    const Box box_a = widened(first.box(a.patch, a.level, a.u, a.v), half);
    for (const PatchBlock& b : blocks_of_level(second, level)) {
      const BlockKey key = key_of(a, b);
      if (self && key_of(b, a) < key) continue;
      if (overlap(box_a, widened(second.box(b.patch, b.level, b.u, b.v), half))) pairs.insert(key);
    }
  }
  return pairs;
}

std::set<BlockKey> keys_of(const std::vector<BlockPair>& pairs, bool self) {
  std::set<BlockKey> keys;
  for (const BlockPair& pair : pairs) {
    const BlockKey key = key_of(pair.a, pair.b), mirrored = key_of(pair.b, pair.a);
    EXPECT_TRUE(keys.insert(self ? std::min(key, mirrored) : key).second) << "found twice";
  }
  return keys;
}

TEST(Traversal, BlocksOfALevelAreThoseWhoseBoxesOverlap) {
  for (std::size_t i = 0; i < bodies().size(); ++i) {
    const Body& body = bodies()[i];
    const Body& other = bodies()[(5 * i + 3) % bodies().size()];
    for (int level = 0; level <= 6; ++level) {
      for (const double margin : {0.0, 0.05}) {
        SCOPED_TRACE(body.name + " and " + other.name + ", level " + std::to_string(level));
        std::vector<BlockPair> self, dual;
        TraversalCounters counters;
        const TraversalOptions options{.margin = margin, .certificate = false};
        self_traversal_of_blocks(body.pyramid, level, options, self, counters);
        dual_traversal_of_blocks(body.pyramid, other.pyramid, level, options, dual, counters);
        EXPECT_EQ(keys_of(self, true),
                  all_block_pairs(body.pyramid, body.pyramid, level, margin, true));
        EXPECT_EQ(keys_of(dual, false),
                  all_block_pairs(body.pyramid, other.pyramid, level, margin, false));
      }
    }
  }
}

}  // namespace
}  // namespace weft::bsi::traversal_test
