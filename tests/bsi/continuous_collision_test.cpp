#include "bsi/continuous_collision.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <random>
#include <vector>

#include "tests/bsi/ccd_benchmark.h"

namespace weft::bsi::continuous_collision_test {
namespace {

enum class Kind { vertex_triangle, edge_edge };

double safe_fraction(Kind kind, const FourPoints& start, const FourPoints& end,
                     double minimum_separation) {
  return kind == Kind::vertex_triangle
             ? safe_fraction_vertex_triangle(start, end, minimum_separation)
             : safe_fraction_edge_edge(start, end, minimum_separation);
}

double distance(Kind kind, const FourPoints& x) {
  const Closest found = kind == Kind::vertex_triangle
                            ? closest_vertex_triangle(x[0], x[1], x[2], x[3])
                            : closest_edge_edge(x[0], x[1], x[2], x[3]);
  return std::sqrt(found.squared_distance);
}

FourPoints along(const FourPoints& start, const FourPoints& end, double fraction) {
  FourPoints result;
  for (int i = 0; i < 4; ++i) result[i] = start[i] + fraction * (end[i] - start[i]);
  return result;
}

FourPoints random_points(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> uniform(-size, size);
  FourPoints x;
  for (Vec3& point : x) point = Vec3(uniform(random), uniform(random), uniform(random));
  return x;
}

void compare_with_sampling(Kind kind) {
  std::mt19937 random(3);
  int stopped = 0, whole = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    SCOPED_TRACE(trial);
    const FourPoints start = random_points(random, 1);
    FourPoints end = random_points(random, trial % 3 == 0 ? 3 : 1);
    if (trial % 2 == 0) end = along(start, end, 0.2);
    const double minimum = trial % 5 == 0 ? 0.05 : 0;
    const double gap = distance(kind, start) - minimum;
    const double fraction = safe_fraction(kind, start, end, minimum);
    if (gap <= 0) {
      ASSERT_EQ(fraction, 0);
      continue;
    }
    ASSERT_GT(fraction, 0);
    ASSERT_LE(fraction, 1);
    for (int sample = 0; sample <= 200; ++sample)
      ASSERT_GT(distance(kind, along(start, end, fraction * sample / 200)), minimum);
    // A motion is stopped only near contact; safe motion is not held back.
    const double left = distance(kind, along(start, end, fraction)) - minimum;
    ASSERT_TRUE(fraction == 1 || left <= 0.101 * gap) << left << " of " << gap;
    ++(fraction < 1 ? stopped : whole);
  }
  EXPECT_GT(stopped, 150);
  EXPECT_GT(whole, 300);
}

TEST(ContinuousCollision, VertexTriangleAgainstSampling) {
  compare_with_sampling(Kind::vertex_triangle);
}
TEST(ContinuousCollision, EdgeEdgeAgainstSampling) { compare_with_sampling(Kind::edge_edge); }

// Pairs that touch exactly half way, at every scale and far from the origin. Coordinates are small
// multiples of a power of two, so all numbers below are exact.
TEST(ContinuousCollision, ExactTouchIsNeverMissed) {
  std::mt19937 random(19);
  std::uniform_int_distribution<int> small(-8, 8), scale_exponent(-20, 10);
  const auto lattice = [&] { return Vec3(small(random), small(random), small(random)); };
  int tested = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    FourPoints middle = {lattice(), 4 * lattice(), 4 * lattice(), 4 * lattice()};
    const Kind kind = trial % 2 == 0 ? Kind::vertex_triangle : Kind::edge_edge;
    if (kind == Kind::vertex_triangle)
      middle[0] = 0.25 * (middle[1] + middle[2] + 2 * middle[3]);
    else
      middle[1] = 0.5 * (middle[2] + middle[3]) * 2 - middle[0];
    const double unit = std::ldexp(1.0, scale_exponent(random));
    const Vec3 origin = trial % 3 == 0 ? Vec3(1024, -512, 2048) : Vec3(0, 0, 0);
    const Vec3 common = trial % 5 == 0 ? Vec3(100, 200, -50) : Vec3(0, 0, 0);
    FourPoints start, end;
    for (int i = 0; i < 4; ++i) {
      const Vec3 step = trial % 7 == 0 ? Vec3(lattice() / 64) : lattice();
      start[i] = origin + unit * (middle[i] - step - common);
      end[i] = origin + unit * (middle[i] + step + common);
    }
    const double fraction = safe_fraction(kind, start, end, 0);
    ASSERT_LE(fraction, 0.5) << trial;
    if (fraction > 0) ++tested;
    // Touching only at the very end counts as well.
    ASSERT_LT(safe_fraction(kind, start, along(start, end, 0.5), 0), 1) << trial;
  }
  EXPECT_GT(tested, 15000);
}

