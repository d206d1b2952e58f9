#include "bsi/traversal.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <tuple>
#include <utility>

#include "bsi/shapes.h"

namespace weft::bsi {
namespace {

using Positions = std::vector<Vec3>;

struct Body {
  std::string name;
  Surface surface;
  Pyramid pyramid;
};

Body make_body(const std::string& name, Surface surface, double noise, const Vec3& offset,
               RadiusPolicy policy, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, noise);
  for (Vec3& position : surface.positions) {
    position += offset;
    if (noise > 0) position += Vec3(normal(random), normal(random), normal(random));
  }
  Pyramid pyramid(surface.atlas, policy);
  EXPECT_FALSE(pyramid.rebuild(surface.positions));
  return {name, std::move(surface), std::move(pyramid)};
}

// Bodies of every kind around one place: smooth and crumpled, of odd sizes, of one quad, of several
// patches.
std::vector<Body> bodies() {
  std::vector<Body> list;
  const RadiusPolicy fast = RadiusPolicy::fast;
  const RadiusPolicy exact = RadiusPolicy::exact;
  list.push_back(make_body("sheet", make_rectangle(1, 1, 12, 15), 0.05, {0, 0, 0.1}, fast, 1));
  list.push_back(make_body("strip", make_rectangle(2, 0.2, 3, 34), 0.01, {0, 0, 0.12}, exact, 2));
  list.push_back(make_body("quad", make_rectangle(0.7, 0.7, 2, 2), 0, {0, 0.1, 0.15}, fast, 3));
  list.push_back(make_body("torus", make_torus(0.5, 0.2, 17, 9), 0, {0.1, 0, 0}, fast, 4));
  list.push_back(make_body("torus", make_torus(0.5, 0.2, 6, 16), 0.03, {0.1, 0, 0}, exact, 5));
  list.push_back(make_body("sphere", make_sphere(0.4, 6), 0.01, {0, 0, 0}, fast, 6));
  list.push_back(make_body("sphere", make_sphere(0.3, 4), 0.05, {0.2, 0.1, 0}, exact, 7));
  Surface pieces;
  pieces.atlas = Atlas({{2, 9}, {5, 5, true, false}, {3, 3}, {12, 2}, {4, 6, true, true}});
  pieces.positions.resize(pieces.atlas.particle_count(), Vec3::Zero());
  list.push_back(make_body("pieces", std::move(pieces), 0.3, {0, 0, 0}, fast, 8));
  return list;
}

// --- Brute force over the blocks of one quad
// ------------------------------------------------------

// By quad: the blocks that contain it, from the root to its leaf.
std::vector<std::vector<Block>> ancestors_of_quads(const Pyramid& pyramid) {
  std::vector<std::vector<Block>> by_quad(pyramid.atlas().quad_count());
  std::vector<std::vector<Block>> stack{{pyramid.root()}};
  while (!stack.empty()) {
    const std::vector<Block> path = stack.back();
    stack.pop_back();
    if (pyramid.is_leaf(path.back())) {
      by_quad[pyramid.quad_of_leaf(path.back())] = path;
      continue;
    }
    std::array<Block, 4> child;
    const int count = pyramid.children(path.back(), child);
    for (int i = 0; i < count; ++i) {
      stack.push_back(path);
      stack.back().push_back(child[i]);
    }
  }
  return by_quad;
}

double gap(const Sphere& a, const Sphere& b) {
  return (Vec3(a.x, a.y, a.z) - Vec3(b.x, b.y, b.z)).norm() - static_cast<double>(a.radius) -
         static_cast<double>(b.radius);
}

bool within(const Sphere& a, const Sphere& b, double margin) {
  return spheres_within(a, b, static_cast<float>(margin));
}

// The rule of traversal.h for one pair of quads: walks down the paths from the two roots and tells
// if every pair of blocks that it meets is within the margin.
bool is_reached(const Pyramid& first, std::span<const Block> path_a, const Pyramid& second,
                std::span<const Block> path_b, double margin) {
  // A block paired with itself is split into its children without a test.
  if (&first == &second) {
    while (path_a.front() == path_b.front()) {
      if (path_a.size() == 1) return true;
      path_a = path_a.subspan(1);
      path_b = path_b.subspan(1);
    }
    const auto order = [](const Block& block) { return std::tuple(block.patch, block.v, block.u); };
    if (order(path_b.front()) < order(path_a.front())) std::swap(path_a, path_b);
  }
  for (;;) {
    const Sphere& a = first.sphere(path_a.front());
    const Sphere& b = second.sphere(path_b.front());
    if (!within(a, b, margin)) return false;
    if (path_a.size() == 1 && path_b.size() == 1) return true;
    if (path_b.size() == 1 || (path_a.size() > 1 && a.radius >= b.radius)) {
      path_a = path_a.subspan(1);
    } else {
      path_b = path_b.subspan(1);
    }
  }
}

// True if some blocks around the two quads are farther apart than the margin.
bool is_separated(const Pyramid& first, const std::vector<Block>& path_a, const Pyramid& second,
                  const std::vector<Block>& path_b, double margin) {
  return std::ranges::any_of(path_a, [&](const Block& a) {
    return std::ranges::any_of(
        path_b, [&](const Block& b) { return gap(first.sphere(a), second.sphere(b)) > margin; });
  });
}

// Checks a pair set, sorted here, against all pairs of quads one by one. `tested` tells which pairs
// of quads are to be looked at.
void expect_pairs(const Pyramid& first, const Pyramid& second, double margin,
                  std::vector<QuadPair> pairs, const std::function<bool(int, int)>& tested) {
  std::ranges::sort(pairs);
  EXPECT_EQ(std::ranges::adjacent_find(pairs), pairs.end()) << "a pair was found twice";
  const auto paths_a = ancestors_of_quads(first);
  const auto paths_b = ancestors_of_quads(second);
  std::vector<QuadPair> expected;
  for (int a = 0; a < first.atlas().quad_count(); ++a) {
    for (int b = 0; b < second.atlas().quad_count(); ++b) {
      if (!tested(a, b)) continue;
      const bool reached = is_reached(first, paths_a[a], second, paths_b[b], margin);
      if (reached) expected.push_back({a, b});
      // The rule of the descent loses no pair that the spheres of the quads, and of the blocks
      // around them, cannot prove apart; and finds none whose spheres are apart.
      const bool near =
          within(first.sphere(paths_a[a].back()), second.sphere(paths_b[b].back()), margin);
      EXPECT_LE(reached, near);
      if (near && !reached) {
        EXPECT_TRUE(is_separated(first, paths_a[a], second, paths_b[b], margin));
      }
    }
  }
  EXPECT_EQ(pairs, expected);
}

TEST(Traversal, DualFindsThePairsOfItsRule) {
  const std::vector<Body> list = bodies();
  constexpr std::array margins{0.0, 0.01, 0.3};
  std::size_t found = 0;
  std::size_t turn = 0;
  for (const Body& first : list) {
    for (const Body& second : list) {
      if (&first == &second) continue;
      const double margin = margins[turn++ % margins.size()];
      SCOPED_TRACE(first.name + " and " + second.name + ", margin " + std::to_string(margin));
      std::vector<QuadPair> pairs;
      TraversalCounters counters;
      dual_traversal(first.pyramid, second.pyramid, margin, pairs, counters);
      expect_pairs(first.pyramid, second.pyramid, margin, pairs, [](int, int) { return true; });
      EXPECT_GE(counters.sphere_tests, static_cast<std::int64_t>(pairs.size()));
      found += pairs.size();
    }
  }
  EXPECT_GT(found, 10000U);
}

TEST(Traversal, SelfFindsThePairsOfItsRule) {
  for (const Body& body : bodies()) {
    for (const double margin : {0.0, 0.02, 0.3}) {
      SCOPED_TRACE(body.name + ", margin " + std::to_string(margin));
      std::vector<QuadPair> pairs;
      TraversalCounters counters;
      self_traversal(body.pyramid, margin, pairs, counters);
      expect_pairs(body.pyramid, body.pyramid, margin, pairs, [](int a, int b) { return a <= b; });
    }
  }
}

// --- Brute force over triangles
// -------------------------------------------------------------------

using Triangle = std::array<Vec3, 3>;

Vec3 closest_on_segment(const Vec3& point, const Vec3& from, const Vec3& to) {
  const Vec3 along = to - from;
  const double squared = along.squaredNorm();
  const double t = squared > 0 ? std::clamp((point - from).dot(along) / squared, 0.0, 1.0) : 0.0;
  return from + t * along;
}

double point_triangle(const Vec3& point, const Triangle& triangle) {
  const auto& [a, b, c] = triangle;
  double distance = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const Vec3 on_edge = closest_on_segment(point, triangle[i], triangle[(i + 1) % 3]);
    distance = std::min(distance, (point - on_edge).norm());
  }
  const Vec3 normal = (b - a).cross(c - a);
  const bool inside = normal.dot((b - a).cross(point - a)) > 0 &&
                      normal.dot((c - b).cross(point - b)) > 0 &&
                      normal.dot((a - c).cross(point - c)) > 0;
  return inside ? std::min(distance, std::abs(normal.normalized().dot(point - a))) : distance;
}

