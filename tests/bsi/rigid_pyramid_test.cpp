#include "bsi/rigid_pyramid.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>
#include <random>
#include <string>

#include "bsi/detail/instruction_set.h"
#include "bsi/kernels/box_descent_kernels.h"
#include "bsi/shapes.h"
#include "bsi/traversal.h"
#include "tests/bsi/crumpled.h"
#include "tests/bsi/restored_settings.h"

namespace weft::bsi::rigid_pyramid_test {
namespace {

using Positions = std::vector<Vec3>;
using Frames = std::vector<RigidFrame>;

constexpr std::array bounds{Bound::sphere, Bound::box, Bound::sphere_then_box};
constexpr std::array leaf_kinds{Leaf::quad, Leaf::triangle};

Surface crumpled_surface(Surface surface, double noise, const Vec3& offset = Vec3::Zero()) {
  surface.positions = crumpled(surface.positions, noise, 7);
  for (Vec3& p : surface.positions) p += offset;
  return surface;
}

Surface pieces() {
  Surface surface;
  surface.atlas = Atlas({{2, 9}, {5, 5, true, false}, {3, 3}, {12, 2}, {4, 6, true, true}});
  surface.positions.resize(surface.atlas.particle_count(), Vec3::Zero());
  return surface;
}

// Smooth and crumpled bodies, of odd sizes, of one quad, wrapped, of several patches, sewn.
std::vector<Surface> surfaces() {
  return {crumpled_surface(make_rectangle(1, 1, 12, 15), 0.02),
          make_rectangle(1, 1, 33, 33),
          make_rectangle(0.7, 0.7, 2, 2),
          make_torus(0.5, 0.2, 17, 9),
          make_sphere(0.4, 6),
          crumpled_surface(pieces(), 0.3)};
}

class Random {
 public:
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(source_);
  }
  Vec3 vector(double size) {
    return {between(-size, size), between(-size, size), between(-size, size)};
  }
  RigidFrame frame(double shift) {
    const Vec3 axis = vector(1).normalized();
    return {Eigen::AngleAxisd(between(-3.1, 3.1), axis).toRotationMatrix(), vector(shift)};
  }
  // Close to another, as at the end of a step.
  RigidFrame near(const RigidFrame& from) {
    const Vec3 axis = vector(1).normalized();
    return {Eigen::AngleAxisd(between(-0.3, 0.3), axis).toRotationMatrix() * from.rotation,
            from.translation + vector(0.1)};
  }

 private:
  std::mt19937 source_{11};
};

Positions placed(const Positions& own, const RigidFrame& frame) {
  Positions all;
  all.reserve(own.size());
  for (const Vec3& p : own) all.push_back(frame.place(p));
  return all;
}

std::vector<LeafPair> sorted(std::vector<LeafPair> pairs) {
  std::ranges::sort(pairs);
  EXPECT_EQ(std::ranges::adjacent_find(pairs), pairs.end()) << "a pair was found twice";
  return pairs;
}

// --- The oracle: every pair of leaves, by the boxes of the placed vertices ---

std::vector<int> corners(const Atlas& atlas, Leaf kind, int leaf) {
  const auto quad = atlas.quad_particles(kind == Leaf::quad ? leaf : leaf / 2);
  if (kind == Leaf::quad) return {quad.begin(), quad.end()};
  const auto triangle = quad_triangles(quad)[leaf % 2];
  return {triangle.begin(), triangle.end()};
}

std::vector<Box> leaf_boxes(const Atlas& atlas, Leaf kind, const std::vector<Positions>& ends,
                            float half) {
  std::vector<Box> boxes;
  const int count = atlas.quad_count() * (kind == Leaf::quad ? 1 : 2);
  for (int leaf = 0; leaf < count; ++leaf) {
    Box& box = boxes.emplace_back();
    box.low.fill(std::numeric_limits<float>::infinity());
    box.high.fill(-std::numeric_limits<float>::infinity());
    for (const Positions& positions : ends) {
      for (const int particle : corners(atlas, kind, leaf)) {
        for (int axis = 0; axis < 3; ++axis) {
          const auto x = static_cast<float>(positions[particle][axis]);
          box.low[axis] = std::min(box.low[axis], x);
          box.high[axis] = std::max(box.high[axis], x);
        }
      }
    }
    for (float& x : box.low) x -= half;
    for (float& x : box.high) x += half;
  }
  return boxes;
}

bool meet(const Box& a, const Box& b) {
  for (int axis = 0; axis < 3; ++axis) {
    if (a.low[axis] > b.high[axis] || b.low[axis] > a.high[axis]) return false;
  }
  return true;
}

std::vector<LeafPair> all_pairs(const std::vector<Box>& a, const std::vector<Box>& b) {
  std::vector<LeafPair> pairs;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j) {
      if (meet(a[i], b[j])) pairs.push_back({static_cast<int>(i), static_cast<int>(j)});
    }
  }
  return pairs;
}