TEST(ContinuousCollision, KnownPaths) {
  const FourPoints start = {Vec3(0.2, 0.3, 1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  FourPoints end = start;
  end[0].z() = -1;
  const double fraction = safe_fraction_vertex_triangle(start, end, 0);
  EXPECT_LT(fraction, 0.5);
  EXPECT_GT(fraction, 0.45);
  EXPECT_EQ(safe_fraction_vertex_triangle(start, start, 0.5), 1);
  EXPECT_EQ(safe_fraction_vertex_triangle(start, end, 1), 0);
  EXPECT_EQ(safe_fraction_vertex_triangle(start, end, 2), 0);
  end[0].z() = 0.01;  // stays apart, however near it gets
  EXPECT_EQ(safe_fraction_vertex_triangle(start, end, 0), 1);
  end[0].z() = 0;  // touches at the end
  EXPECT_LT(safe_fraction_vertex_triangle(start, end, 0), 1);
  end[0].z() = std::nan("");
  EXPECT_EQ(safe_fraction_vertex_triangle(end, start, 0), 0);
  EXPECT_LT(safe_fraction_vertex_triangle(start, end, 0), 1);
}

// A long path very near a feature would stall a bound by the plain speed.
TEST(ContinuousCollision, SlidingAtATinyGapIsFree) {
  FourPoints start = {Vec3(0.2, 0.3, 1e-9), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  FourPoints end = start;
  end[0].x() = 100;
  EXPECT_EQ(safe_fraction_vertex_triangle(start, end, 0), 1);
  EXPECT_EQ(safe_fraction_vertex_triangle(start, end, 0.9e-9), 1);
  start = {Vec3(-0.9, 0, 1e-9), Vec3(-0.9, 1, 1e-9), Vec3(-1, 0.5, 0), Vec3(1, 0.4, 0)};
  end = start;
  end[0].x() = end[1].x() = 100;
  EXPECT_EQ(safe_fraction_edge_edge(start, end, 0), 1);
}

TEST(ContinuousCollision, HasNoProofBeyondTheRangeOfLengths) {
  for (const double size : {1e74, 1e-74, 1e76, 1e-76}) {
    const FourPoints start = {Vec3(0.3, 0.3, 0.5) * size, Vec3(0, 0, 0), Vec3(1, 0, 0) * size,
                              Vec3(0, 1, 0) * size};
    FourPoints end = start;
    end[0].z() = size;
    const bool is_within = size > 1e-75 && size < 1e75;
    EXPECT_EQ(safe_fraction_vertex_triangle(start, end, 0), is_within ? 1 : 0) << size;
  }
}

// The path leads straight away from the closest point, which lies on an edge or in a triangle. The
// pair is 1 m large, and rounding errors of its coordinates are 1e-16 m.
TEST(ContinuousCollision, LeavingATinyGapIsFree) {
  std::mt19937 random(29);
  std::uniform_real_distribution<double> share(0.2, 0.8), angle(0.1, 1.4);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 1000; ++trial) {
    const Eigen::Quaterniond turn(normal(random), normal(random), normal(random), normal(random));
    const Eigen::Matrix3d axes = turn.normalized().toRotationMatrix();
    const double gap = std::pow(10.0, -6 - trial % 7), u = share(random), a = angle(random);
    const Vec3 away(0, std::cos(a), std::sin(a)), beside = Vec3(u, 0, 0) + gap * away;
    const auto expect_free =
        [&](const FourPoints& at, int moving, const Vec3& along,
            double (*safe_fraction)(const FourPoints&, const FourPoints&, double)) {
          FourPoints start, end;
          for (int i = 0; i < 4; ++i) {
            start[i] = axes * at[i];
            end[i] = axes * (at[i] + (i < moving ? 1.0 : 0.0) * along);
          }
          EXPECT_EQ(safe_fraction(start, end, 0), 1) << gap;
        };
    const Vec3 first(0, 0, 0), second(1, 0, 0), third(0.5, -0.9, 0);
    expect_free({beside, first, second, third}, 1, away, safe_fraction_vertex_triangle);
    expect_free({Vec3(u, -0.3 * u * (1 - u), gap), first, second, third}, 1, Vec3(0, 0, 1),
                safe_fraction_vertex_triangle);
    expect_free({beside, beside + Vec3(0, 1, 0), first, second}, 2, away, safe_fraction_edge_edge);
  }
}

// Features rotate closely past each other, so the direction of the gap rotates all the way.
TEST(ContinuousCollision, NearMissesStaySafeAndEnd) {
  std::mt19937 random(23);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int whole = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const double gap = std::pow(10.0, -1 - 8 * std::abs(uniform(random)));
    FourPoints start = {Vec3(-1, 0, gap), Vec3(1, 0, gap), Vec3(0.1, -1, 0), Vec3(-0.1, 1, 0)};
    FourPoints end = start;
    for (Vec3& point : end)
      point += 5 * Vec3(uniform(random), uniform(random), 0.3 * uniform(random));
    const double fraction = safe_fraction_edge_edge(start, end, 0);
    if (fraction == 1) ++whole;
    ASSERT_GT(fraction, 0);
    for (int sample = 0; sample <= 100; ++sample) {
      const FourPoints x = along(start, end, fraction * sample / 100);
      ASSERT_GT(distance(Kind::edge_edge, x), 0) << trial;
    }
  }
  EXPECT_GT(whole, 200);
}

TEST(ContinuousCollision, AgreesWithTheExactTruthOfTheBenchmark) {
  const char* folder = std::getenv("WEFT_CCD_DATA");
  if (folder == nullptr)
    GTEST_SKIP() << "set WEFT_CCD_DATA to the folder of the CCD benchmark's sample queries";
  int colliding = 0, missed = 0, false_alarms = 0;
  const std::vector<BenchmarkQuery> queries = read_ccd_benchmark(folder);
  for (const BenchmarkQuery& query : queries) {
    const Kind kind =
        query.kind == FeatureKind::edge_edge ? Kind::edge_edge : Kind::vertex_triangle;
    const bool found = safe_fraction(kind, query.start, query.end, 0) < 1;
    colliding += query.collides;
    missed += query.collides && !found;
    false_alarms += found && !query.collides;
  }
  std::cout << queries.size() << " queries, " << colliding << " collide; missed " << missed
            << ", false alarms " << false_alarms << "\n";
  RecordProperty("false_alarms", false_alarms);
  EXPECT_GT(colliding, 0);
  EXPECT_EQ(missed, 0);
  // The features of the others come as near as 1e-13 of their size.
  EXPECT_LE(false_alarms, 225);
}

}  // namespace
}  // namespace weft::bsi::continuous_collision_test