// Between lines where both closest points are inside; ends are left to their own closest points.
double segment_segment(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  double distance = std::min(
      {(a - closest_on_segment(a, c, d)).norm(), (b - closest_on_segment(b, c, d)).norm(),
       (c - closest_on_segment(c, a, b)).norm(), (d - closest_on_segment(d, a, b)).norm()});
  const Vec3 u = b - a;
  const Vec3 v = d - c;
  const double determinant = u.squaredNorm() * v.squaredNorm() - u.dot(v) * u.dot(v);
  if (determinant <= 1e-14 * u.squaredNorm() * v.squaredNorm()) return distance;
  const Vec3 w = a - c;
  const double s = (u.dot(v) * v.dot(w) - v.squaredNorm() * u.dot(w)) / determinant;
  const double t = (u.squaredNorm() * v.dot(w) - u.dot(v) * u.dot(w)) / determinant;
  if (s >= 0 && s <= 1 && t >= 0 && t <= 1)
    distance = std::min(distance, (w + s * u - t * v).norm());
  return distance;
}

// Where a segment runs through a triangle their distance is zero: that of the crossing point.
double segment_triangle_crossing(const Vec3& from, const Vec3& to, const Triangle& triangle) {
  const Vec3 normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
  const double before = normal.dot(from - triangle[0]);
  const double after = normal.dot(to - triangle[0]);
  if (before * after >= 0) return std::numeric_limits<double>::infinity();
  return point_triangle(from + before / (before - after) * (to - from), triangle);
}

