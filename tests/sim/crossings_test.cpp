#include "sim/view/crossings.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <set>

#include "bsi/detail/exact_predicates.h"
#include "bsi/triangle_intersection.h"

namespace weft::sim::crossings_test {
namespace {

using bsi::orientation;
using bsi::Point2;
using bsi::Point3;
using bsi::Triangle3;
using bsi::triangles_meet;
using bsi::triangles_meet_beyond_corner;
using bsi::Vec3;
__extension__ typedef __int128 Wide;
using Lattice = std::array<std::int64_t, 3>;

struct Surface {
  std::vector<Vec3> positions;
  std::vector<std::array<int, 3>> triangles;
  bool check_self = true;

  operator CrossingSurface() const { return {positions, triangles, check_self}; }
};

std::vector<Crossing> crossings_of(const std::vector<Surface>& surfaces) {
  const std::vector<CrossingSurface> views(surfaces.begin(), surfaces.end());
  return find_crossings(views);
}

Surface triangle(const Vec3& a, const Vec3& b, const Vec3& c) { return {{a, b, c}, {{0, 1, 2}}}; }

bool cross(const Surface& a, const Surface& b) { return !crossings_of({a, b}).empty(); }

// An oracle that shares nothing with the code, in integers. Two convex hulls of lattice points have
// a point in common if the origin is in the hull of their differences. By Caratheodory it is then
// in the hull of at most four of them.

Wide determinant(const Lattice& a, const Lattice& b, const Lattice& c) {
  return Wide(a[0]) * (Wide(b[1]) * c[2] - Wide(b[2]) * c[1]) +
         Wide(a[1]) * (Wide(b[2]) * c[0] - Wide(b[0]) * c[2]) +
         Wide(a[2]) * (Wide(b[0]) * c[1] - Wide(b[1]) * c[0]);
}

std::array<Wide, 3> cross_product(const Lattice& a, const Lattice& b) {
  return {Wide(a[1]) * b[2] - Wide(a[2]) * b[1], Wide(a[2]) * b[0] - Wide(a[0]) * b[2],
          Wide(a[0]) * b[1] - Wide(a[1]) * b[0]};
}

Lattice minus(const Lattice& a, const Lattice& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

bool origin_in_hull(const Lattice& a) { return a == Lattice{0, 0, 0}; }

bool origin_in_hull(const Lattice& a, const Lattice& b) {
  const std::array<Wide, 3> area = cross_product(a, b);
  const Wide dot = Wide(a[0]) * b[0] + Wide(a[1]) * b[1] + Wide(a[2]) * b[2];
  return area[0] == 0 && area[1] == 0 && area[2] == 0 && dot <= 0;
}

bool origin_in_hull(const Lattice& a, const Lattice& b, const Lattice& c) {
  if (determinant(a, b, c) != 0) return false;
  const std::array<Wide, 3> normal = cross_product(minus(b, a), minus(c, a));
  if (normal[0] == 0 && normal[1] == 0 && normal[2] == 0) return false;  // smaller subsets decide
  for (const auto& part : {cross_product(a, b), cross_product(b, c), cross_product(c, a)})
    if (part[0] * normal[0] + part[1] * normal[1] + part[2] * normal[2] < 0) return false;
  return true;
}

bool origin_in_hull(const Lattice& a, const Lattice& b, const Lattice& c, const Lattice& d) {
  const Wide whole = determinant(minus(b, a), minus(c, a), minus(d, a));
  if (whole == 0) return false;
  const int sign = whole > 0 ? 1 : -1;
  return sign * determinant(b, c, d) >= 0 && sign * determinant(a, d, c) >= 0 &&
         sign * determinant(a, b, d) >= 0 && sign * determinant(a, c, b) >= 0;
}

bool hulls_meet(const std::vector<Lattice>& first, const std::vector<Lattice>& second) {
  std::vector<Lattice> p;
  for (const Lattice& a : first)
    for (const Lattice& b : second) p.push_back(minus(a, b));
  const std::size_t n = p.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (origin_in_hull(p[i])) return true;
    for (std::size_t j = 0; j < i; ++j) {
      if (origin_in_hull(p[i], p[j])) return true;
      for (std::size_t k = 0; k < j; ++k) {
        if (origin_in_hull(p[i], p[j], p[k])) return true;
        for (std::size_t l = 0; l < k; ++l)
          if (origin_in_hull(p[i], p[j], p[k], p[l])) return true;
      }
    }
  }
  return false;
}

Point3 to_point(const Lattice& a, double unit) {
  return {unit * static_cast<double>(a[0]), unit * static_cast<double>(a[1]),
          unit * static_cast<double>(a[2])};
}

Triangle3 to_triangle(const std::vector<Lattice>& corners, double unit) {
  return {to_point(corners[0], unit), to_point(corners[1], unit), to_point(corners[2], unit)};
}

// Returns random lattice points. They have either few values, so that every kind of touching and
// degeneracy is common, or values up to 2^20 almost on a common plane, where only exact arithmetic
// can decide.
std::vector<Lattice> random_corners(std::mt19937& random, std::int64_t size, int flatness) {
  std::uniform_int_distribution<std::int64_t> uniform(-size, size), tiny(-1, 1);
  std::vector<Lattice> corners(3);
  for (Lattice& corner : corners) {
    for (auto& coordinate : corner) coordinate = uniform(random);
    if (flatness == 1) corner[2] = corner[0] + corner[1] + tiny(random);
  }
  return corners;
}

TEST(Crossings, TrianglesAgreeWithIntegerArithmetic) {
  std::mt19937 random(1);
  int meeting = 0, apart = 0;
  for (int trial = 0; trial < 30000; ++trial) {
    const std::int64_t size = std::array<std::int64_t, 4>{1, 2, 4, 1 << 20}[trial % 4];
    const int flatness = (trial / 4) % 2;
    const auto a = random_corners(random, size, flatness);
    const auto b = random_corners(random, size, flatness);
    const double unit = std::ldexp(1.0, trial % 41 - 20);
    const bool truth = hulls_meet(a, b);
    ASSERT_EQ(triangles_meet(to_triangle(a, unit), to_triangle(b, unit)), truth) << trial;
    ASSERT_EQ(triangles_meet(to_triangle(b, unit), to_triangle(a, unit)), truth) << trial;
    ++(truth ? meeting : apart);
  }
  EXPECT_GT(meeting, 5000);
  EXPECT_GT(apart, 5000);
}

TEST(Crossings, TrianglesThatShareACornerAgreeWithIntegerArithmetic) {
  std::mt19937 random(2);
  int meeting = 0, apart = 0;
  for (int trial = 0; trial < 30000; ++trial) {
    const std::int64_t size = std::array<std::int64_t, 4>{1, 2, 4, 1 << 20}[trial % 4];
    const auto a = random_corners(random, size, (trial / 4) % 2);
    auto b = random_corners(random, size, (trial / 4) % 2);
    b[0] = a[0];
    const bool truth = hulls_meet({a[1], a[2]}, b) || hulls_meet(a, {b[1], b[2]});
    ASSERT_EQ(triangles_meet_beyond_corner(to_triangle(a, 1), to_triangle(b, 1)), truth) << trial;
    ++(truth ? meeting : apart);
  }
  EXPECT_GT(meeting, 3000);
  EXPECT_GT(apart, 3000);
}

TEST(Crossings, PredicatesAreExact) {
  std::mt19937 random(3);
  std::uniform_int_distribution<std::int64_t> uniform(-(1 << 24), 1 << 24), tiny(-2, 2);
  std::array<int, 3> seen{};
  for (int trial = 0; trial < 20000; ++trial) {
    std::array<Lattice, 4> x;
    for (Lattice& point : x)
      for (auto& coordinate : point) coordinate = uniform(random);
    // The points are almost on one plane: d = a + b - c and a nudge.
    for (int axis = 0; axis < 3; ++axis)
      x[3][axis] = x[0][axis] + x[1][axis] - x[2][axis] + (trial % 4 == 0 ? 0 : tiny(random));
    const Wide truth = determinant(minus(x[0], x[3]), minus(x[1], x[3]), minus(x[2], x[3]));
    const int sign = (truth > 0) - (truth < 0);
    ASSERT_EQ(
        orientation(to_point(x[0], 1), to_point(x[1], 1), to_point(x[2], 1), to_point(x[3], 1)),
        sign)
        << trial;
    ++seen[sign + 1];
  }
  for (const int count : seen) EXPECT_GT(count, 1000);
  // Differences that no double holds: 2^60 + 1 against 2^60.
  const double large = std::ldexp(1.0, 60);
  EXPECT_EQ(orientation({large, 1.0}, {-large, -1.0}, {0.0, 0.0}), 0);
  EXPECT_EQ(orientation({large, 1.0}, {-large, -1.0}, {0.0, std::ldexp(1.0, -60)}), -1);
  EXPECT_EQ(orientation({large, 1.0}, {-large, -1.0}, {0.0, -std::ldexp(1.0, -60)}), 1);
  EXPECT_EQ(orientation({1, 1, 1}, {large, large, large}, {-3, -3, -3}, {0.5, 7, 1e-30}), 0);
}

TEST(Crossings, PiercingTouchingAndCoplanar) {
  const Surface base = triangle({0, 0, 0}, {4, 0, 0}, {0, 4, 0});
  EXPECT_TRUE(cross(base, triangle({1, 1, -1}, {1, 1, 1}, {2, 2, 1})));     // pierces
  EXPECT_TRUE(cross(base, triangle({1, 1, 0}, {1, 1, 1}, {2, 2, 1})));      // a corner touches
  EXPECT_TRUE(cross(base, triangle({-1, -1, 0}, {1, 1, 0}, {0, 0, 1})));    // an edge lies in it
  EXPECT_TRUE(cross(base, triangle({2, -1, -1}, {2, 1, 1}, {2, -1, 1})));   // edges touch
  EXPECT_TRUE(cross(base, triangle({4, 0, 0}, {5, 0, 0}, {5, 0, 1})));      // corners touch
  EXPECT_TRUE(cross(base, triangle({1, 1, 0}, {1.5, 1, 0}, {1, 1.5, 0})));  // contained, coplanar
  EXPECT_TRUE(cross(base, triangle({-9, -9, 0}, {9, -9, 0}, {0, 30, 0})));  // contains, coplanar
  EXPECT_TRUE(cross(base, base));
  EXPECT_FALSE(cross(base, triangle({5, 5, 0}, {6, 5, 0}, {5, 6, 0})));      // coplanar, apart
  EXPECT_FALSE(cross(base, triangle({2.5, 2.5, 0}, {4, 1, 0}, {4, 4, 0})));  // boxes overlap only
  EXPECT_FALSE(cross(base, triangle({1, 1, 1}, {2, 1, 1}, {1, 2, 1})));      // parallel
  EXPECT_TRUE(cross(base, triangle({1, 1, 0}, {1, 1, 0}, {1, 1, 0})));       // a point in it
  EXPECT_TRUE(cross(base, triangle({1, 1, -1}, {1, 1, 1}, {1, 1, 0.5})));    // a segment through it
  EXPECT_FALSE(cross(base, triangle({3, 3, -1}, {3, 3, 1}, {3, 3, 0.5})));
}

// A corner above the plane z = x + y, on it, and one unit in the last place off it.
TEST(Crossings, OneUnitInTheLastPlaceDecides) {
  const Surface slope = triangle({0, 0, 0}, {1, 0, 1}, {0, 1, 1});
  std::mt19937 random(4);
  std::uniform_real_distribution<float> uniform(0.05F, 0.45F);
  for (int trial = 0; trial < 1000; ++trial) {
    const double x = uniform(random), y = uniform(random);
    const double on = x + y;  // exact: the sum of two floats of like size
    const auto tip = [&](double z) {
      return triangle({x, y, z}, {x, y, z + 3}, {x + 1, y, z + 3});
    };
    ASSERT_TRUE(cross(slope, tip(on)));
    ASSERT_FALSE(cross(slope, tip(std::nextafter(on, 2.0))));
    ASSERT_TRUE(cross(slope, tip(std::nextafter(on, 0.0))));
  }
}

TEST(Crossings, TrianglesOfOneSurfaceThatShareParticles) {
  // Two triangles share particle 0 only.
  Surface fan{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {-4, 0, 0}, {0, -4, 0}}, {{0, 1, 2}, {3, 4, 0}}};
  EXPECT_TRUE(crossings_of({fan}).empty());
  fan.positions[3] = {1, 1, -1};  // now the edge across from it pierces the other
  fan.positions[4] = {1, 1, 1};
  ASSERT_EQ(crossings_of({fan}).size(), 1U);
  EXPECT_EQ(crossings_of({fan})[0].triangle_b, 1);
  fan.check_self = false;
  EXPECT_TRUE(crossings_of({fan}).empty());
  // Two particles shared: folded exactly flat, and not counted.
  const Surface fold{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {1, 0, 3}}};
  EXPECT_TRUE(crossings_of({fold}).empty());
}

