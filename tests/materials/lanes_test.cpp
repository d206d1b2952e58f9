// Formulas on batches of numbers, against formulas on single numbers.
#include "materials/lanes.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <random>

namespace weft::materials::lanes_test {
namespace {

double ulp(double value) {
  value = std::fabs(value);
  return std::nextafter(value, std::numeric_limits<double>::infinity()) - value;
}

// Uses equal lanes; OfDifferentLanes compares different ones.
double arc_tangent_of_lanes(double y, double x) {
  return arc_tangent(Lanes(y), Lanes(x)).values[lane_count - 1];
}

// Units in the last place between the two, of the exact angle in long double.
double error_in_ulp(double y, double x) {
  const long double exact = std::atan2(static_cast<long double>(y), static_cast<long double>(x));
  const auto error = static_cast<double>(arc_tangent_of_lanes(y, x) - exact);
  return std::fabs(error) / ulp(static_cast<double>(exact));
}

TEST(ArcTangent, RoundTheCircle) {
  std::mt19937_64 generator(1);
  std::uniform_real_distribution<double> angle(-std::numbers::pi, std::numbers::pi);
  std::uniform_real_distribution<double> exponent(-100, 100);
  double worst = 0;
  for (int i = 0; i < 1000000; ++i) {
    const double a = angle(generator), radius = std::pow(10, exponent(generator));
    worst = std::max(worst, error_in_ulp(radius * std::sin(a), radius * std::cos(a)));
  }
  EXPECT_LT(worst, 2);
}

TEST(ArcTangent, NearTheAxesAndWhereOctantsMeet) {
  std::mt19937_64 generator(2);
  std::uniform_real_distribution<double> exponent(-100, 0);
  double worst = 0;
  for (int i = 0; i < 100000; ++i) {
    const double small = std::pow(10, exponent(generator));
    for (const double to : {0.0, 0.66, 1.0}) {
      for (const double side : {-1.0, 1.0}) {
        for (const double width : {-1.0, 1.0}) {
          for (const double sign : {-1.0, 1.0}) {
            const double height = sign * (to + side * small);
            worst = std::max({worst, error_in_ulp(height, width), error_in_ulp(width, height)});
          }
        }
      }
    }
  }
  EXPECT_LT(worst, 2);
}

TEST(ArcTangent, OnTheAxes) {
  constexpr double pi = std::numbers::pi;
  EXPECT_EQ(arc_tangent_of_lanes(0, 0), 0);
  EXPECT_EQ(arc_tangent_of_lanes(0, 3), 0);
  EXPECT_EQ(arc_tangent_of_lanes(0, -3), pi);
  EXPECT_EQ(arc_tangent_of_lanes(3, 0), pi / 2);
  EXPECT_EQ(arc_tangent_of_lanes(-3, 0), -pi / 2);
  EXPECT_EQ(arc_tangent_of_lanes(2, 2), pi / 4);
  EXPECT_EQ(arc_tangent_of_lanes(-2, 2), -pi / 4);
}

TEST(ArcTangent, HandsOnWhatIsNoNumber) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(arc_tangent_of_lanes(nan, 1)));
  EXPECT_TRUE(std::isnan(arc_tangent_of_lanes(1, nan)));
  EXPECT_TRUE(std::isnan(arc_tangent_of_lanes(nan, 0)));
}

TEST(ArcTangent, OfDifferentLanes) {
  const auto angle = [](int octant) { return 0.8 * octant - 3; };  // one in each
  for (int first = 0; first < 8; first += lane_count) {
    Lanes y, x;
    for (int lane = 0; lane < lane_count; ++lane) {
      y.values[lane] = std::sin(angle(first + lane));
      x.values[lane] = std::cos(angle(first + lane));
    }
    const Lanes angles = arc_tangent(y, x);
    for (int lane = 0; lane < lane_count; ++lane)
      EXPECT_NEAR(angles.values[lane], angle(first + lane), 1e-15);
  }
}

TEST(Lanes, VectorsInMemoryAreReadAndAddedLaneByLane) {
  std::array<double, 3 * lane_count + 2> numbers{};  // not aligned, and something behind
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<double>(100 + i);
  const auto loaded = load_vectors(numbers.data() + 1);
  for (int lane = 0; lane < lane_count; ++lane) {
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_EQ(loaded[axis].values[lane], 101 + 3 * lane + axis);
  }
  std::array<Lanes, 3> added;
  for (int axis = 0; axis < 3; ++axis) {
    for (int lane = 0; lane < lane_count; ++lane)
      added[axis].values[lane] = 1000 * (axis + 1) + lane * lane;
  }
  add_vectors(added, numbers.data() + 1);
  EXPECT_EQ(numbers.front(), 100);
  EXPECT_EQ(numbers.back(), 101 + 3 * lane_count);
  for (int lane = 0; lane < lane_count; ++lane) {
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(numbers[1 + 3 * lane + axis],
                101 + 3 * lane + axis + 1000 * (axis + 1) + lane * lane);
    }
  }
}

TEST(Lanes, Threefold) {
  Lanes numbers;
  for (int lane = 0; lane < lane_count; ++lane) numbers.values[lane] = 10 + lane;
  const auto each = threefold(numbers);
  for (int i = 0; i < 3 * lane_count; ++i)
    EXPECT_EQ(each[i / lane_count].values[i % lane_count], 10 + i / 3);
}

TEST(Lanes, MoveUpByOne) {
  Lanes before, numbers;
  for (int lane = 0; lane < lane_count; ++lane) {
    before.values[lane] = 100 + lane;
    numbers.values[lane] = 10 + lane;
  }
  const Lanes moved = moved_up(before, numbers);
  for (int lane = 0; lane < lane_count; ++lane)
    EXPECT_EQ(moved.values[lane], lane == 0 ? 99 + lane_count : 9 + lane);
}

}  // namespace
}  // namespace weft::materials::lanes_test
