#include "bsi/narrow_phase.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "bsi/detail/instruction_set.h"
#include "bsi/shapes.h"
#include "bsi/traversal.h"
#include "tests/bsi/restored_settings.h"

namespace weft::bsi::narrow_phase_test {
namespace {

// Triangles that share no particles.
struct Soup {
  std::vector<Vec3> positions;
  std::vector<std::array<int, 3>> triangles;

  void add(const Vec3& a, const Vec3& b, const Vec3& c) {
    const int first = static_cast<int>(positions.size());
    positions.insert(positions.end(), {a, b, c});
    triangles.push_back({first, first + 1, first + 2});
  }
  std::array<Vec3, 3> corners(int t) const {
    return {positions[triangles[t][0]], positions[triangles[t][1]], positions[triangles[t][2]]};
  }
  TriangleSet set() const { return {positions, triangles}; }
  int count() const { return static_cast<int>(triangles.size()); }
};

std::vector<LeafPair> all_pairs(const Soup& a, const Soup& b) {
  std::vector<LeafPair> pairs;
  for (int i = 0; i < a.count(); ++i)
    for (int j = 0; j < b.count(); ++j) pairs.push_back({i, j});
  return pairs;
}

TriangleHits hits_of(const Soup& a, const Soup& b, double margin, int threads = 1,
                     NarrowPhaseCounters* counters = nullptr) {
  TriangleHits hits;
  NarrowPhaseCounters cost;
  find_triangle_hits(a.set(), b.set(), all_pairs(a, b), {margin, true, threads}, hits, cost);
  if (counters != nullptr) *counters = cost;
  return hits;
}

// Compares every pair with the scalar functions. Returns the number of hits.
int compare_with_scalar(const Soup& a, const Soup& b, double margin) {
  const TriangleHits hits = hits_of(a, b, margin);
  TriangleHits without_distances;
  NarrowPhaseCounters cost;
  find_triangle_hits(a.set(), b.set(), all_pairs(a, b), {margin, false, 1}, without_distances,
                     cost);
  EXPECT_EQ(hits.pairs, without_distances.pairs);
  std::size_t next = 0;
  for (const LeafPair& pair : all_pairs(a, b)) {
    const double squared = squared_triangle_distance(a.corners(pair.a), b.corners(pair.b));
    const bool hit = squared <= margin * margin;
    const bool found = next < hits.pairs.size() && hits.pairs[next] == pair;
    EXPECT_EQ(found, hit) << pair.a << " " << pair.b << " distance " << std::sqrt(squared)
                          << " margin " << margin;
    if (found) {
      const double distance = std::sqrt(squared);
      EXPECT_NEAR(hits.distances[next], distance, 1e-11 * distance) << pair.a << " " << pair.b;
      ++next;
    }
    if (testing::Test::HasFailure()) return 0;
  }
  return static_cast<int>(next);
}

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double uniform() { return uniform_(engine_); }
  Vec3 point() { return {uniform(), uniform(), uniform()}; }
  int below(int n) { return std::uniform_int_distribution(0, n - 1)(engine_); }