std::set<std::array<int, 4>> as_set(const std::vector<Crossing>& crossings) {
  std::set<std::array<int, 4>> result;
  for (const Crossing& c : crossings)
    result.insert({c.surface_a, c.triangle_a, c.surface_b, c.triangle_b});
  EXPECT_EQ(result.size(), crossings.size());
  return result;
}

// Checks every pair of triangles separately, without any search.
std::set<std::array<int, 4>> all_pairs(const std::vector<Surface>& surfaces) {
  std::set<std::array<int, 4>> result;
  const auto single = [&](int surface, int index) {
    Surface one = surfaces[surface];
    one.triangles = {one.triangles[index]};
    return one;
  };
  for (int s = 0; s < static_cast<int>(surfaces.size()); ++s) {
    for (int t = s; t < static_cast<int>(surfaces.size()); ++t) {
      for (int i = 0; i < static_cast<int>(surfaces[s].triangles.size()); ++i) {
        for (int j = s == t ? i + 1 : 0; j < static_cast<int>(surfaces[t].triangles.size()); ++j) {
          Surface pair = single(s, i);
          if (s == t) pair.triangles.push_back(surfaces[s].triangles[j]);
          const bool found = s == t ? !crossings_of({pair}).empty() : cross(pair, single(t, j));
          if (found) result.insert({s, i, t, j});
        }
      }
    }
  }
  return result;
}

