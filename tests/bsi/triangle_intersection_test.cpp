#include "bsi/triangle_intersection.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <random>
#include <set>

#include "bsi/proximity.h"

namespace weft::bsi::triangle_intersection_test {
namespace {

__extension__ typedef __int128 Wide;

// An oracle without rounding: the first triangle is clipped by the planes that bound the second.
// Points are x, y, z over a common denominator w > 0.

using Rational3 = std::array<Wide, 4>;
using Lattice = std::array<std::int64_t, 3>;
using LatticeTriangle = std::array<Lattice, 3>;

Wide greatest_divisor(Wide a, Wide b) {
  if (a < 0) a = -a;
  if (b < 0) b = -b;
  while (b != 0) {
    const Wide rest = a % b;
    a = b;
    b = rest;
  }
  return a;
}

Rational3 reduced(Rational3 p) {
  Wide divisor = p[3];
  for (int i = 0; i < 3; ++i) divisor = greatest_divisor(divisor, p[i]);
  for (Wide& x : p) x /= divisor;
  return p;
}

Lattice minus(const Lattice& a, const Lattice& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

Lattice cross(const Lattice& a, const Lattice& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// normal . (p - on_plane), times the denominator of p.
Wide height(const Lattice& normal, const Lattice& on_plane, const Rational3& p) {
  Wide sum = 0;
  for (int i = 0; i < 3; ++i) sum += normal[i] * (p[i] - on_plane[i] * p[3]);
  return sum;
}

// Clips a polygon to the part without negative height.
std::vector<Rational3> clipped(const std::vector<Rational3>& polygon, const Lattice& normal,
                               const Lattice& on_plane) {
  std::vector<Rational3> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Rational3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const Wide from = height(normal, on_plane, p), to = height(normal, on_plane, q);
    if (from >= 0) kept.push_back(p);
    if ((from < 0 && to > 0) || (from > 0 && to < 0)) {
      // The heights are from / p[3] and to / q[3]; the point weights p and q crosswise by them.
      const Wide weight_p = to * p[3], weight_q = -from * q[3];
      const Wide sign = weight_p + weight_q < 0 ? -1 : 1;
      Rational3 x;
      for (int k = 0; k < 3; ++k) x[k] = sign * (weight_p * p[k] * q[3] + weight_q * q[k] * p[3]);
      x[3] = sign * (weight_p + weight_q) * p[3] * q[3];
      kept.push_back(reduced(x));
    }
  }
  return kept;
}

// The corners of the intersection; `b` has an area.
std::set<Rational3> exact_intersection(const LatticeTriangle& a, const LatticeTriangle& b) {
  std::vector<Rational3> polygon;
  for (const Lattice& p : a) polygon.push_back({p[0], p[1], p[2], 1});
  const Lattice normal = cross(minus(b[1], b[0]), minus(b[2], b[0]));
  polygon = clipped(polygon, normal, b[0]);
  polygon = clipped(polygon, minus({0, 0, 0}, normal), b[0]);
  for (int i = 0; i < 3; ++i)
    polygon = clipped(polygon, cross(normal, minus(b[(i + 1) % 3], b[i])), b[i]);
  return {polygon.begin(), polygon.end()};
}

Vec3 to_vector(const Rational3& p) {
  const auto w = static_cast<double>(p[3]);
  return {static_cast<double>(p[0]) / w, static_cast<double>(p[1]) / w,
          static_cast<double>(p[2]) / w};
}

Vec3 to_vector(const Point3& p) { return {p[0], p[1], p[2]}; }

bool on_one_line(const std::set<Rational3>& points) {
  const Vec3 first = to_vector(*points.begin());
  Vec3 farthest = Vec3::Zero();
  for (const Rational3& p : points)
    if ((to_vector(p) - first).norm() > farthest.norm()) farthest = to_vector(p) - first;
  return std::all_of(points.begin(), points.end(), [&](const Rational3& p) {
    return farthest.cross(to_vector(p) - first).norm() < 1e-9;
  });
}

IntersectionKind kind_of(const std::set<Rational3>& points) {
  if (points.empty()) return IntersectionKind::none;
  if (points.size() == 1) return IntersectionKind::point;
  return on_one_line(points) ? IntersectionKind::edge : IntersectionKind::surface;
}

Triangle3 to_triangle(const LatticeTriangle& t) {
  Triangle3 triangle;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) triangle[i][k] = static_cast<double>(t[i][k]);
  return triangle;
}

// Checks that the ends are those of the exact segment, in either order.
void expect_ends(const TriangleIntersection& found, const std::set<Rational3>& exact) {
  const Vec3 first = to_vector(found.ends[0]), second = to_vector(found.ends[1]);
  for (const Vec3& end : {first, second}) {
    double nearest = INFINITY;
    for (const Rational3& p : exact) nearest = std::min(nearest, (to_vector(p) - end).norm());
    EXPECT_LT(nearest, 1e-13);
  }
  double longest = 0;
  for (const Rational3& p : exact)
    for (const Rational3& q : exact)
      longest = std::max(longest, (to_vector(p) - to_vector(q)).norm());
  EXPECT_NEAR((first - second).norm(), longest, 1e-13);
}

TEST(TriangleIntersection, AgreesWithExactClipping) {
  std::mt19937 random(11);
  std::array<int, 4> seen{};
  for (int trial = 0; trial < 60000; ++trial) {
    std::uniform_int_distribution<int> coordinate(0, trial % 3 + 2);
    std::uniform_int_distribution<int> height_of(0, trial % 4 == 0 ? 0 : trial % 3 + 2);
    const auto triangle = [&] {
      LatticeTriangle t;
      for (Lattice& p : t) p = {coordinate(random), coordinate(random), height_of(random)};
      return t;
    };
    const LatticeTriangle a = triangle(), b = triangle();
    if (cross(minus(b[1], b[0]), minus(b[2], b[0])) == Lattice{0, 0, 0}) continue;
    const std::set<Rational3> exact = exact_intersection(a, b);
    const IntersectionKind kind = kind_of(exact);
    ++seen[static_cast<int>(kind)];
    for (bool swapped : {false, true}) {
      const Triangle3 first = to_triangle(swapped ? b : a), second = to_triangle(swapped ? a : b);
      const TriangleIntersection found = intersect_triangles(first, second);
      ASSERT_EQ(found.kind, kind) << trial;
      EXPECT_EQ(triangles_meet(first, second), kind != IntersectionKind::none);
      if (kind == IntersectionKind::point || kind == IntersectionKind::edge)
        expect_ends(found, exact);
      if (HasFailure()) return;
    }
  }
  for (int count : seen) EXPECT_GT(count, 1000);
}

// Two triangles without area are segments or points.
TEST(TriangleIntersection, TrianglesWithoutArea) {
  const Triangle3 along = {{{0, 0, 0}, {4, 0, 0}, {2, 0, 0}}};
  const auto kind = [&](const Triangle3& other) {
    const IntersectionKind found = intersect_triangles(along, other).kind;
    EXPECT_EQ(triangles_meet(along, other), found != IntersectionKind::none);
    EXPECT_EQ(triangles_meet(other, along), found != IntersectionKind::none);
    return found;
  };
  EXPECT_EQ(kind({{{1, 0, 0}, {9, 0, 0}, {3, 0, 0}}}), IntersectionKind::edge);
  EXPECT_EQ(kind({{{4, 0, 0}, {9, 0, 0}, {5, 0, 0}}}), IntersectionKind::point);
  EXPECT_EQ(kind({{{5, 0, 0}, {9, 0, 0}, {6, 0, 0}}}), IntersectionKind::none);
  EXPECT_EQ(kind({{{1, 1, 0}, {1, -1, 0}, {1, -1, 0}}}), IntersectionKind::point);
  EXPECT_EQ(kind({{{1, 1, 1}, {1, -1, 1}, {1, -1, 1}}}), IntersectionKind::none);
  EXPECT_EQ(kind({{{0, 0, 0}, {0, 4, 0}, {0, 2, 0}}}), IntersectionKind::point);
  EXPECT_EQ(kind({{{3, 0, 0}, {3, 0, 0}, {3, 0, 0}}}), IntersectionKind::point);
  EXPECT_EQ(kind({{{3, 1, 0}, {3, 1, 0}, {3, 1, 0}}}), IntersectionKind::none);
}

// For neighbours in a mesh, shared corners are ends to the bit.
TEST(TriangleIntersection, NeighboursShareWhatTheyShare) {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto point = [&] { return Point3{uniform(random), uniform(random), uniform(random)}; };
  for (int trial = 0; trial < 1000; ++trial) {
    const Point3 p = point(), q = point(), r = point(), s = point();
    const TriangleIntersection edge = intersect_triangles({p, q, r}, {q, p, s});
    EXPECT_EQ(edge.kind, IntersectionKind::edge);
    EXPECT_TRUE(edge.ends == (std::array{p, q}) || edge.ends == (std::array{q, p}));
    const TriangleIntersection same = intersect_triangles({p, q, r}, {r, p, q});
    EXPECT_EQ(same.kind, IntersectionKind::surface);
    const Point3 t = {p[0] + 3, p[1] + 1, p[2]}, u = {p[0] + 3, p[1] - 1, p[2] + 0.5};
    const Point3 v = {p[0] - 3, p[1], p[2] + 1}, w = {p[0] - 3, p[1] + 1, p[2] - 1};
    const TriangleIntersection corner = intersect_triangles({p, t, u}, {v, p, w});
    EXPECT_EQ(corner.kind, IntersectionKind::point);
    EXPECT_EQ(corner.ends, (std::array{p, p}));
  }
}

// Random triangles, far from any degeneracy: the ends lie in both triangles, on an edge of one.
TEST(TriangleIntersection, EndsLieInBothTriangles) {
  std::mt19937 random(13);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int edges = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    Triangle3 a, b;
    for (int i = 0; i < 3; ++i) {
      a[i] = {1e3 + uniform(random), uniform(random), uniform(random)};
      b[i] = {1e3 + uniform(random), uniform(random), uniform(random)};
    }
    const TriangleIntersection found = intersect_triangles(a, b);
    ASSERT_EQ(found.kind != IntersectionKind::none, triangles_meet(a, b));
    if (found.kind == IntersectionKind::none) continue;
    ASSERT_EQ(found.kind, IntersectionKind::edge);
    ++edges;
    for (const Point3& end : found.ends) {
      for (const Triangle3& t : {a, b}) {
        const Closest closest = closest_vertex_triangle(to_vector(end), to_vector(t[0]),
                                                        to_vector(t[1]), to_vector(t[2]));
        EXPECT_LT(closest.squared_distance, 1e-18) << trial;
      }
    }
  }
  EXPECT_GT(edges, 1000);
}

}  // namespace
}  // namespace weft::bsi::triangle_intersection_test