 private:
  std::mt19937 engine_;
  std::uniform_real_distribution<double> uniform_{-1, 1};
};

Soup random_soup(Random& random, int count, double size, const Vec3& offset, double scale) {
  Soup soup;
  for (int t = 0; t < count; ++t) {
    const Vec3 middle = random.point();
    const auto corner = [&] { return Vec3(offset + scale * (middle + size * random.point())); };
    const Vec3 a = corner(), b = corner(), c = corner();
    soup.add(a, b, c);
  }
  return soup;
}

TEST(NarrowPhase, AgreesWithTheScalarFunctions) {
  Random random(1);
  int hits = 0, pairs = 0;
  for (double size : {0.05, 0.3, 1.0}) {
    for (double margin : {0.0, 1e-4, 0.02, 0.3}) {
      const Soup a = random_soup(random, 61, size, Vec3(0, 0, 0), 1);
      const Soup b = random_soup(random, 67, size, Vec3(0, 0, 0), 1);
      hits += compare_with_scalar(a, b, margin);
      pairs += a.count() * b.count();
      if (HasFailure()) return;
    }
  }
  EXPECT_GT(hits, pairs / 30);
  EXPECT_LT(hits, pairs / 2);
}

TEST(NarrowPhase, HoldsAtEveryScaleAndFarFromTheOrigin) {
  Random random(2);
  for (double scale : {1e-30, 1e-16, 1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e16, 1e30}) {
    for (const Vec3& offset : {Vec3(0, 0, 0), Vec3(1e6, -3e5, 7e5)}) {
      SCOPED_TRACE(scale);
      const Soup a = random_soup(random, 23, 0.3, offset, scale);
      const Soup b = random_soup(random, 29, 0.3, offset, scale);
      compare_with_scalar(a, b, 0.05 * scale);
      compare_with_scalar(a, b, 0);
      if (HasFailure()) return;
    }
  }
}

// Corners on a coarse lattice: triangles that touch, overlap in a plane, share corners and edges,
// have no area or are points, at distances that equal the margin.
TEST(NarrowPhase, HoldsForDegenerateTriangles) {
  Random random(3);
  for (int n : {2, 3, 5}) {
    for (double margin : {0.0, 1.0, std::sqrt(2.0)}) {
      const auto lattice_soup = [&](int count) {
        Soup soup;
        const auto corner = [&] { return Vec3(random.below(n), random.below(n), random.below(n)); };
        for (int t = 0; t < count; ++t) {
          const Vec3 a = corner(), b = corner(), c = corner();
          soup.add(a, b, c);
        }
        return soup;
      };
      EXPECT_GT(compare_with_scalar(lattice_soup(41), lattice_soup(43), margin), 100);
      if (HasFailure()) return;
    }
  }
}

// Thin triangles and near-parallel edges at a small distance.
TEST(NarrowPhase, HoldsForThinTriangles) {
  Random random(4);
  for (double thickness : {1e-1, 1e-3, 1e-5, 1e-8}) {
    Soup a, b;
    const auto add = [&](Soup& soup, double height) {
      const auto corner = [&] {
        return Vec3(random.uniform(), thickness * random.uniform(),
                    height + 0.1 * thickness * random.uniform());
      };
      const Vec3 p = corner(), q = corner(), r = corner();
      soup.add(p, q, r);
    };
    for (int t = 0; t < 40; ++t) {
      add(a, 0);
      add(b, 0.02 * random.uniform());
    }
    SCOPED_TRACE(thickness);
    EXPECT_GT(compare_with_scalar(a, b, 0.01), 100);
    compare_with_scalar(a, b, thickness);
    if (HasFailure()) return;
  }
}

// Distances within a few units in the last place of the margin are decided like all others.
TEST(NarrowPhase, DecidesAtTheMarginItself) {
  Soup a, b;
  a.add(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0));
  const double margin = 0.1;
  std::vector<bool> near;
  for (int step = -40; step <= 40; ++step) {
    const double height = margin + step * 0x1p-57;
    b.add(Vec3(0.2, 0.2, height), Vec3(0.3, 0.2, 1), Vec3(0.2, 0.4, 2));
    near.push_back(height <= margin);
  }
  for (InstructionSet instructions : available_instruction_sets()) {
    use_instruction_set(instructions);
    NarrowPhaseCounters cost;
    const TriangleHits hits = hits_of(a, b, margin, 1, &cost);
    EXPECT_EQ(cost.judged, 81);
    EXPECT_EQ(cost.measured, 81);
    EXPECT_EQ(cost.scalar, 81);
    EXPECT_EQ(hits.pairs.size(), std::count(near.begin(), near.end(), true));
    for (const LeafPair& pair : hits.pairs) EXPECT_TRUE(near[pair.b]);
  }
}