// Returns a sheet of rows x cols particles, each moved at random.
Surface crumpled(std::mt19937& random, int rows, int cols, double amplitude) {
  std::uniform_real_distribution<float> uniform(-1, 1);
  Surface sheet;
  for (int row = 0; row < rows; ++row)
    for (int col = 0; col < cols; ++col)
      sheet.positions.push_back(
          Vec3(col, row, 0) + amplitude * Vec3(uniform(random), uniform(random), uniform(random)));
  for (int row = 0; row + 1 < rows; ++row) {
    for (int col = 0; col + 1 < cols; ++col) {
      const int corner = row * cols + col;
      sheet.triangles.push_back({corner, corner + 1, corner + cols});
      sheet.triangles.push_back({corner + 1, corner + cols + 1, corner + cols});
    }
  }
  return sheet;
}

TEST(Crossings, NothingIsLostAgainstAllPairs) {
  std::mt19937 random(5);
  for (const double amplitude : {0.0, 0.3, 1.0, 3.0}) {
    std::vector<Surface> surfaces = {crumpled(random, 6, 7, amplitude),
                                     crumpled(random, 5, 6, amplitude),
                                     crumpled(random, 2, 12, 2 * amplitude)};
    surfaces[2].check_self = amplitude != 1.0;
    const auto found = as_set(crossings_of(surfaces));
    EXPECT_EQ(found, all_pairs(surfaces));
    EXPECT_GT(found.size(), 20U);
  }
}

