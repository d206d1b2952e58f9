// Samples of sweeps: published points, their uniformity, and numbers that every machine must give.
#include "sim/sweep/sample_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/sweep/sweep_values.h"

namespace weft::sim::sweep_sample_test {
namespace {

// The first ten points of the sequence in three dimensions, as S. Joe and F. Y. Kuo publish them
// with their direction numbers (https://web.maths.unsw.edu.au/~fkuo/sobol/, "sobol.cc").
TEST(SweepSamples, SobolPointsAreThePublishedOnes) {
  const std::vector<UnitPoint> published{{0, 0, 0},
                                         {0.5, 0.5, 0.5},
                                         {0.75, 0.25, 0.25},
                                         {0.25, 0.75, 0.75},
                                         {0.375, 0.375, 0.625},
                                         {0.875, 0.875, 0.125},
                                         {0.625, 0.125, 0.875},
                                         {0.125, 0.625, 0.375},
                                         {0.1875, 0.3125, 0.9375},
                                         {0.6875, 0.8125, 0.4375}};
  EXPECT_EQ(sobol_points(10, 3, 0), published);
}

// The first 2^k points of each coordinate lie in different intervals of length 2^-k.
void expect_one_per_interval(const std::vector<UnitPoint>& points) {
  for (std::size_t d = 0; d < points.front().size(); ++d) {
    std::vector<int> hits(points.size(), 0);
    for (const UnitPoint& point : points) {
      ASSERT_GE(point[d], 0);
      ASSERT_LT(point[d], 1);
      ++hits[static_cast<std::size_t>(point[d] * static_cast<double>(points.size()))];
    }
    EXPECT_EQ(std::ranges::count(hits, 1), static_cast<std::ptrdiff_t>(points.size()))
        << "coordinate " << d;
  }
}

TEST(SweepSamples, SobolPointsFillIntervalsOfAllDimensions) {
  expect_one_per_interval(sobol_points(256, most_sobol_dimensions, 0));
  expect_one_per_interval(sobol_points(256, 40, 7));
}

// Any two of the first coordinates have one point in each of 2 x 2 quarters of four points, and in
// each elementary box of area 1/4 for the pair of the first two: a (0, 2)-net.
TEST(SweepSamples, FirstTwoSobolCoordinatesAreANet) {
  for (const std::uint64_t seed : {0U, 5U}) {
    const std::vector<UnitPoint> points = sobol_points(64, 2, seed);
    for (int columns = 1; columns <= 64; columns *= 2) {
      std::vector<int> hits(64, 0);
      const int rows = 64 / columns;
      for (const UnitPoint& point : points)
        ++hits[static_cast<int>(point[0] * columns) * rows + static_cast<int>(point[1] * rows)];
      EXPECT_EQ(std::ranges::count(hits, 1), 64) << columns << " columns, seed " << seed;
    }
  }
}

TEST(SweepSamples, SeedsShiftSobolPoints) {
  EXPECT_NE(sobol_points(4, 2, 1), sobol_points(4, 2, 0));
  EXPECT_NE(sobol_points(4, 2, 1), sobol_points(4, 2, 2));
  EXPECT_EQ(sobol_points(4, 2, 1), sobol_points(4, 2, 1));
}

TEST(SweepSamples, LatinHypercubesHaveOnePointPerInterval) {
  for (const std::size_t count : {1U, 2U, 7U, 100U}) {
    for (const std::uint64_t seed : {0U, 1U, 99U})
      expect_one_per_interval(latin_hypercube_points(count, 5, seed));
  }
  EXPECT_NE(latin_hypercube_points(7, 2, 1), latin_hypercube_points(7, 2, 2));
  // The orders of the coordinates differ.
  const std::vector<UnitPoint> points = latin_hypercube_points(100, 2, 1);
  double product = 0;
  for (const UnitPoint& point : points) product += (point[0] - 0.5) * (point[1] - 0.5) / 100;
  EXPECT_LT(std::abs(product), 0.03);  // a third of 1/12, the product of equal coordinates
}

// The engine is that of the C++ standard, whose 10,000th number from the default seed is stated
// there ([rand.predef]): 9981545732273789042.
TEST(SweepSamples, RandomPointsComeFromTheStandardEngine) {
  const std::vector<UnitPoint> points = random_points(5000, 2, 5489);
  EXPECT_EQ(points.back()[1], static_cast<double>(9981545732273789042U >> 11U) * 0x1p-53);
  double mean = 0, square = 0;
  for (const UnitPoint& point : points) {
    mean += point[0] / 5000;
    square += point[0] * point[0] / 5000;
  }
  EXPECT_NEAR(mean, 0.5, 4 / std::sqrt(12.0 * 5000));
  EXPECT_NEAR(square, 1.0 / 3, 4 * std::sqrt(4.0 / 45 / 5000));
}

TEST(SweepSamples, ValuesLieBetweenTheirEnds) {
  EXPECT_EQ(uniform_value(0.1, 0.5, 0), 0.1);
  EXPECT_EQ(uniform_value(0.1, 0.5, 0.5), 0.3);
  EXPECT_EQ(log_uniform_value(0.01, 100, 0), 0.01);
  EXPECT_EQ(log_uniform_value(0.01, 100, 0.5), 1);
  EXPECT_EQ(log_uniform_value(0.01, 100, 0.25), 0.1);
  const double below_one = 1 - 0x1p-53;
  for (const double third : {1.0 / 3, 2.0 / 3}) {
    EXPECT_LE(uniform_value(0, third, below_one), third);
    EXPECT_GE(uniform_value(third, 1, 0), third);
    EXPECT_LE(log_uniform_value(third / 2, third, below_one), third);
  }
  EXPECT_EQ(range_value(0.1, 0.5, 5, 0), 0.1);
  EXPECT_EQ(range_value(0.1, 0.5, 5, 1), 0.2);
  EXPECT_EQ(range_value(0.1, 0.5, 5, 2), 0.3);
  EXPECT_EQ(range_value(0.1, 0.5, 5, 4), 0.5);
}

// Decimal numbers of few digits are preferred, but never at the cost of the value.
TEST(SweepSamples, ValuesOfARangeAreExactAndShort) {
  for (int i = 0; i <= 10; ++i) {
    EXPECT_EQ(range_value(0.5, 0.5000000001, 11, i),
              std::stod("0.500000000" + std::string(i < 10 ? "0" : "1") + std::to_string(i % 10)));
    EXPECT_EQ(range_value(0, 1, 11, i),
              std::stod(std::to_string(i / 10) + '.' + std::to_string(i % 10)));
  }
  EXPECT_EQ(range_value(-0.7, 1.3, 2001, 701), 0.001);
  EXPECT_EQ(range_value(-0.3, 0.4, 8, 3), 0);
  EXPECT_EQ(range_value(-1e308, 1e308, 3, 1), 0);
  const double third = range_value(0, 1, 4, 1);
  EXPECT_NEAR(third, 1.0 / 3, 4 * 0x1p-54);
  constexpr int doubles = 12;  // as many as there are between the ends
  double before = 1;
  for (int i = 1; i < doubles; ++i) {
    const double value = range_value(1, 1 + (doubles - 1) * 0x1p-52, doubles, i);
    EXPECT_GT(value, before);
    before = value;
  }
}

TEST(SweepSamples, SamplesOfANarrowIntervalDiffer) {
  double before = 0, log_before = 0;
  for (int i = 0; i < 1000; ++i) {
    const double value = uniform_value(0.5, 0.5000000001, i / 1000.0),
                 log_value = log_uniform_value(0.5, 0.5000000001, i / 1000.0);
    EXPECT_GT(value, before);
    EXPECT_GT(log_value, log_before);
    EXPECT_NEAR(value, 0.5 + 1e-10 * i / 1000, 2e-16);
    before = value;
    log_before = log_value;
  }
  // Elsewhere ten digits hide the last bits, which depend on the machine.
  EXPECT_EQ(uniform_value(0.1, 0.4, 1.0 / 3), 0.2);
  EXPECT_EQ(log_uniform_value(1, 2, 0.5), 1.414213562);
  EXPECT_EQ(uniform_value(-1.5e308, 1.5e308, 0.5), 0);
}

TEST(SweepSamples, WholeNumbersOfWideIntervalsAreNotRounded) {
  EXPECT_EQ(uniform_whole(0, 1e12 - 1, 0.123456789012), 123456789012);
}

TEST(SweepSamples, WholeValuesAreEquallyProbable) {
  std::vector<int> hits(10, 0);
  for (int i = 0; i < 1000; ++i) ++hits[static_cast<std::size_t>(uniform_whole(3, 7, i / 1000.0))];
  EXPECT_EQ(hits, (std::vector<int>{0, 0, 0, 200, 200, 200, 200, 200, 0, 0}));
  EXPECT_EQ(log_uniform_whole(1, 8, 0), 1);
  EXPECT_EQ(log_uniform_whole(1, 8, 1 - 0x1p-53), 8);
  EXPECT_EQ(log_uniform_whole(1, 8, 0.5), 3);  // floor(sqrt(9))
}

TEST(SweepSamples, TextsOfValues) {
  EXPECT_EQ(plain_text(R"("a \"b\"")"), "a \"b\"");
  EXPECT_EQ(plain_text("[1, 2]"), "[1, 2]");
  EXPECT_EQ(number_of("1e-3"), 1e-3);
  EXPECT_EQ(number_of("true"), 1);
  EXPECT_EQ(number_of("[1, 2]"), std::nullopt);
}

}  // namespace
}  // namespace weft::sim::sweep_sample_test