// A body that deforms, and a rigid one in its own frame.
struct Meeting {
  const Surface& first;
  const Pyramid& first_pyramid;
  std::vector<Positions> first_ends;
  const Surface& second;
  const RigidPyramid& rigid;
  Frames frames;

  std::vector<Positions> second_ends() const {
    std::vector<Positions> ends;
    for (const RigidFrame& frame : frames) ends.push_back(placed(second.positions, frame));
    return ends;
  }

  // Compares with brute force, and with a pyramid that is rebuilt in space. Returns the number of
  // pairs.
  std::size_t check(TraversalOptions options) const {
    PlacedTree place;
    rigid.place(frames, place);
    const float half = half_margin(options.margin, first_pyramid.magnitude(), place.tree.magnitude);
    const auto ends = second_ends();
    const auto expected = all_pairs(leaf_boxes(first.atlas, options.leaf, first_ends, half),
                                    leaf_boxes(second.atlas, options.leaf, ends, half));
    std::vector<LeafPair> rebuilt_pairs;
    Pyramid rebuilt(second.atlas, {.tangents = false});
    EXPECT_FALSE(ends.size() == 1 ? rebuilt.rebuild(ends[0])
                                  : rebuilt.rebuild_swept(ends[0], ends[1]));
    EXPECT_LE(rebuilt.magnitude(), place.tree.magnitude);
    TraversalCounters counters;
    options.bound = Bound::box;
    dual_traversal(first_pyramid, rebuilt, options, rebuilt_pairs, counters);
    for (const Bound bound : bounds) {
      options.bound = bound;
      std::vector<LeafPair> pairs;
      dual_traversal(first_pyramid, rigid, frames, options, pairs, counters);
      pairs = sorted(pairs);
      EXPECT_TRUE(pairs == expected)
          << static_cast<int>(bound) << ": " << pairs.size() << " of " << expected.size();
      EXPECT_TRUE(std::ranges::includes(pairs, sorted(rebuilt_pairs)));
    }
    return expected.size();
  }
};

TEST(RigidPyramid, FindsEveryPairWhereverTheBodyLies) {
  Random random;
  std::size_t found = 0, turn = 0;
  constexpr std::array margins{0.0, 1e-3, 0.03, 0.1};
  const std::vector<Surface> all = surfaces();
  for (const Surface& first : all) {
    Pyramid still(first.atlas, {.spheres = true}), moving(first.atlas, {.spheres = true});
    ASSERT_FALSE(still.rebuild(first.positions));
    const Positions end = crumpled(first.positions, 0.02, 3);
    ASSERT_FALSE(moving.rebuild_swept(first.positions, end));
    for (const Surface& second : all) {
      const RigidPyramid rigid(second.atlas, second.positions, true);
      for (const bool is_swept : {false, true}) {
        for (const Leaf leaf : leaf_kinds) {
          Frames frames{random.frame(0.4)};
          if (is_swept) frames.push_back(random.near(frames[0]));
          SCOPED_TRACE(std::to_string(turn));
          Meeting meeting{first, is_swept ? moving : still, {first.positions}, second, rigid,
                          frames};
          if (is_swept) meeting.first_ends.push_back(end);
          found += meeting.check({.margin = margins[turn++ % margins.size()], .leaf = leaf});
        }
      }
    }
  }
  EXPECT_GT(found, 100000U);
}

// A long way between both ends, and turns by half a circle.
TEST(RigidPyramid, FindsEveryPairOnLongWays) {
  Random random;
  const Surface sheet = make_rectangle(2, 2, 9, 9), torus = make_torus(0.5, 0.2, 24, 12);
  Pyramid pyramid(sheet.atlas, {.spheres = true});
  ASSERT_FALSE(pyramid.rebuild(sheet.positions));
  const RigidPyramid rigid(torus.atlas, torus.positions, true);
  for (int i = 0; i < 40; ++i) {
    const Meeting meeting{sheet, pyramid, {sheet.positions},
                          torus, rigid,   {random.frame(1), random.frame(1)}};
    SCOPED_TRACE(i);
    meeting.check({.margin = 0.01, .leaf = Leaf::quad});
  }
}