Surface torus(const Vec3& centre, const Vec3& axis_u, const Vec3& axis_v, double tube, int count) {
  Surface result;
  const Vec3 axis_w = axis_u.cross(axis_v);
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) {
      const double u = 2 * std::numbers::pi * i / count, v = 2 * std::numbers::pi * j / count;
      const Vec3 outwards = std::cos(u) * axis_u + std::sin(u) * axis_v;
      result.positions.push_back(centre + outwards +
                                 tube * (std::cos(v) * outwards + std::sin(v) * axis_w));
    }
  }
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) {
      const int i2 = (i + 1) % count, j2 = (j + 1) % count;
      result.triangles.push_back({i * count + j, i2 * count + j, i * count + j2});
      result.triangles.push_back({i2 * count + j, i2 * count + j2, i * count + j2});
    }
  }
  return result;
}

// Linked rings whose circles approach each other to a distance of 1.
TEST(Crossings, InterlockedTori) {
  const auto linked = [](double tube) {
    return std::vector<Surface>{torus({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, tube, 64),
                                torus({1, 0, 0}, {1, 0, 0}, {0, 0, 1}, tube, 64)};
  };
  EXPECT_TRUE(crossings_of(linked(0.49)).empty());
  const std::vector<Crossing> found = crossings_of(linked(0.52));
  EXPECT_GT(found.size(), 20U);
  for (const Crossing& crossing : found) EXPECT_NE(crossing.surface_a, crossing.surface_b);
}

TEST(Crossings, NothingToFindInNothing) {
  EXPECT_TRUE(find_crossings({}).empty());
  EXPECT_TRUE(crossings_of({Surface{}, Surface{}}).empty());
}

}  // namespace
}  // namespace weft::sim::crossings_test