// Margins closer to the distance than float32 can resolve, on both sides: no uncertain verdict may
// be given. Triangles have all shapes, from compact to needles.
TEST(NarrowPhase, NoVerdictBeyondTheRounding) {
  Random random(8);
  std::int64_t settled_in_float = 0, pairs = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    Soup a, b;
    for (Soup* soup : {&a, &b}) {
      const Vec3 stretch(1, std::pow(10.0, -3 * std::abs(random.uniform())),
                         std::pow(10.0, -5 * std::abs(random.uniform())));
      const Vec3 origin = soup == &b ? Vec3(0.5 * random.point()) : Vec3(0, 0, 0);
      const auto corner = [&] { return Vec3(origin + stretch.cwiseProduct(random.point())); };
      const Vec3 p = corner(), q = corner(), r = corner();
      soup->add(p, q, r);
    }
    const double distance = std::sqrt(squared_triangle_distance(a.corners(0), b.corners(0)));
    if (distance == 0) continue;
    for (double relative :
         {-1e-3, -1e-5, -1e-6, -3e-7, -1e-7, -1e-9, 1e-9, 1e-7, 3e-7, 1e-6, 1e-3}) {
      NarrowPhaseCounters cost;
      const TriangleHits hits = hits_of(a, b, distance * (1 + relative), 1, &cost);
      ASSERT_EQ(hits.pairs.size(), relative > 0 ? 1u : 0u) << trial << " " << relative;
      settled_in_float += relative < 0 && cost.measured == 0;
      pairs += relative < 0;
    }
  }
  EXPECT_GT(pairs, 10000);
  EXPECT_GT(settled_in_float, pairs / 4);
}

TEST(NarrowPhase, SameBitsFromEveryInstructionSetAndNumberOfThreads) {
  Random random(5);
  const Soup a = random_soup(random, 101, 0.7, Vec3(0, 0, 0), 1);
  const Soup b = random_soup(random, 103, 0.7, Vec3(0, 0, 0), 1);
  for (double margin : {0.0, 0.05}) {
    use_instruction_set(InstructionSet::portable);
    NarrowPhaseCounters expected_cost;
    const TriangleHits expected = hits_of(a, b, margin, 1, &expected_cost);
    EXPECT_GT(expected.pairs.size(), 300u);
    for (InstructionSet instructions : available_instruction_sets()) {
      use_instruction_set(instructions);
      for (int threads : {1, 2, 3, 8}) {
        NarrowPhaseCounters cost;
        const TriangleHits hits = hits_of(a, b, margin, threads, &cost);
        EXPECT_EQ(hits.pairs, expected.pairs);
        EXPECT_EQ(hits.distances, expected.distances);
        EXPECT_EQ(cost.measured, expected_cost.measured);
        EXPECT_EQ(cost.scalar, expected_cost.scalar);
      }
    }
  }
}

Triangle3 points_of(const Soup& soup, int t) {
  const std::array<Vec3, 3> corner = soup.corners(t);
  Triangle3 triangle;
  for (int i = 0; i < 3; ++i) triangle[i] = {corner[i].x(), corner[i].y(), corner[i].z()};
  return triangle;
}

TEST(NarrowPhase, FindsTheIntersectionsThatThereAre) {
  Random random(7);
  for (bool lattice : {false, true}) {
    const auto soup_of = [&](int count) {
      Soup soup = random_soup(random, count, 0.7, Vec3(0, 0, 0), 1);
      if (!lattice) return soup;
      for (Vec3& p : soup.positions) p = (2 * p).array().round();
      return soup;
    };
    const Soup a = soup_of(61), b = soup_of(67);
    for (int threads : {1, 3}) {
      std::vector<TriangleMeeting> meetings;
      NarrowPhaseCounters cost;
      find_triangle_intersections(a.set(), b.set(), all_pairs(a, b), threads, meetings, cost);
      std::size_t next = 0;
      for (const LeafPair& pair : all_pairs(a, b)) {
        const TriangleIntersection expected =
            intersect_triangles(points_of(a, pair.a), points_of(b, pair.b));
        if (expected.kind == IntersectionKind::none) continue;
        ASSERT_LT(next, meetings.size());
        EXPECT_EQ(meetings[next].pair, pair);
        EXPECT_EQ(meetings[next].intersection.kind, expected.kind);
        EXPECT_EQ(meetings[next].intersection.ends, expected.ends);
        ++next;
      }
      EXPECT_EQ(next, meetings.size());
      EXPECT_GT(next, 50u);
    }
  }
}

