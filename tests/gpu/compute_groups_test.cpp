// Groups of patches on the device: those of the CPU, by place.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <random>
#include <string>

#include "bsi/shapes.h"
#include "tests/gpu/leaf_oracle.h"
#include "tests/gpu/test_context.h"

namespace weft::gpu::compute_groups_test {
namespace {

using bsi::Surface;

// Returns the positions of all texels, patch by patch.
std::vector<Vec3> texels_of(const Surface& surface) {
  std::vector<Vec3> texels;
  for (int texel = 0; texel < surface.atlas.texel_count(); ++texel) {
    texels.push_back(surface.positions[surface.atlas.particle_of_texel(texel)]);
  }
  return texels;
}

// Returns the surface with its patches in another order: neighbours have numbers far apart.
Surface renumbered(const Surface& surface, unsigned seed) {
  const bsi::Patch& size = surface.atlas.patches().front();
  const int patches = static_cast<int>(surface.atlas.patches().size());
  const std::vector<Vec3> texels = texels_of(surface);
  std::vector<int> order(patches);
  for (int patch = 0; patch < patches; ++patch) order[patch] = patch;
  std::shuffle(order.begin(), order.end(), std::mt19937(seed));
  std::vector<Vec3> moved;
  for (const int patch : order) {
    const auto first = texels.begin() + static_cast<std::ptrdiff_t>(patch) * size.texel_count();
    moved.insert(moved.end(), first, first + size.texel_count());
  }
  return bsi::make_from_texels(patches, size.rows, size.cols, moved, false, false);
}

std::vector<Vec3> shaken(std::vector<Vec3> positions, double by, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-by, by);
  for (Vec3& p : positions) p += Vec3(shift(random), shift(random), shift(random));
  return positions;
}

void expect_groups_of_the_cpu(const ComputePyramid& pyramids, int body,
                              const bsi::Pyramid& expected) {
  const std::vector<BlockBox> boxes = pyramids.read_boxes(body);
  ASSERT_EQ(pyramids.group_levels(body), expected.group_levels());
  for (int level = 0; level < expected.group_levels(); ++level) {
    for (int u = 0; u < 1 << level; ++u) {
      EXPECT_TRUE(std::ranges::equal(pyramids.patches_of_group(body, level, u),
                                     expected.patches_of_group(level, u)));
      const bsi::Box& box = expected.group_box(level, u);
      const BlockBox& own = boxes[pyramids.group_block(body, level, u)];
      EXPECT_EQ(own, (BlockBox{box.low, box.high})) << level << ' ' << u;
    }
  }
}

TEST(ComputeGroups, AreThoseOfTheCpuAtEveryRebuild) {
  WEFT_NEEDS_CONTEXT();
  const std::array bodies{renumbered(bsi::make_blob(1, 4), 1), bsi::make_torus(1, 0.3, 9, 12),
                          bsi::make_sphere(0.5, 6)};
  std::vector<const bsi::Atlas*> atlases;
  std::vector<bsi::Pyramid> expected;
  for (const Surface& body : bodies) {
    atlases.push_back(&body.atlas);
    expected.emplace_back(body.atlas);
  }
  ComputePyramid pyramids(context, atlases);
  // The groups stay those of the first rebuild that has a place for every patch.
  for (unsigned rebuild = 0; rebuild < 3; ++rebuild) {
    for (int body = 0; body < 3; ++body) {
      std::vector<Vec3> start = shaken(bodies[body].positions, 0.4, 10 * rebuild);
      const std::vector<Vec3> end = shaken(bodies[body].positions, 0.4, 10 * rebuild + 5);
      if (rebuild == 0) start[7].y() = std::numeric_limits<double>::quiet_NaN();
      BodyImage image{body, start};
      if (body == 0) image.end = end;
      pyramids.rebuild(std::span(&image, 1));
      const auto bad =
          body == 0 ? expected[body].rebuild_swept(start, end) : expected[body].rebuild(start);
      ASSERT_EQ(bad.has_value(), rebuild == 0);
      ASSERT_EQ(pyramids.first_unbounded().has_value(), rebuild == 0);
      if (rebuild > 0) {
        expect_groups_of_the_cpu(pyramids, body, expected[body]);
        continue;
      }
      const BodyImage finite{body, end};
      pyramids.rebuild(std::span(&finite, 1));
      ASSERT_FALSE(expected[body].rebuild(end));
    }
  }
}

// A body of many patches and a torus through it, with their pyramids on the device.
class Renumbered {
 public:
  Renumbered(GlContext& context, const Surface& blob, bsi::Bound bound)
      : bodies_{blob, bsi::make_torus(0.9, 0.2, 24, 10)},
        pyramids_(context, std::array{&bodies_[0].atlas, &bodies_[1].atlas}),
        traversal_(pyramids_, bound) {
    for (int body = 0; body < 2; ++body) {
      images_.push_back({.body = body,
                         .start = bodies_[body].positions,
                         .tangents = true,
                         .spheres = bound != bsi::Bound::box});
    }
    pyramids_.rebuild(images_);
  }

