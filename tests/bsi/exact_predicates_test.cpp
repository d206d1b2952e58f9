// Signs of determinants of nearly degenerate points, against integers of any length.
#include "bsi/detail/exact_predicates.h"

#include <gtest/gtest.h>

#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <random>

namespace weft::bsi::exact_predicates_test {
namespace {

using Integer = boost::multiprecision::cpp_int;

// Coordinates are multiples of 2^-bits: as fine as doubles above 1/4 are, so that products of their
// differences are inexact.
constexpr int bits = 54;

double rounded(double value) { return std::ldexp(std::floor(std::ldexp(value, bits)), -bits); }
Integer exact(double value) { return Integer(static_cast<long long>(std::ldexp(value, bits))); }
int sign(const Integer& value) { return value > 0 ? 1 : value < 0 ? -1 : 0; }

template <std::size_t size>
std::array<double, size> random_point(std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(0.25, 1);
  std::array<double, size> point;
  for (double& x : point) x = rounded(uniform(random));
  return point;
}

// The last point is on the line through the others but for rounding to the grid.
TEST(ExactPredicates, OrientationOfThreePointsHasTheExactSign) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(0.25, 1);
  int zeros = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    const Point2 a = random_point<2>(random), b = random_point<2>(random);
    const double t = uniform(random);
    const Point2 c{rounded(a[0] + t * (b[0] - a[0])), rounded(a[1] + t * (b[1] - a[1]))};
    const auto side = [&](const Point2& p, int k) { return Integer(exact(p[k]) - exact(c[k])); };
    const int expected = sign(side(a, 0) * side(b, 1) - side(a, 1) * side(b, 0));
    ASSERT_EQ(orientation(a, b, c), expected) << trial;
    ASSERT_EQ(orientation(b, a, c), -expected) << trial;
    ASSERT_EQ(orientation(a, b, a), 0);
    zeros += expected == 0 ? 1 : 0;
  }
  EXPECT_LT(zeros, 20000);
}

// The last point is in the plane of the others but for rounding to the grid.
TEST(ExactPredicates, OrientationOfFourPointsHasTheExactSign) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> uniform(0.25, 1);
  for (int trial = 0; trial < 10000; ++trial) {
    std::array<Point3, 4> p;
    for (int i = 0; i < 3; ++i) p[i] = random_point<3>(random);
    const double s = uniform(random), t = uniform(random) * (1 - s);
    for (int k = 0; k < 3; ++k)
      p[3][k] = rounded(p[0][k] + s * (p[1][k] - p[0][k]) + t * (p[2][k] - p[0][k]));
    std::array<std::array<Integer, 3>, 3> m;
    for (int row = 0; row < 3; ++row) {
      for (int k = 0; k < 3; ++k) m[row][k] = exact(p[row][k]) - exact(p[3][k]);
    }
    const Integer determinant = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                                m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                                m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    const int expected = sign(determinant);
    ASSERT_EQ(orientation(p[0], p[1], p[2], p[3]), expected) << trial;
    ASSERT_EQ(orientation(p[1], p[0], p[2], p[3]), -expected) << trial;
    ASSERT_EQ(orientation(p[0], p[1], p[2], p[1]), 0);
  }
}

}  // namespace
}  // namespace weft::bsi::exact_predicates_test