TEST(RigidPyramid, FindsTheSameWithEveryInstructionSetAndNumberOfThreads) {
  const RestoredSettings restored;
  Random random;
  const Surface sheet = crumpled_surface(make_rectangle(1, 1, 40, 40), 0.01);
  const Surface torus = make_torus(0.5, 0.2, 64, 48);
  Pyramid pyramid(sheet.atlas, {.spheres = true});
  ASSERT_FALSE(pyramid.rebuild(sheet.positions));
  const RigidPyramid rigid(torus.atlas, torus.positions, true);
  const Frames frames{random.frame(0.1), random.frame(0.1)};
  for (const Bound bound : bounds) {
    std::vector<LeafPair> expected;
    for (const InstructionSet set : available_instruction_sets()) {
      use_instruction_set(set);
      for (const int threads : {1, 3}) {
        std::vector<LeafPair> pairs;
        TraversalCounters counters;
        dual_traversal(pyramid, rigid, frames,
                       {.margin = 0.01, .leaf = Leaf::quad, .bound = bound, .threads = threads},
                       pairs, counters);
        if (expected.empty()) expected = pairs;
        EXPECT_TRUE(pairs == expected) << name(set) << ", " << threads;
      }
    }
    EXPECT_GT(expected.size(), 1000U);
  }
}

// --- Rounding ---

// Follows the pairs of a single quad and the blocks of the placed tree down, without any margin
// that could hide what a box of a block has lost. Returns the leaf blocks that are reached.
std::vector<BoxNode> blocks_at(const Pyramid& probe, const PlacedTree& placed) {
  DescentQuery query{};
  query.a = &probe.tree();
  query.b = &placed.tree;
  query.bound = Bound::box;
  query.certificate_margin = -1;
  std::vector<NodePair> open;
  for (int patch = 0; patch < 1; ++patch)
    open.push_back({{0, 0, 0}, {placed.tree.patches[patch].first_level, 0, 0}});
  std::vector<BoxNode> reached;
  DescentCounters counters{};
  while (!open.empty()) {
    const NodePair pair = open.back();
    open.pop_back();
    std::array<NodePair, largest_expansion> next;
    const int count = descent_kernels().expand(query, pair, next.data(), counters);
    if (count < 0) reached.push_back(pair.b);
    if (count > 0) open.insert(open.end(), next.begin(), next.begin() + count);
  }
  return reached;
}

// Every block holds its vertices where they are in float32, however far the body lies from the
// origin of its frame, and its frame from that of space.
TEST(RigidPyramid, BlocksHoldTheirVerticesWhateverTheRounding) {
  Random random;
  const int n = 65;
  const Surface probe = make_rectangle(1, 1, 2, 2);
  Pyramid point(probe.atlas, {.tangents = false});
  for (const auto& [own_offset, shift] :
       {std::pair{0.0, 0.5}, {1e3, 1e3}, {1e3, 0.0}, {0.3, 1e4}, {0.0, 1e4}, {1e5, 1e5}}) {
    for (int turn = 0; turn < 12; ++turn) {
      Surface sheet = make_rectangle(1, 1, n, n);
      const Vec3 offset = random.vector(own_offset);
      for (Vec3& p : sheet.positions) p += offset;
      const RigidPyramid rigid(sheet.atlas, sheet.positions, false);
      RigidFrame frame = random.frame(shift);
      if (turn % 3 == 0) frame.rotation.setIdentity();
      // Every other body comes back to the origin of space, where float32 is fine.
      if (turn % 2 == 0) frame.translation = -(frame.rotation * offset) + random.vector(0.5);
      Frames frames{frame};
      if (turn % 4 > 1) frames.push_back(random.near(frame));
      PlacedTree placed;
      rigid.place(frames, placed);
      for (int i = 0; i < 40; ++i) {
        const int row = static_cast<int>(random.between(0, n - 0.01));
        const int col = static_cast<int>(random.between(0, n - 0.01));
        for (const RigidFrame& at : frames) {
          const Vec3 place = at.place(sheet.positions[row * n + col]);
          ASSERT_FALSE(point.rebuild(Positions(4, place)));
          const auto reached = blocks_at(point, placed);
          // Leaf blocks have 2 x 2 quads.
          const bool is_there = std::ranges::any_of(reached, [&](const BoxNode& block) {
            return block.u == std::min(col / 2, 31) && block.v == std::min(row / 2, 31);
          });
          ASSERT_TRUE(is_there) << own_offset << ' ' << shift << ' ' << turn;
        }
      }
    }
  }
}

}  // namespace
}  // namespace weft::bsi::rigid_pyramid_test