  std::vector<Candidate> found(const PairQuery& query, Leaf leaf) {
    return sorted(traversal_.find_pairs(std::span(&query, 1), leaf));
  }
  std::vector<Candidate> by_brute_force(const PairQuery& query, Leaf leaf) const {
    return pairs_of_leaves(boxes(query.body_a, leaf), boxes(query.body_b, leaf), query, 0, leaf);
  }
  std::vector<Candidate> found(std::span<const Ball> balls, Leaf leaf) {
    return sorted(traversal_.find_leaves(0, balls, 0.01, leaf));
  }
  std::size_t pairs_followed() const { return traversal_.pairs_followed(); }
  const Surface& body(int number) const { return bodies_[number]; }
  std::vector<LeafBox> boxes(int body, Leaf leaf) const {
    return leaf_boxes(bodies_[body].atlas, images_[body], leaf);
  }

 private:
  std::array<Surface, 2> bodies_;
  std::vector<BodyImage> images_;
  ComputePyramid pyramids_;
  ComputeTraversal traversal_;
};

std::vector<Candidate> found_by_cpu(const Renumbered& scene, const PairQuery& query, Leaf leaf,
                                    bsi::Bound bound) {
  std::vector<bsi::Pyramid> pyramids;
  for (const int body : {query.body_a, query.body_b}) {
    pyramids.emplace_back(scene.body(body).atlas, bsi::PyramidParts{.spheres = true});
    EXPECT_FALSE(pyramids.back().rebuild(scene.body(body).positions));
  }
  const bsi::TraversalOptions options{
      .margin = query.margin, .leaf = leaf, .bound = bound, .certificate = query.certificate};
  std::vector<bsi::LeafPair> pairs;
  bsi::TraversalCounters counters;
  if (query.body_a == query.body_b) {
    bsi::self_traversal(pyramids[0], options, pairs, counters);
  } else {
    bsi::dual_traversal(pyramids[0], pyramids[1], options, pairs, counters);
  }
  std::vector<Candidate> found;
  for (const auto& [a, b] : pairs) {
    found.push_back({0, static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b)});
  }
  return sorted(found);
}

constexpr std::array bounds{bsi::Bound::sphere, bsi::Bound::box, bsi::Bound::sphere_then_box};

class ComputeGroupSearches : public testing::TestWithParam<bsi::Bound> {};

TEST_P(ComputeGroupSearches, FindWhatBruteForceFinds) {
  WEFT_NEEDS_CONTEXT();
  Renumbered scene(context, renumbered(bsi::make_blob(1, 4), 2), GetParam());
  for (const Leaf leaf : {Leaf::quad, Leaf::triangle}) {
    for (const PairQuery query : {PairQuery{0, 0, 0.01, false}, PairQuery{0, 1, 0.01, false},
                                  PairQuery{1, 0, 0.05, false}}) {
      const auto expected = scene.by_brute_force(query, leaf);
      EXPECT_GT(expected.size(), 300);
      EXPECT_EQ(scene.found(query, leaf), expected);
      EXPECT_EQ(found_by_cpu(scene, query, leaf, GetParam()), expected);
    }
    const PairQuery certified{0, 0, 0.01, true};
    if (context.backend() == GlBackend::hardware) continue;  // it may prove a little less
    EXPECT_EQ(scene.found(certified, leaf), found_by_cpu(scene, certified, leaf, GetParam()));
  }
}

TEST_P(ComputeGroupSearches, FindLeavesNearBalls) {
  WEFT_NEEDS_CONTEXT();
  Renumbered scene(context, renumbered(bsi::make_blob(1, 4), 3), GetParam());
  std::vector<Ball> balls;
  for (const Vec3& p : bsi::make_sphere(1, 5).positions) {
    balls.push_back({p.cast<float>().cast<double>(), 0.05});
  }
  for (const Leaf leaf : {Leaf::quad, Leaf::triangle}) {
    const auto expected = leaves_near_balls(balls, 0.01, scene.boxes(0, leaf));
    EXPECT_GT(expected.size(), 100);
    EXPECT_EQ(scene.found(balls, leaf), expected);
  }
}

// By number, groups of shuffled patches would all overlap.
TEST_P(ComputeGroupSearches, FollowAsManyPairsHoweverPatchesAreNumbered) {
  WEFT_NEEDS_CONTEXT();
  const Surface blob = bsi::make_blob(1, 4);
  const PairQuery itself{0, 0, 0.001, false};
  std::size_t in_order = 0;
  for (unsigned seed = 1; seed < 4; ++seed) {
    Renumbered scene(context, renumbered(blob, seed), GetParam());
    const std::size_t candidates = scene.found(itself, Leaf::quad).size();
    EXPECT_GT(candidates, 1000);
    if (in_order == 0) in_order = scene.pairs_followed();
    EXPECT_EQ(scene.pairs_followed(), in_order);
  }
}

std::string name_of(const testing::TestParamInfo<bsi::Bound>& tested) {
  constexpr std::array names{"Spheres", "Boxes", "SpheresThenBoxes"};
  return names[static_cast<int>(tested.param)];
}

INSTANTIATE_TEST_SUITE_P(Bounds, ComputeGroupSearches, testing::ValuesIn(bounds), name_of);

}  // namespace
}  // namespace weft::gpu::compute_groups_test