// The scalar distance, with which the tests above compare, is that of the nearest points.
TEST(NarrowPhase, ScalarDistanceIsThatOfTheNearestPoints) {
  const std::array<Vec3, 3> flat = {Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 2, 0)};
  const auto moved = [&](const Vec3& by) {
    return std::array<Vec3, 3>{flat[0] + by, flat[1] + by, flat[2] + by};
  };
  EXPECT_EQ(squared_triangle_distance(flat, moved({0, 0, 3})), 9);
  EXPECT_EQ(squared_triangle_distance(flat, moved({5, 0, 0})), 9);
  EXPECT_EQ(squared_triangle_distance(flat, moved({0.5, 0.5, 0})), 0);
  const std::array<Vec3, 3> needle = {Vec3(0.5, 0.5, -1), Vec3(0.5, 0.5, 1), Vec3(9, 9, 1)};
  EXPECT_EQ(squared_triangle_distance(flat, needle), 0);
  Random random(6);
  for (int trial = 0; trial < 200; ++trial) {
    std::array<Vec3, 3> a, b;
    for (int i = 0; i < 3; ++i) {
      a[i] = random.point();
      b[i] = random.point() + Vec3(0, 0, 1);
    }
    double least = INFINITY;
    constexpr int n = 12;
    const auto point = [&](const std::array<Vec3, 3>& t, int i, int j) {
      return Vec3(t[0] + (t[1] - t[0]) * i / n + (t[2] - t[0]) * j / n);
    };
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j)
        for (int k = 0; k <= n; ++k)
          for (int l = 0; k + l <= n; ++l)
            least = std::min(least, (point(a, i, j) - point(b, k, l)).norm());
    const double distance = std::sqrt(squared_triangle_distance(a, b));
    EXPECT_LE(distance, least * (1 + 1e-12));
    EXPECT_GE(distance, least - 0.4);  // two sample cells
  }
}

TEST(NarrowPhase, AppendsAndTakesNoCandidates) {
  Soup a;
  a.add(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0));
  TriangleHits hits;
  NarrowPhaseCounters cost;
  find_triangle_hits(a.set(), a.set(), {}, {0.1, true, 0}, hits, cost);
  EXPECT_TRUE(hits.pairs.empty());
  const std::vector<LeafPair> same = {{0, 0}};
  find_triangle_hits(a.set(), a.set(), same, {0.1, true, 0}, hits, cost);
  find_triangle_hits(a.set(), a.set(), same, {0.1, true, 0}, hits, cost);
  EXPECT_EQ(hits.pairs.size(), 2u);
  EXPECT_EQ(hits.distances, (std::vector<double>{0, 0}));
}

// --- Pairs of leaf blocks ---

struct Image {
  std::string name;
  Surface surface;
};

// Returns images of even and odd sizes, wrapped, of several patches, folded and rough, so that all
// verdicts occur among their pairs.
std::vector<Image> images() {
  std::vector<Image> list;
  list.push_back({"sheet", make_rectangle(1, 1, 20, 23)});
  list.push_back({"strip", make_rectangle(1, 0.1, 3, 91)});
  list.push_back({"torus", make_torus(0.4, 0.1, 18, 11)});
  list.push_back({"sphere", make_sphere(0.4, 7)});
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 0.006);
  for (Image& image : list) {
    for (Vec3& p : image.surface.positions) {
      p = image.name == "strip"
              ? Vec3(0.1 * std::cos(20 * p.x()), p.y(), 0.1 * std::sin(20 * p.x()))
              : Vec3(p.x(), 0.2 * p.y(), 0.05 * std::sin(9 * p.y()) + 0.1 * p.z());
      p += Vec3(noise(random), noise(random), noise(random));
    }
  }
  return list;
}