double triangle_triangle(const Triangle& first, const Triangle& second) {
  double distance = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const Vec3& a = first[i];
    const Vec3& b = first[(i + 1) % 3];
    const Vec3& c = second[i];
    const Vec3& d = second[(i + 1) % 3];
    distance =
        std::min({distance, point_triangle(a, second), point_triangle(c, first),
                  segment_triangle_crossing(a, b, second), segment_triangle_crossing(c, d, first)});
    for (int j = 0; j < 3; ++j) {
      distance = std::min(distance, segment_segment(a, b, second[j], second[(j + 1) % 3]));
    }
  }
  return distance;
}

std::array<Triangle, 2> triangles_of(const Surface& surface, int quad) {
  const auto indices = quad_triangles(surface.atlas.quad_particles(quad));
  std::array<Triangle, 2> triangles;
  for (int t = 0; t < 2; ++t) {
    for (int corner = 0; corner < 3; ++corner) {
      triangles[t][corner] = surface.positions[indices[t][corner]];
    }
  }
  return triangles;
}

double quad_distance(const Surface& first, int a, const Surface& second, int b) {
  double distance = std::numeric_limits<double>::infinity();
  for (const Triangle& one : triangles_of(first, a)) {
    for (const Triangle& other : triangles_of(second, b)) {
      distance = std::min(distance, triangle_triangle(one, other));
    }
  }
  return distance;
}

// Low and high corner.
using Box = std::array<std::array<double, 3>, 2>;

std::vector<Box> boxes_of_quads(const Surface& surface) {
  std::vector<Box> boxes(surface.atlas.quad_count());
  for (int quad = 0; quad < surface.atlas.quad_count(); ++quad) {
    auto& [low, high] = boxes[quad];
    low.fill(std::numeric_limits<double>::infinity());
    high.fill(-std::numeric_limits<double>::infinity());
    for (const int particle : surface.atlas.quad_particles(quad)) {
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], surface.positions[particle][axis]);
        high[axis] = std::max(high[axis], surface.positions[particle][axis]);
      }
    }
  }
  return boxes;
}

bool are_apart(const Box& a, const Box& b, double margin) {
  for (int axis = 0; axis < 3; ++axis) {
    if (a[0][axis] > b[1][axis] + margin || b[0][axis] > a[1][axis] + margin) return true;
  }
  return false;
}

// All pairs of quads whose triangles come within the margin. Boxes keep the test short.
std::vector<QuadPair> near_quads(const Surface& first, const Surface& second, double margin) {
  const auto boxes_a = boxes_of_quads(first);
  const auto boxes_b = boxes_of_quads(second);
  std::vector<QuadPair> near;
  for (int a = 0; a < first.atlas.quad_count(); ++a) {
    for (int b = 0; b < second.atlas.quad_count(); ++b) {
      if (are_apart(boxes_a[a], boxes_b[b], margin)) continue;
      if (quad_distance(first, a, second, b) <= margin) near.push_back({a, b});
    }
  }
  return near;
}

