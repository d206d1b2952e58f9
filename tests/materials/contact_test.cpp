#include "materials/contact.h"

#include <gtest/gtest.h>

#include "tests/materials/finite_difference.h"

namespace weft::materials {
namespace {

constexpr double kRange = 2e-3;  // m
constexpr double kStiffness = 500;

// The derivative of one member of a struct of derivatives by its argument.
template <class Function>
double slope_of(const Function& function, double at, double step) {
  const auto value = [&](const Eigen::Matrix<double, 1, 1>& x) {
    return as_matrix(function(x(0, 0)));
  };
  return finite_difference(value, Eigen::Matrix<double, 1, 1>(at), step)(0, 0);
}

BarrierDerivatives at(double gap) { return barrier(gap, kRange, kStiffness); }

TEST(Barrier, HasTheFormOfTheLogBarrier) {
  for (const double fraction : {1e-6, 0.01, 0.5, 0.99}) {
    const double depth = (1 - fraction) * kRange;
    EXPECT_NEAR(at(fraction * kRange).value, -kStiffness * depth * depth * std::log(fraction),
                1e-12 * at(fraction * kRange).value);
  }
}

TEST(Barrier, DerivativesAgreeWithDifferences) {
  for (const double fraction : {1e-6, 1e-3, 0.1, 0.3, 0.5, 0.7, 0.9}) {
    const double gap = fraction * kRange;
    const double step = 1e-3 * gap;
    const BarrierDerivatives exact = at(gap);
    const auto value = [](double g) { return at(g).value; };
    const auto first = [](double g) { return at(g).first; };
    const auto second = [](double g) { return at(g).second; };
    EXPECT_NEAR(slope_of(value, gap, step), exact.first, 1e-9 * std::abs(exact.first));
    EXPECT_NEAR(slope_of(first, gap, step), exact.second, 1e-9 * std::abs(exact.second));
    EXPECT_NEAR(slope_of(second, gap, step), exact.third, 1e-9 * std::abs(exact.third));
  }
}

TEST(Barrier, PushesApartAndIsConvex) {
  for (int step = 1; step < 1000; ++step) {
    const double gap = 1e-3 * step * kRange;
    EXPECT_GT(at(gap).value, 0);
    EXPECT_LT(at(gap).first, 0);
    EXPECT_GT(at(gap).second, 0);
  }
}

// Value, force and stiffness go to zero at the range, the third derivative does not.
TEST(Barrier, IsTwiceSmoothAtTheRange) {
  for (const double gap : {kRange, 1.1 * kRange}) {
    EXPECT_EQ(at(gap).value, 0);
    EXPECT_EQ(at(gap).first, 0);
    EXPECT_EQ(at(gap).second, 0);
    EXPECT_EQ(at(gap).third, 0);
  }
  for (const double closeness : {1e-3, 1e-5, 1e-7}) {
    const BarrierDerivatives inside = at(kRange * (1 - closeness));
    // Taylor about the range with W''' = -6 k / range; log(g / range) has an error of 1e-16.
    EXPECT_NEAR(inside.second, 6 * kStiffness * closeness, 6 * kStiffness * closeness * 1e-2);
    EXPECT_NEAR(inside.first, -3 * kStiffness * kRange * closeness * closeness,
                3 * kStiffness * kRange * closeness * closeness * 1e-2);
    EXPECT_NEAR(inside.third, -6 * kStiffness / kRange, 6 * kStiffness / kRange * 1e-2);
  }
}

TEST(Friction, FactorIsSmoothAndReachesOne) {
  const double e = 0.01;
  for (const double speed : {1e-12, 1e-4, 0.003, 0.0099, 0.02, 5.0}) {
    const FrictionFactor factor = friction_factor(speed, e);
    const double ratio = speed / e;
    const double exact = speed < e ? 2 * ratio - ratio * ratio : 1;
    EXPECT_NEAR(factor.over_speed * speed, exact, 1e-15);
    const auto value = [&](double s) { return s * friction_factor(s, e).over_speed; };
    EXPECT_NEAR(slope_of(value, speed, 1e-3 * std::min(speed, 1e-3)), factor.slope, 1e-6 / e)
        << speed;
  }
  // At rest the factor over the speed is finite; at s = e both the factor and its slope meet.
  EXPECT_EQ(friction_factor(0, e).over_speed, 2 / e);
  const FrictionFactor below = friction_factor(e * (1 - 1e-9), e);
  const FrictionFactor above = friction_factor(e, e);
  EXPECT_NEAR(below.over_speed, above.over_speed, 1e-6);
  EXPECT_NEAR(below.slope, above.slope, 1e-6);
  EXPECT_EQ(above.slope, 0);
}

TEST(Mollifier, GoesSmoothlyFromParallelToCrossing) {
  const double e = 3e-4;
  EXPECT_EQ(edge_edge_mollifier(0, e).value, 0);
  EXPECT_EQ(edge_edge_mollifier(e, e).value, 1);
  EXPECT_EQ(edge_edge_mollifier(2 * e, e).value, 1);
  EXPECT_EQ(edge_edge_mollifier(2 * e, e).first, 0);
  for (const double fraction : {0.05, 0.3, 0.6, 0.95}) {
    const double c = fraction * e;
    const MollifierDerivatives exact = edge_edge_mollifier(c, e);
    EXPECT_NEAR(exact.value, 2 * fraction - fraction * fraction, 1e-15);
    const auto value = [&](double x) { return edge_edge_mollifier(x, e).value; };
    const auto first = [&](double x) { return edge_edge_mollifier(x, e).first; };
    EXPECT_NEAR(slope_of(value, c, 1e-3 * c), exact.first, 1e-10 / e);
    EXPECT_NEAR(slope_of(first, c, 1e-3 * c), exact.second, 1e-10 / (e * e));
  }
  const MollifierDerivatives below = edge_edge_mollifier(e * (1 - 1e-9), e);
  EXPECT_NEAR(below.value, 1, 1e-15);
  EXPECT_NEAR(below.first * e, 0, 1e-8);
}

}  // namespace
}  // namespace weft::materials
