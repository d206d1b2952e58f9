#include "gpu/compute_traversal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <tuple>

#include "bsi/narrow_phase.h"
#include "bsi/shapes.h"
#include "gpu/gl_objects.h"
#include "tests/gpu/leaf_oracle.h"
#include "tests/gpu/test_context.h"

namespace weft::gpu::compute_traversal_test {
namespace {

using bsi::Atlas;
using bsi::Surface;

struct Scene {
  std::vector<Surface> bodies;
  std::vector<std::vector<Vec3>> start, end;
  std::vector<BodyImage> images;

  int size() const { return static_cast<int>(bodies.size()); }
  std::vector<const Atlas*> atlases() const {
    std::vector<const Atlas*> result;
    for (const Surface& body : bodies) result.push_back(&body.atlas);
    return result;
  }
};

// Returns the pairs found by brute force, sorted.
std::vector<Candidate> expected_pairs(const Scene& scene, std::span<const PairQuery> queries,
                                      Leaf leaf) {
  std::vector<Candidate> found;
  for (std::uint32_t q = 0; q < queries.size(); ++q) {
    const auto leaves_of = [&](int body) {
      return leaf_boxes(scene.bodies[body].atlas, scene.images[body], leaf);
    };
    const auto& query = queries[q];
    const auto pairs =
        pairs_of_leaves(leaves_of(query.body_a), leaves_of(query.body_b), query, q, leaf);
    found.insert(found.end(), pairs.begin(), pairs.end());
  }
  return found;
}

Surface moved(Surface surface, const Vec3& by, double noise, std::mt19937& random) {
  std::uniform_real_distribution<double> shift(-noise, noise);
  for (Vec3& p : surface.positions) {
    p += by + Vec3(shift(random), shift(random), shift(random));
  }
  return surface;
}

// A sheet over a torus and a sewn sphere, and a strip of one quad's width; body 1 is swept.
Scene scene_of_bodies() {
  std::mt19937 random(11);
  Scene scene;
  scene.bodies.push_back(moved(bsi::make_rectangle(2, 2, 20, 27), {0, 0, 0.3}, 0.03, random));
  scene.bodies.push_back(moved(bsi::make_torus(0.7, 0.3, 19, 12), {0, 0, 0}, 0.01, random));
  scene.bodies.push_back(moved(bsi::make_sphere(0.4, 6), {0.6, 0.2, 0.1}, 0.01, random));
  scene.bodies.push_back(moved(bsi::make_rectangle(2, 0.1, 2, 33), {0, 0, 0.31}, 0.01, random));
  scene.bodies.push_back(moved(bsi::make_rectangle(1, 1, 2, 2), {0, 0, 0.3}, 0.01, random));
  scene.bodies.push_back(moved(bsi::make_rectangle(1, 1, 5, 5), {9, 0, 0}, 0, random));
  for (const Surface& body : scene.bodies) {
    scene.start.push_back(body.positions);
    scene.end.push_back(moved(body, {0.02, 0.01, 0.1}, 0.02, random).positions);
  }
  for (int b = 0; b < scene.size(); ++b) {
    scene.images.push_back({b, scene.start[b]});
    if (b == 1) scene.images.back().end = scene.end[b];
  }
  return scene;
}

std::vector<PairQuery> all_pairs(const Scene& scene, double margin) {
  std::vector<PairQuery> queries;
  for (int a = 0; a < scene.size(); ++a) {
    for (int b = a; b < scene.size(); ++b) queries.push_back({a, b, margin * (1 + a), false});
  }
  return queries;
}

// The rebuilt pyramids of a scene, with their traversal.
struct Search {
  ComputePyramid pyramids;
  ComputeTraversal traversal;
  Search(GlContext& context, Scene scene, bsi::Bound bound)
      : pyramids(context, scene.atlases()), traversal(pyramids, bound) {
    for (BodyImage& image : scene.images) image.spheres = bound != bsi::Bound::box;
    pyramids.rebuild(scene.images);
  }
};

constexpr std::array bounds{bsi::Bound::sphere, bsi::Bound::box, bsi::Bound::sphere_then_box};

class ComputeTraversals : public testing::TestWithParam<std::tuple<Leaf, bsi::Bound>> {
 protected:
  static Leaf leaf() { return std::get<Leaf>(GetParam()); }
  static bsi::Bound bound() { return std::get<bsi::Bound>(GetParam()); }
};

TEST_P(ComputeTraversals, FindAllPairsOfAllBodiesAtOnce) {
  WEFT_NEEDS_CONTEXT();
  const Scene scene = scene_of_bodies();
  Search search(context, scene, bound());
  for (const double margin : {0.0, 0.02}) {
    const std::vector<PairQuery> queries = all_pairs(scene, margin);
    const auto expected = expected_pairs(scene, queries, leaf());
    EXPECT_GT(expected.size(), 1000);
    EXPECT_EQ(sorted(search.traversal.find_pairs(queries, leaf())), expected) << margin;
  }
  EXPECT_GT(search.traversal.reruns(), 0);
  const int reruns = search.traversal.reruns();
  search.traversal.find_pairs(all_pairs(scene, 0.02), leaf());
  EXPECT_EQ(search.traversal.reruns(), reruns);  // the room is kept
}

TEST_P(ComputeTraversals, FindLeavesNearBalls) {
  WEFT_NEEDS_CONTEXT();
  const Scene scene = scene_of_bodies();
  Search search(context, scene, bound());
  std::mt19937 random(12);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  std::vector<Ball> balls(300);
  for (Ball& ball : balls) {
    // The ball is rounded to float32, like the oracle's.
    ball.centre = Vec3(coordinate(random), coordinate(random), 0.4 * coordinate(random))
                      .cast<float>()
                      .cast<double>();
    ball.radius = 0.05 * (1 + coordinate(random));
  }
  for (const int body : {1, 2, 4}) {
    const auto boxes = leaf_boxes(scene.bodies[body].atlas, scene.images[body], leaf());
    const auto expected = leaves_near_balls(balls, 0.01, boxes);
    EXPECT_GT(expected.size(), 5);
    EXPECT_EQ(sorted(search.traversal.find_leaves(body, balls, 0.01, leaf())), expected);
  }
}

// Returns the ends of the paths of a quad's corners.
std::array<Vec3, 4> ends_of(const Scene& scene, int body, std::uint32_t quad) {
  const BodyImage& image = scene.images[body];
  const std::span<const Vec3> positions = image.end.empty() ? image.start : image.end;
  std::array<Vec3, 4> corners;
  const auto particles = scene.bodies[body].atlas.quad_particles(static_cast<int>(quad));
  for (int i = 0; i < 4; ++i) corners[i] = positions[particles[i]];
  return corners;
}

double longest_path(const Scene& scene, int body, std::uint32_t quad) {
  const BodyImage& image = scene.images[body];
  double longest = 0;
  if (image.end.empty()) return longest;
  for (const int particle : scene.bodies[body].atlas.quad_particles(static_cast<int>(quad))) {
    longest = std::max(longest, (image.end[particle] - image.start[particle]).norm());
  }
  return longest;
}

double distance_at_end(const Scene& scene, const PairQuery& query, const Candidate& pair) {
  const auto a = ends_of(scene, query.body_a, pair.a), b = ends_of(scene, query.body_b, pair.b);
  double least = std::numeric_limits<double>::infinity();
  for (const int first : {0, 3}) {
    for (const int second : {0, 3}) {
      least = std::min(
          least, bsi::squared_triangle_distance({a[first], a[1], a[2]}, {b[second], b[1], b[2]}));
    }
  }
  return std::sqrt(least);
}

TEST(ComputeTraversal, TheFilterLeavesOutWhatCannotBeInReachAndNothingElse) {
  WEFT_NEEDS_CONTEXT();
  const Scene scene = scene_of_bodies();
  Search search(context, scene, bsi::Bound::box);
  for (const double margin : {0.0, 0.02}) {
    std::vector<PairQuery> queries = all_pairs(scene, margin);
    const auto all = sorted(search.traversal.find_pairs(queries, Leaf::quad));
    for (PairQuery& query : queries) query.distance_filter = true;
    const auto left = sorted(search.traversal.find_pairs(queries, Leaf::quad));
    ASSERT_TRUE(std::ranges::includes(all, left, before));
    std::vector<Candidate> gone;
    std::ranges::set_difference(all, left, std::back_inserter(gone), before);
    EXPECT_GT(gone.size(), 100) << margin;  // most of what is left are neighbours of one body
    for (const Candidate& pair : gone) {
      const PairQuery& query = queries[pair.query];
      const double path = std::max(longest_path(scene, query.body_a, pair.a),
                                   longest_path(scene, query.body_b, pair.b));
      ASSERT_GT(distance_at_end(scene, query, pair), query.margin + 2 * path);
    }
  }
}

// A quad that is a segment but for 1e-25 m has a normal whose square is 0 in float32. Another one
// lies in reach of it, 1 mm away. At 1e15 m squares overflow: quads that meet are left in.
TEST(ComputeTraversal, TheFilterKeepsWhatItsArithmeticCannotJudge) {
  WEFT_NEEDS_CONTEXT();
  const Surface square = bsi::make_rectangle(1, 1, 2, 2);
  Scene scene;
  for (const double size : {1.0, 1e15}) {
    Surface line{square.atlas, {{0, 0, 0}, {0, 0, 0}, {1, 1e-25, 0}, {1, 0, 0}}};
    Surface above{square.atlas, {{0, -1, 1e-3}, {1, -1, 1e-3}, {0, 1, 1e-3}, {1, 1, 1e-3}}};
    if (size > 1) {
      line.positions = above.positions = square.positions;
      for (Vec3& p : above.positions) p.z() += 1e-9;
    }
    for (Surface* surface : {&line, &above}) {
      for (Vec3& p : surface->positions) p *= size;
      scene.bodies.push_back(*surface);
    }
  }
  for (int b = 0; b < scene.size(); ++b) scene.images.push_back({b, scene.bodies[b].positions});
  Search search(context, scene, bsi::Bound::box);
  for (const auto& [body, margin] : {std::pair(0, 1e-2), std::pair(2, 1e7)}) {
    PairQuery query{body, body + 1, margin, false, true};
    EXPECT_EQ(search.traversal.find_pairs({&query, 1}, Leaf::quad).size(), 1) << body;
  }
}

// The bodies have random sizes, wraps and folds, and few quads, so that all shapes of blocks occur.
TEST(ComputeTraversal, FindsWhatBruteForceFindsOnRandomBodies) {
  WEFT_NEEDS_CONTEXT();
  std::mt19937 random(13);
  const auto pick = [&](int low, int high) {
    return std::uniform_int_distribution<int>(low, high)(random);
  };
  for (int trial = 0; trial < 20; ++trial) {
    Scene scene;
    const double scale = std::pow(10.0, pick(-6, 6));
    for (int b = 0; b < 3; ++b) {
      std::vector<bsi::Patch> patches;
      for (int p = pick(1, 3); p > 0; --p) {
        bsi::Patch patch{pick(2, 12), pick(2, 12), pick(0, 1) == 1, pick(0, 1) == 1};
        patch.rows += patch.wrap_v ? 1 : 0;
        patch.cols += patch.wrap_u ? 1 : 0;
        patches.push_back(patch);
      }
      Surface body{Atlas(patches), {}};
      std::uniform_real_distribution<double> coordinate(-scale, scale);
      Vec3 p(0, 0, 0);
      for (int i = 0; i < body.atlas.particle_count(); ++i) {
        p = 0.7 * p + 0.3 * Vec3(coordinate(random), coordinate(random), coordinate(random));
        body.positions.push_back(p);
      }
      scene.bodies.push_back(body);
      scene.start.push_back(body.positions);
      scene.end.push_back(moved(body, {0, 0, 0}, 0.1 * scale, random).positions);
    }
    for (int b = 0; b < 3; ++b) {
      scene.images.push_back({b, scene.start[b]});
      if (pick(0, 1) == 1) scene.images.back().end = scene.end[b];
    }
    Search search(context, scene, bsi::Bound::box);
    const std::vector<PairQuery> queries = all_pairs(scene, pick(0, 1) * 0.05 * scale);
    for (const Leaf leaf : {Leaf::quad, Leaf::triangle}) {
      ASSERT_EQ(sorted(search.traversal.find_pairs(queries, leaf)),
                expected_pairs(scene, queries, leaf))
          << "trial " << trial;
    }
  }
}

std::vector<Candidate> found_by_cpu(const Scene& scene, const PairQuery& query, Leaf leaf,
                                    bsi::TraversalCounters& counters) {
  std::vector<bsi::Pyramid> pyramids;
  for (const int body : {query.body_a, query.body_b}) {
    const BodyImage& image = scene.images[body];
    pyramids.emplace_back(scene.bodies[body].atlas);
    const auto bad = image.end.empty() ? pyramids.back().rebuild(image.start)
                                       : pyramids.back().rebuild_swept(image.start, image.end);
    EXPECT_FALSE(bad);
  }
  const bsi::TraversalOptions options{
      .margin = query.margin, .leaf = leaf, .certificate = query.certificate};
  std::vector<bsi::LeafPair> pairs;
  if (query.body_a == query.body_b) {
    bsi::self_traversal(pyramids[0], options, pairs, counters);
  } else {
    bsi::dual_traversal(pyramids[0], pyramids[1], options, pairs, counters);
  }
  std::vector<Candidate> found;
  found.reserve(pairs.size());
  for (const auto& [a, b] : pairs) {
    found.push_back({0, static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b)});
  }
  return sorted(found);
}

// Smooth sheets, increasingly crumpled ones, closed and sewn ones. In each, some blocks are
// certified free of contact with themselves, and some are not.
Scene scene_of_sheets() {
  std::mt19937 random(14);
  Scene scene;
  for (const double noise : {0.0, 0.003, 0.01, 0.03}) {
    scene.bodies.push_back(moved(bsi::make_rectangle(1, 1, 33, 33), {1, 2, 3}, noise, random));
    scene.bodies.push_back(moved(bsi::make_rectangle(2, 0.5, 13, 70), {0, 0, 0}, noise, random));
    scene.bodies.push_back(moved(bsi::make_torus(0.7, 0.3, 40, 21), {0, 0, 0}, noise, random));
    scene.bodies.push_back(moved(bsi::make_cylinder(0.4, 1, 17, 64), {0, 0, 0}, noise, random));
    scene.bodies.push_back(moved(bsi::make_sphere(0.4, 12), {0, 0, 0}, noise, random));
  }
  for (Surface& body : scene.bodies) {
    for (Vec3& p : body.positions) p.z() += 0.1 * std::sin(3 * p.x()) * std::cos(5 * p.y());
    scene.start.push_back(body.positions);
    scene.end.push_back(moved(body, {0.02, 0.01, 0.1}, 0.002, random).positions);
  }
  scene.images.reserve(scene.bodies.size());
  for (int b = 0; b < scene.size(); ++b) {
    scene.images.push_back({.body = b, .start = scene.start[b], .tangents = true});
    if (b % 3 == 0) scene.images.back().end = scene.end[b];
  }
  return scene;
}

// The device decides the same to the last bit. A graphics processor, whose roots may round
// differently, rejects slightly fewer pairs.
TEST_P(ComputeTraversals, LeaveOutWhatTheTangentCertificateProves) {
  WEFT_NEEDS_CONTEXT();
  const Scene scene = scene_of_sheets();
  Search search(context, scene, bound());
  bsi::TraversalCounters counters;
  std::size_t found = 0;
  for (int b = 0; b < scene.size(); ++b) {
    for (const double margin : {0.0, 0.004}) {
      const PairQuery query{b, b, margin, true};
      const auto expected = found_by_cpu(scene, query, leaf(), counters);
      const auto on_device = sorted(search.traversal.find_pairs(std::span(&query, 1), leaf()));
      if (context.backend() == GlBackend::hardware) {
        ASSERT_TRUE(std::ranges::includes(on_device, expected, before));
      } else {
        ASSERT_EQ(on_device, expected) << "body " << b << " margin " << margin;
      }
      found += expected.size();
    }
  }
  EXPECT_GT(counters.certified, 100);
  EXPECT_LT(counters.certified, counters.certificate_tests / 2);
  EXPECT_GT(found, 10000);
}

// All quads of two sheets are in reach of each other: too many pairs for the buffer. After the
// error, the device works with fewer pairs.
TEST(ComputeTraversal, SaysWhichListTheDeviceCannotHold) {
  WEFT_NEEDS_CONTEXT();
  const std::size_t limit = buffer_limit(context.functions());
  if (limit > std::size_t{1} << 28)
    GTEST_SKIP() << "the device has buffers of " << limit << " bytes";
  const auto quads = static_cast<int>(
      std::ceil(std::sqrt(std::sqrt(static_cast<double>(limit / sizeof(Candidate))))));
  Scene scene;
  for (const double height : {0.0, 0.01}) {
    std::mt19937 random(15);
    const Surface sheet = bsi::make_rectangle(1, 1, quads + 2, quads + 2);
    scene.bodies.push_back(moved(sheet, {0, 0, height}, 0, random));
  }
  for (int b = 0; b < 2; ++b) scene.images.push_back({b, scene.bodies[b].positions});
  Search search(context, scene, bsi::Bound::box);
  PairQuery query{0, 1, 2, false};
  try {
    search.traversal.find_pairs({&query, 1}, Leaf::quad);
    FAIL() << "no error";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("candidates take"), std::string::npos) << error.what();
  }
  query.margin = 0.02;
  EXPECT_EQ(sorted(search.traversal.find_pairs({&query, 1}, Leaf::quad)),
            expected_pairs(scene, {&query, 1}, Leaf::quad));
}