TEST(Traversal, DualMissesNoTriangles) {
  const std::vector<Body> list = bodies();
  const double margin = 0.02;
  std::size_t count = 0;
  // Every second pair of bodies: enough of each kind, and short without optimisation.
  for (std::size_t i = 0; i < list.size(); ++i) {
    for (std::size_t j = i + 1; j < list.size(); j += 2) {
      const Body& first = list[i];
      const Body& second = list[j];
      std::vector<QuadPair> pairs;
      TraversalCounters counters;
      dual_traversal(first.pyramid, second.pyramid, margin, pairs, counters);
      std::ranges::sort(pairs);
      const std::vector<QuadPair> near = near_quads(first.surface, second.surface, margin);
      EXPECT_TRUE(std::ranges::includes(pairs, near)) << first.name << " and " << second.name;
      count += near.size();
    }
  }
  EXPECT_GT(count, 1000U);
}

TEST(Traversal, SelfMissesNoTriangles) {
  const double margin = 0.02;
  for (const Body& body : bodies()) {
    std::vector<QuadPair> pairs;
    TraversalCounters counters;
    self_traversal(body.pyramid, margin, pairs, counters);
    std::ranges::sort(pairs);
    std::vector<QuadPair> near = near_quads(body.surface, body.surface, margin);
    std::erase_if(near, [](const QuadPair& pair) { return pair.a > pair.b; });
    EXPECT_TRUE(std::ranges::includes(pairs, near)) << body.name;
    EXPECT_GE(near.size(), static_cast<std::size_t>(body.surface.atlas.quad_count()));
  }
}

TEST(Traversal, SingleFindsTheQuadsNearABall) {
  std::mt19937 random(21);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const Body& body : bodies()) {
    const auto paths = ancestors_of_quads(body.pyramid);
    for (int sample = 0; sample < 30; ++sample) {
      const Vec3 centre(uniform(random), uniform(random), 0.3 * uniform(random));
      const double radius = sample % 3 == 0 ? 0 : 0.2 * std::abs(uniform(random));
      const double margin = sample % 2 == 0 ? 0 : 0.05;
      std::vector<int> quads;
      TraversalCounters counters;
      single_traversal(body.pyramid, centre, radius, margin, quads, counters);
      std::ranges::sort(quads);
      EXPECT_EQ(std::ranges::adjacent_find(quads), quads.end());
      for (int quad = 0; quad < body.surface.atlas.quad_count(); ++quad) {
        double distance = std::numeric_limits<double>::infinity();
        for (const Triangle& triangle : triangles_of(body.surface, quad)) {
          distance = std::min(distance, point_triangle(centre, triangle));
        }
        // Found if near; not found if a sphere around it is apart by more than rounding.
        const bool found = std::ranges::binary_search(quads, quad);
        const bool apart = std::ranges::any_of(paths[quad], [&](const Block& block) {
          const Sphere& sphere = body.pyramid.sphere(block);
          return (Vec3(sphere.x, sphere.y, sphere.z) - centre).norm() - radius -
                     static_cast<double>(sphere.radius) >
                 margin + 1e-5;
        });
        if (distance <= radius + margin) {
          EXPECT_TRUE(found) << body.name;
        }
        if (apart) {
          EXPECT_FALSE(found) << body.name;
        }
        if (!found) {
          const Sphere& leaf = body.pyramid.sphere(paths[quad].back());
          const bool near = (Vec3(leaf.x, leaf.y, leaf.z) - centre).norm() <=
                            radius + margin + static_cast<double>(leaf.radius);
          if (near) {
            EXPECT_GT(distance, radius + margin);
          }
        }
      }
    }
  }
}

// --- Rounding and extremes
// ------------------------------------------------------------------------