struct Searched {
  Pyramid pyramid;
  std::vector<std::array<int, 3>> triangles;
  std::vector<LeafBlockPair> blocks;
  std::vector<LeafPair> pairs;
};

Searched search(const Surface& surface, double margin) {
  Searched searched{Pyramid(surface.atlas), build_mesh(surface.atlas).triangles, {}, {}};
  EXPECT_FALSE(searched.pyramid.rebuild(surface.positions));
  TraversalCounters counters;
  self_traversal(searched.pyramid, {.margin = margin}, searched.blocks, counters);
  append_pairs(searched.pyramid, Leaf::triangle, searched.blocks, 1, searched.pairs);
  return searched;
}

// Images at rest near the origin, and so far from it that float32 settles few pairs or none.
TEST(NarrowPhase, PairsOfLeafBlocksHaveTheHitsOfTheirList) {
  const RestoredSettings restored;
  constexpr double margin = 4e-3;
  for (Image& image : images()) {
    std::int64_t measured_before = 0;
    for (const double away : {0.0, 100.0, 3e4}) {
      for (Vec3& p : image.surface.positions) p += Vec3(away, -away, away);
      const Searched searched = search(image.surface, margin);
      const TriangleSet set{image.surface.positions, searched.triangles};
      const PyramidTriangles body{searched.pyramid, set};
      TriangleHits expected;
      NarrowPhaseCounters cost;
      find_triangle_hits(set, set, searched.pairs, {margin, true, 1}, expected, cost);
      EXPECT_GT(expected.pairs.size(), 20U) << image.name;
      EXPECT_GT(searched.pairs.size(), expected.pairs.size() + 20) << image.name;
      for (const InstructionSet kernels : available_instruction_sets()) {
        use_instruction_set(kernels);
        for (const bool distances : {false, true}) {
          TriangleHits hits;
          NarrowPhaseCounters of_blocks;
          find_triangle_hits(body, searched.blocks, {margin, distances, 3}, hits, of_blocks);
          EXPECT_EQ(hits.pairs, expected.pairs) << image.name << ", " << name(kernels);
          EXPECT_EQ(hits.distances, distances ? expected.distances : std::vector<double>{});
          EXPECT_EQ(of_blocks.judged, cost.judged);
          // Farther from the origin, float64 must settle more pairs.
          if (distances) continue;
          EXPECT_GE(of_blocks.measured, measured_before);
          measured_before = of_blocks.measured;
        }
      }
    }
    EXPECT_GT(measured_before, 0) << image.name;
  }
}

TEST(NarrowPhase, TwoBodiesByLeafBlocks) {
  constexpr double margin = 0.01;
  Surface first = make_torus(0.4, 0.15, 21, 14), second = make_rectangle(1, 1, 30, 30);
  for (Vec3& p : second.positions) p -= Vec3(0.5, 0.5, 0.02 * std::sin(20 * p.x()));
  const Searched one = search(first, 0), other = search(second, 0);
  std::vector<LeafBlockPair> blocks;
  TraversalCounters counters;
  dual_traversal(one.pyramid, other.pyramid, {.margin = margin}, blocks, counters);
  std::vector<LeafPair> pairs;
  append_pairs(one.pyramid, other.pyramid, Leaf::triangle, blocks, 1, pairs);
  const PyramidTriangles a{one.pyramid, {first.positions, one.triangles}};
  const PyramidTriangles b{other.pyramid, {second.positions, other.triangles}};
  TriangleHits hits, expected;
  NarrowPhaseCounters cost;
  find_triangle_hits(a, b, blocks, {margin, true, 1}, hits, cost);
  find_triangle_hits(a.triangles, b.triangles, pairs, {margin, true, 1}, expected, cost);
  EXPECT_GT(hits.pairs.size(), 100U);
  EXPECT_EQ(hits.pairs, expected.pairs);
  EXPECT_EQ(hits.distances, expected.distances);
}

}  // namespace
}  // namespace weft::bsi::narrow_phase_test
