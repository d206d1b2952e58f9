#include "bsi/proximity.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

namespace weft::bsi::proximity_test {
namespace {

using Vector12 = Eigen::Matrix<double, 12, 1>;
using Query = Closest (*)(const Vec3&, const Vec3&, const Vec3&, const Vec3&);

Closest closest(Query query, const FourPoints& x) { return query(x[0], x[1], x[2], x[3]); }

// Least value of a convex function on [0, 1].
template <class Function>
double minimise(const Function& f) {
  double low = 0, high = 1;
  for (int step = 0; step < 45; ++step) {
    const double first = low + 0.382 * (high - low), second = low + 0.618 * (high - low);
    if (f(first) < f(second))
      high = second;
    else
      low = first;
  }
  return std::min({f(0.5 * (low + high)), f(0.0), f(1.0)});
}

double distance_by_search(Query query, const FourPoints& x) {
  const bool triangle = query == closest_vertex_triangle;
  return std::sqrt(minimise([&](double s) {
    return minimise([&](double t) {
      if (!triangle) return ((1 - s) * x[0] + s * x[1] - (1 - t) * x[2] - t * x[3]).squaredNorm();
      return (x[0] - (1 - s) * x[1] - s * ((1 - t) * x[2] + t * x[3])).squaredNorm();
    });
  }));
}

void expect_consistent(Query query, const FourPoints& x, const Closest& found) {
  const auto& w = found.weight;
  if (query == closest_vertex_triangle) {
    EXPECT_EQ(w[0], 1);
    EXPECT_NEAR(w[1] + w[2] + w[3], -1, 1e-15);
    for (int i = 1; i < 4; ++i) EXPECT_TRUE(w[i] <= 0 && w[i] >= -1) << i << " " << w[i];
  } else {
    EXPECT_NEAR(w[0] + w[1], 1, 1e-15);
    EXPECT_NEAR(w[2] + w[3], -1, 1e-15);
    for (int i = 0; i < 4; ++i) EXPECT_LE(std::abs(w[i] - (i < 2 ? 0.5 : -0.5)), 0.5) << i;
  }
  double size = 0;
  for (const Vec3& point : x) size = std::max(size, point.norm());
  const Vec3 sum = w[0] * x[0] + w[1] * x[1] + w[2] * x[2] + w[3] * x[3];
  EXPECT_LE((sum - found.separation).norm(), 1e-9 * size);
  EXPECT_DOUBLE_EQ(found.squared_distance, found.separation.squaredNorm());
  EXPECT_TRUE(found.free_directions >= 0 && found.free_directions <= 2);
}

// Returns random points in one of several shapes, which cover all features and degenerate cases.
FourPoints random_points(std::mt19937& random, int shape) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::uniform_int_distribution<int> small(-2, 2);
  const auto point = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  const auto lattice = [&] { return Vec3(small(random), small(random), small(random)); };
  FourPoints x = {point(), point(), point(), point()};
  if (shape == 1) x = {lattice(), lattice(), lattice(), lattice()};
  if (shape == 2) x[3] = x[2] + 1e-5 * uniform(random) * point();     // needles
  if (shape == 3) x[3] = x[1] + (x[2] - x[1]) * 2 * uniform(random);  // collinear to rounding
  if (shape == 4) x[3] = x[2] + (x[1] - x[0]) * uniform(random);      // parallel edges
  if (shape == 5) x[3] = x[1] + (x[2] - x[1]) * uniform(random) + 1e-8 * point();
  if (shape == 6) x[3] = x[2] + (x[1] - x[0]) * uniform(random) + 1e-8 * point();
  if (shape == 7) x[1] = x[2] = x[3];
  if (shape == 8) x[1] = x[0], x[3] = x[2];
  if (shape == 9) x[0] = (x[1] + x[2] + x[3]) / 3 + 1e-7 * point();  // nearly touching
  return x;
}

void compare_with_search(Query query) {
  std::mt19937 random(7);
  std::array<int, 3> seen{};
  for (int trial = 0; trial < 3000; ++trial) {
    SCOPED_TRACE(trial);
    const FourPoints x = random_points(random, trial % 10);
    const Closest found = closest(query, x);
    expect_consistent(query, x, found);
    EXPECT_NEAR(std::sqrt(found.squared_distance), distance_by_search(query, x), 2e-8);
    ++seen[found.free_directions];
    if (testing::Test::HasFailure()) return;
  }
  for (const int count : seen) EXPECT_GT(count, 100);
}

TEST(Proximity, VertexTriangleIsTheLeastDistance) { compare_with_search(closest_vertex_triangle); }
TEST(Proximity, EdgeEdgeIsTheLeastDistance) { compare_with_search(closest_edge_edge); }

TEST(Proximity, KnownPairs) {
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  Closest found = closest_vertex_triangle({0.25, 0.25, 2}, a, b, c);
  EXPECT_EQ(found.separation, Vec3(0, 0, 2));
  EXPECT_EQ(found.free_directions, 2);
  found = closest_vertex_triangle({0.5, -1, 0}, a, b, c);
  EXPECT_EQ(found.weight, (std::array<double, 4>{1, -0.5, -0.5, 0}));
  EXPECT_EQ(found.free_directions, 1);
  found = closest_vertex_triangle({2, -1, 0}, a, b, c);
  EXPECT_EQ(found.weight, (std::array<double, 4>{1, 0, -1, 0}));
  EXPECT_EQ(found.free_directions, 0);
  found = closest_vertex_triangle({0.25, 0.25, 0}, a, b, c);
  EXPECT_EQ(found.squared_distance, 0);
  found = closest_vertex_triangle({0.5, 0.5, 1}, a, b, c);
  EXPECT_EQ(found.weight, (std::array<double, 4>{1, 0, -0.5, -0.5}));
  EXPECT_EQ(found.free_directions, 1);

  found = closest_edge_edge({-1, 0, 0}, {1, 0, 0}, {0, -1, 3}, {0, 1, 3});
  EXPECT_EQ(found.separation, Vec3(0, 0, -3));
  EXPECT_EQ(found.weight, (std::array<double, 4>{0.5, 0.5, -0.5, -0.5}));
  EXPECT_EQ(found.free_directions, 2);
}

// The vertex is far closer to the interior than to any edge of a triangle that is nearly a line.
TEST(Proximity, ThinTrianglesHaveAnInterior) {
  for (const double height : {1e-7, 3e-8, 3e-9}) {
    const double gap = 0.01 * height;
    const Closest found =
        closest_vertex_triangle({0.5, height / 3, gap}, {0, 0, 0}, {1, 0, 0}, {0.5, height, 0});
    EXPECT_NEAR(std::sqrt(found.squared_distance), gap, 1e-6 * gap) << height;
    EXPECT_EQ(found.free_directions, 2);
  }
}

TEST(Proximity, ParallelEdgesHaveAtMostOneFreeDirection) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int sliding = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    FourPoints x = random_points(random, trial % 2 == 0 ? 0 : 1);
    x[2] = x[0] + Vec3(uniform(random), uniform(random), uniform(random));
    x[3] = x[2] + (x[1] - x[0]) * (trial % 3 - 1);
    const Closest found = closest(closest_edge_edge, x);
    ASSERT_LE(found.free_directions, 1) << trial;
    sliding += found.free_directions;
  }
  EXPECT_GT(sliding, 200);

  // Edges cross at a small angle; below a sine of 1e-10 they count as parallel.
  for (const double sine : {1e-6, 1e-9, 1e-11, 1e-14}) {
    const FourPoints x = {Vec3(-1, 0, 0), Vec3(1, 0, 0), Vec3(-1, -sine, 1e-6),
                          Vec3(1, sine, 1e-6)};
    const Closest found = closest(closest_edge_edge, x);
    EXPECT_EQ(found.free_directions, sine > 1e-10 ? 2 : 1) << sine;
    EXPECT_NEAR(found.squared_distance, 1e-12, 1e-15);
  }
}