TEST(ComputeTraversal, FindsNothingWhereThereIsNothing) {
  WEFT_NEEDS_CONTEXT();
  const Scene scene = scene_of_bodies();
  Search search(context, scene, bsi::Bound::box);
  EXPECT_TRUE(search.traversal.find_pairs({}, Leaf::quad).empty());
  EXPECT_TRUE(search.traversal.find_leaves(0, {}, 0.1, Leaf::quad).empty());
  const PairQuery apart{0, 5, 0.1, false};
  EXPECT_TRUE(search.traversal.find_pairs(std::span(&apart, 1), Leaf::triangle).empty());
}

std::string name_of(const testing::TestParamInfo<std::tuple<Leaf, bsi::Bound>>& tested) {
  constexpr std::array names{"Spheres", "Boxes", "SpheresThenBoxes"};
  const auto& [leaf, bound] = tested.param;
  return std::string(leaf == Leaf::quad ? "quads" : "triangles") + "By" +
         names[static_cast<int>(bound)];
}

INSTANTIATE_TEST_SUITE_P(Leaves, ComputeTraversals,
                         testing::Combine(testing::Values(Leaf::quad, Leaf::triangle),
                                          testing::ValuesIn(bounds)),
                         name_of);

}  // namespace
}  // namespace weft::gpu::compute_traversal_test
