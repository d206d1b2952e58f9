#include "bsi/proximity.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

namespace weft::bsi {
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
  for (int k = 0; k < found.free_directions; ++k) {
    const auto& f = found.free_weights[k];
    EXPECT_NEAR(f[0] + f[1] + f[2] + f[3], 0, 1e-15);
    const Vec3 slide = f[0] * x[0] + f[1] * x[1] + f[2] * x[2] + f[3] * x[3];
    EXPECT_GT(slide.norm(), 0);
    // Sliding is free only where it does not change the distance to first order.
    EXPECT_LE(std::abs(slide.dot(found.separation)), 1e-9 * size * slide.norm());
    for (int i = 0; i < 4; ++i)
      EXPECT_TRUE(f[i] == 0 || (w[i] != 0 && std::abs(w[i]) != 1)) << "a clamped weight slides";
  }
  if (found.free_directions < 2) {
    EXPECT_EQ(found.free_weights[1], (std::array<double, 4>{}));
  }
}

// Random points, in one of several shapes that hit every feature and every degenerate case.
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

  found = closest_edge_edge({-1, 0, 0}, {1, 0, 0}, {0, -1, 3}, {0, 1, 3});
  EXPECT_EQ(found.separation, Vec3(0, 0, -3));
  EXPECT_EQ(found.weight, (std::array<double, 4>{0.5, 0.5, -0.5, -0.5}));
  EXPECT_EQ(found.free_directions, 2);
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
    if (found.squared_distance == 0) continue;
    ASSERT_TRUE(distance_hessian(found, x).allFinite()) << trial;
  }
  EXPECT_GT(sliding, 200);

  // Edges that cross at a small angle: where it is below 1e-10 they count as parallel.
  for (const double sine : {1e-6, 1e-9, 1e-11, 1e-14}) {
    const FourPoints x = {Vec3(-1, 0, 0), Vec3(1, 0, 0), Vec3(-1, -sine, 1e-6),
                          Vec3(1, sine, 1e-6)};
    const Closest found = closest(closest_edge_edge, x);
    EXPECT_EQ(found.free_directions, sine > 1e-10 ? 2 : 1) << sine;
    EXPECT_NEAR(found.squared_distance, 1e-12, 1e-15);
    EXPECT_TRUE(distance_hessian(found, x).allFinite());
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

// The formula that the library's is derived from, without the cancelled terms taken out.
Hessian12 hessian_from_implicit_function(const Closest& found, const FourPoints& x) {
  const auto stack = [](const std::array<double, 4>& weight, const Vec3& v) {
    Vector12 result;
    for (int i = 0; i < 4; ++i) result.segment<3>(3 * i) = weight[i] * v;
    return result;
  };
  Hessian12 f_xx;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      f_xx.block<3, 3>(3 * i, 3 * j) =
          found.weight[i] * found.weight[j] * Eigen::Matrix3d::Identity();
  const int count = found.free_directions;
  if (count > 0) {
    // The matrices have two columns; the second is zero where there is one direction.
    Eigen::Matrix<double, 12, 2> f_xa = Eigen::Matrix<double, 12, 2>::Zero();
    Eigen::Matrix<double, 3, 2> e = Eigen::Matrix<double, 3, 2>::Zero();
    for (int k = 0; k < count; ++k) {
      const auto& f = found.free_weights[k];
      e.col(k) = f[0] * x[0] + f[1] * x[1] + f[2] * x[2] + f[3] * x[3];
      f_xa.col(k) = stack(found.weight, e.col(k)) + stack(f, found.separation);
    }
    Eigen::Matrix2d f_aa = e.transpose() * e;
    if (count == 1) f_aa(1, 1) = 1;
    f_xx -= f_xa * f_aa.inverse() * f_xa.transpose();
  }
  const Vector12 g = gradient(found);
  return (f_xx - g * g.transpose()) / std::sqrt(found.squared_distance);
}

void compare_derivatives(Query query) {
  std::mt19937 random(5);
  std::array<int, 3> seen{};
  const double h = 1e-5;
  for (int trial = 0; trial < 4000; ++trial) {
    SCOPED_TRACE(trial);
    const FourPoints x = random_points(random, 0);
    const Closest found = closest(query, x);
    const double distance = std::sqrt(found.squared_distance);
    if (distance < 0.05) continue;
    Vector12 numeric_gradient;
    Hessian12 numeric;
    bool one_feature = true;
    for (int i = 0; i < 12; ++i) {
      const Vector12 step = h * Vector12::Unit(i);
      const Closest plus = closest(query, moved(x, step)), minus = closest(query, moved(x, -step));
      one_feature = one_feature && plus.free_weights == found.free_weights &&
                    minus.free_weights == found.free_weights;
      numeric_gradient[i] =
          (std::sqrt(plus.squared_distance) - std::sqrt(minus.squared_distance)) / (2 * h);
      numeric.col(i) = (gradient(plus) - gradient(minus)) / (2 * h);
    }
    const Hessian12 exact = distance_hessian(found, x);
    const Hessian12 longhand = hessian_from_implicit_function(found, x);
    for (int i = 0; i < 12; ++i) ASSERT_NEAR(numeric_gradient[i], gradient(found)[i], 1e-5);
    const double size = exact.norm();
    ASSERT_LE((exact - exact.transpose()).norm(), 1e-12 * size);
    ASSERT_LE((exact - longhand).norm(), 1e-9 * size / distance);
    // Thin features bend the distance so fast that a difference of 1e-5 no longer resolves it.
    if (!one_feature || size > 100) continue;
    ASSERT_LE((exact - numeric).norm(), 1e-5 * size);
    ++seen[found.free_directions];
  }
  for (const int count : seen) EXPECT_GT(count, 200);
}

TEST(Proximity, VertexTriangleDerivatives) { compare_derivatives(closest_vertex_triangle); }
TEST(Proximity, EdgeEdgeDerivatives) { compare_derivatives(closest_edge_edge); }

// Contact happens at gaps of micrometres and less, where the terms in 1/d must cancel.
TEST(Proximity, HessianStaysAccurateAtTinyDistances) {
  for (const double distance : {1e-3, 1e-6, 1e-9, 1e-12}) {
    const FourPoints x = {Vec3(0.2, 0.3, distance), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
    const Closest found = closest(closest_vertex_triangle, x);
    const Hessian12 hessian = distance_hessian(found, x);
    // d = n . (x0 - x1): raising corner 2 of a right triangle by z tilts the normal by -z in x.
    EXPECT_NEAR(hessian(0, 8), -1.0, 1e-9) << distance;
    EXPECT_NEAR(hessian(8, 8), -distance, 1e-9) << distance;
    EXPECT_NEAR(hessian(0, 0), 0, 1e-9) << distance;
  }
}

}  // namespace
}  // namespace weft::bsi
