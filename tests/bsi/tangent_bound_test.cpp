// The inequality behind the tangent certificate (docs/theory.md, "The tangent certificate"), step
// by step, and how tight it is.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "bsi/traversal.h"
#include "tests/bsi/feature_distances.h"

namespace weft::bsi::tangent_bound_test {
namespace {

using Random = std::mt19937;

double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

Vec3 random_vector(Random& random) {
  return {uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)};
}

// Two features without a common vertex are 1 or more apart along one of the coordinates i (along
// u), j (along v) or i + j. The hexagonal distance of any two of their points is then at least 1.
TEST(TangentBound, FeaturesWithoutACommonVertexAreAHexagonApart) {
  constexpr int size = 6;
  const Atlas atlas({{size, size}});
  int pairs = 0;
  const std::vector<Feature> features = features_of(atlas);
  for (const Feature& a : features) {
    for (const Feature& b : features) {
      if (share_a_vertex(a.vertices, b.vertices)) continue;
      const auto apart = [&](int along_u, int along_v) {
        const auto coordinate = [&](int vertex) {
          return along_u * (vertex % size) + along_v * (vertex / size);
        };
        const auto [low_a, high_a] = std::ranges::minmax(a.vertices, {}, coordinate);
        const auto [low_b, high_b] = std::ranges::minmax(b.vertices, {}, coordinate);
        return std::max(coordinate(low_b) - coordinate(high_a),
                        coordinate(low_a) - coordinate(high_b)) >= 1;
      };
      EXPECT_TRUE(apart(1, 0) || apart(0, 1) || apart(1, 1));
      ++pairs;
    }
  }
  EXPECT_GT(pairs, 10000);
}

// Returns the largest margin at which a plain or swept patch is certified as a whole, by bisection.
double certified_margin(const Pyramid& pyramid, double most) {
  double low = 0, high = most;
  std::vector<LeafBlockPair> found;
  for (int i = 0; i < 34; ++i) {
    const double margin = 0.5 * (low + high);
    TraversalCounters counters;
    found.clear();
    self_traversal(pyramid, {.margin = margin}, found, counters);
    const bool whole = counters.certified == 1 && counters.certificate_tests == 1;
    (whole ? low : high) = margin;
  }
  return low;
}

double smallest_height(const Vec3& a, const Vec3& b) {
  return a.cross(b).norm() / std::max({a.norm(), b.norm(), (a - b).norm()});
}

Positions plane_grid(const Vec3& a, const Vec3& b, const Vec3& origin, int rows, int cols) {
  Positions x;
  for (int row = 0; row < rows; ++row) {
    for (int col = 0; col < cols; ++col) x.emplace_back(origin + col * a + row * b);
  }
  return x;
}

double least_distance(const std::vector<FeaturePair>& pairs, const Positions& x) {
  double least = infinity;
  for (const FeaturePair& pair : pairs) least = std::min(least, distance(pair, x));
  return least;
}

// On a plane grid the margin is the smallest height of a triangle, minus a bound of rounding: near
// the origin almost nothing, far from it between 2^-20 and 2^-19 of the coordinates.
TEST(TangentBound, IsTheSmallestHeightOfAPlaneGrid) {
  Random random(1);
  const Atlas atlas({{5, 6}});
  const std::vector<Feature> features = features_of(atlas);
  const std::vector<FeaturePair> pairs = pairs_of_features(features);
  Pyramid pyramid(atlas);
  int reached = 0;
  for (int sample = 0; sample < 400; ++sample) {
    const double size = std::pow(10.0, uniform(random, -25, 11));
    const double away = sample % 2 == 0 ? 0 : std::pow(10.0, uniform(random, 0, 5));
    const Vec3 a = size * random_vector(random), b = size * random_vector(random);
    const Positions x = plane_grid(a, b, size * away * random_vector(random), 5, 6);
    ASSERT_FALSE(pyramid.rebuild(x));
    const double height = smallest_height(a, b), true_distance = least_distance(pairs, x);
    const double bound = certified_margin(pyramid, 2 * height);
    EXPECT_LE(bound, true_distance);
    EXPECT_GE(true_distance, height * (1 - 1e-9));
    EXPECT_LE(bound, height);
    EXPECT_GE(bound, height - 0x1p-17 * static_cast<double>(pyramid.magnitude()));
    reached += true_distance < 1.0001 * height && bound > 0.9999 * true_distance ? 1 : 0;
  }
  EXPECT_GT(reached, 50);  // where the foot of the height lies within the opposite side
}

// --- Attack --------------------------------------------------------------------------------------

// Changes a random patch, plain or swept, step by step, to bring the certified margin as close as
// possible to the true least distance, or beyond it if the certificate were wrong.
struct Attack {
  static constexpr int rows = 4, cols = 4;
  Random random;
  Atlas atlas{{{rows, cols}}};
  std::vector<Feature> features = features_of(atlas);
  std::vector<FeaturePair> pairs = pairs_of_features(features);
  Pyramid pyramid{atlas};
  bool swept;
  Positions start, end;

  Attack(unsigned seed, bool is_swept) : random(seed), swept(is_swept) {
    const Vec3 a = random_vector(random), b = random_vector(random);
    const Vec3 origin = uniform(random, 0, 100) * random_vector(random);
    start = plane_grid(a, b, origin, rows, cols);
    end = plane_grid(a + 0.3 * random_vector(random), b + 0.3 * random_vector(random), origin, rows,
                     cols);
    for (Vec3& x : start) x += 0.02 * random_vector(random);
    for (Vec3& x : end) x += 0.02 * random_vector(random);
  }

  // Ratio of the certified margin to the true distance; 0 if nothing is certified.
  double ratio(const Positions& from, const Positions& to) {
    double distance_met = least_distance(pairs, from);
    if (swept) {
      for (const double t : {0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0})
        distance_met = std::min(distance_met, least_distance(pairs, between(from, to, t)));
    }
    const auto bad = swept ? pyramid.rebuild_swept(from, to) : pyramid.rebuild(from);
    if (bad || distance_met == 0) return 0;
    return certified_margin(pyramid, 2 * distance_met) / distance_met;
  }

  double run(int steps) {
    double best = ratio(start, end);
    double stride = 0.3;
    for (int i = 0; i < steps; ++i) {
      Positions from = start, to = end;
      // Changes one vertex, or all of them along one direction of the grid.
      Positions& changed = swept && i % 2 == 0 ? to : from;
      const Vec3 change = stride * random_vector(random);
      const int kind = i % 3;
      for (int vertex = 0; vertex < rows * cols; ++vertex) {
        if (kind == 1) changed[vertex] += vertex % cols * change;
        if (kind == 2) changed[vertex] += vertex / cols * change;
      }
      if (kind == 0) changed[random() % changed.size()] += change;
      const double found = ratio(from, to);
      if (found > best) {
        best = found;
        start = from;
        end = to;
        stride = std::min(0.3, 2 * stride);
      } else {
        stride = std::max(1e-6, 0.95 * stride);
      }
    }
    return best;
  }
};

TEST(TangentBound, IsNotBeatenByAnAttack) {
  for (const bool swept : {false, true}) {
    double best = 0;
    for (unsigned seed = 0; seed < 8; ++seed) {
      const double reached = Attack(seed, swept).run(swept ? 150 : 400);
      EXPECT_LT(reached, 1);
      best = std::max(best, reached);
    }
    EXPECT_GT(best, swept ? 0.5 : 0.9) << (swept ? "swept" : "plain");
  }
}

}  // namespace
}  // namespace weft::bsi::tangent_bound_test