FourPoints moved(const FourPoints& x, const Vector12& step) {
  FourPoints result = x;
  for (int i = 0; i < 4; ++i) result[i] += step.segment<3>(3 * i);
  return result;
}

Vector12 gradient(const Closest& found) {
  Vector12 result;
  const Vec3 normal = found.separation / std::sqrt(found.squared_distance);
  for (int i = 0; i < 4; ++i) result.segment<3>(3 * i) = found.weight[i] * normal;
  return result;
}

void compare_derivatives(Query query) {
  std::mt19937 random(5);
  std::array<int, 3> seen{};
  const double h = 1e-5;
  for (int trial = 0; trial < 4000; ++trial) {
    SCOPED_TRACE(trial);
    const FourPoints x = random_points(random, 0);
    const Closest found = closest(query, x);
    if (std::sqrt(found.squared_distance) < 0.05) continue;
    const Vector12 exact = gradient(found);
    for (int i = 0; i < 12; ++i) {
      const Vector12 step = h * Vector12::Unit(i);
      const Closest plus = closest(query, moved(x, step)), minus = closest(query, moved(x, -step));
      const double difference =
          std::sqrt(plus.squared_distance) - std::sqrt(minus.squared_distance);
      ASSERT_NEAR(difference / (2 * h), exact[i], 1e-5);
    }
    ++seen[found.free_directions];
  }
  for (const int count : seen) EXPECT_GT(count, 200);
}

TEST(Proximity, VertexTriangleDerivatives) { compare_derivatives(closest_vertex_triangle); }
TEST(Proximity, EdgeEdgeDerivatives) { compare_derivatives(closest_edge_edge); }

}  // namespace
}  // namespace weft::bsi::proximity_test