TEST(Traversal, SphereTestIsConservativeInFloat32) {
  std::mt19937 random(22);
  std::uniform_real_distribution<float> uniform(-1, 1);
  int touching = 0;
  for (int i = 0; i < 20000; ++i) {
    const float scale = std::pow(10.0F, 16 * uniform(random));
    const Sphere a{scale * uniform(random), scale * uniform(random), scale * uniform(random),
                   std::max(scale * std::abs(uniform(random)), 1e-18F)};
    Sphere b{scale * uniform(random), scale * uniform(random), scale * uniform(random), 1e-18F};
    const double centres = gap({a.x, a.y, a.z, 0}, {b.x, b.y, b.z, 0});
    // Radius and margin that just make the two touch, or just not.
    const auto margin = static_cast<float>(std::max(0.0, (centres - a.radius) * 0.5));
    const double rest = centres - static_cast<double>(a.radius) - static_cast<double>(margin);
    b.radius = std::max(static_cast<float>(rest), 1e-18F);
    if (i % 2 == 0) b.radius = std::nextafter(b.radius, 0.0F);
    if (gap(a, b) <= static_cast<double>(margin)) {
      ++touching;
      EXPECT_TRUE(spheres_within(a, b, margin));
    }
    if (gap(a, b) > static_cast<double>(margin) + 3e-6 * centres) {
      EXPECT_FALSE(spheres_within(a, b, margin));
    }
  }
  EXPECT_GT(touching, 5000);
}

TEST(Traversal, FindsContactsAtEveryScale) {
  const Surface sheet = make_rectangle(1, 1, 5, 6);
  for (const double size : {1e16, 1e6, 1.0, 1e-6, 1e-12, 1e-25, 0.0}) {
    for (const double offset : {0.0, 1.0, 1e6}) {
      Positions lower;
      Positions upper;
      for (const Vec3& point : sheet.positions) {
        lower.emplace_back(size * point + Vec3(offset, offset, offset));
        upper.emplace_back(size * (point + Vec3(0, 0, 0.01)) + Vec3(offset, offset, offset));
      }
      Pyramid first(sheet.atlas);
      Pyramid second(sheet.atlas, RadiusPolicy::exact);
      ASSERT_FALSE(first.rebuild(lower));
      ASSERT_FALSE(second.rebuild(upper));
      std::vector<QuadPair> pairs;
      TraversalCounters counters;
      dual_traversal(first, second, 0.01 * size, pairs, counters);
      for (int quad = 0; quad < sheet.atlas.quad_count(); ++quad) {
        EXPECT_NE(std::ranges::find(pairs, QuadPair{quad, quad}), pairs.end());
      }
      std::vector<int> quads;
      single_traversal(first, upper[0], 0, 0.01 * size, quads, counters);
      EXPECT_NE(std::ranges::find(quads, 0), quads.end());
    }
  }
}

TEST(Traversal, BodiesFarApartCostOneTest) {
  const std::vector<Body> list = bodies();
  const Body far = make_body("far", make_sphere(1.0, 5), 0, {10, 0, 0}, RadiusPolicy::fast, 31);
  std::vector<QuadPair> pairs;
  TraversalCounters counters;
  dual_traversal(list[0].pyramid, far.pyramid, 0.1, pairs, counters);
  EXPECT_TRUE(pairs.empty());
  EXPECT_EQ(counters.sphere_tests, 1);
}

TEST(Traversal, AppendsInTheSameOrderEveryTime) {
  const std::vector<Body> list = bodies();
  std::vector<QuadPair> twice;
  TraversalCounters counters;
  dual_traversal(list[0].pyramid, list[3].pyramid, 0.05, twice, counters);
  const std::vector<QuadPair> once = twice;
  ASSERT_FALSE(once.empty());
  dual_traversal(list[0].pyramid, list[3].pyramid, 0.05, twice, counters);
  ASSERT_EQ(twice.size(), 2 * once.size());
  EXPECT_TRUE(std::equal(once.begin(), once.end(), twice.begin() + once.size()));
}

TEST(Traversal, TestsGrowWithTheContactNotWithTheBodies) {
  // Two parallel sheets of n x n quads of width h, 0.1 h apart: spheres of radius h / sqrt(2) meet
  // those of the quad opposite and of its neighbours at h, but not those at sqrt(2) h.
  for (const int n : {16, 64}) {
    Surface sheet = make_rectangle(1, 1, n + 1, n + 1);
    Pyramid lower(sheet.atlas);
    ASSERT_FALSE(lower.rebuild(sheet.positions));
    for (Vec3& position : sheet.positions) position.z() += 0.1 / n;
    Pyramid upper(sheet.atlas);
    ASSERT_FALSE(upper.rebuild(sheet.positions));
    std::vector<QuadPair> pairs;
    TraversalCounters counters;
    dual_traversal(lower, upper, 0.0, pairs, counters);
    EXPECT_EQ(pairs.size(), static_cast<std::size_t>(5 * n * n - 4 * n));
    EXPECT_LE(counters.sphere_tests, 60 * n * n);
  }
}

}  // namespace
}  // namespace weft::bsi
