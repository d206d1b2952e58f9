#include "materials/contact.h"

#include <gtest/gtest.h>

#include "tests/materials/finite_difference.h"

namespace weft::materials::contact_test {
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

TEST(BouncingPush, DerivativesAgreeWithDifferences) {
  const double speed = 0.01;
  for (const double e : {0.0, 0.5, 1.0}) {
    for (const double fraction : {0.05, 0.5, 0.95}) {
      for (const double rate : {-1.0, -0.009, -0.004, 0.0, 0.003, 0.0099, 2.0}) {
        const double gap = fraction * kRange;
        const DampedPush exact = bouncing_push(at(gap), e, speed, rate);
        const auto by_gap = [&](double g) { return bouncing_push(at(g), e, speed, rate).force; };
        const auto by_rate = [&](double u) { return bouncing_push(at(gap), e, speed, u).force; };
        EXPECT_NEAR(slope_of(by_gap, gap, 1e-3 * gap), -exact.stiffness,
                    1e-8 * std::abs(at(gap).second));
        EXPECT_NEAR(slope_of(by_rate, rate, 1e-6), -exact.damping,
                    1e-7 * std::abs(at(gap).first) / speed);
        EXPECT_GE(exact.force, 0);
        EXPECT_LE((exact.force + at(gap).first) * rate, 0) << "adds energy";
      }
    }
  }
  EXPECT_EQ(bouncing_push(at(kRange), 0.5, speed, -1).force, 0);
}

// A mass hits a wall. The equation of motion is solved by velocity Verlet with tiny steps.
TEST(BouncingPush, PartsWithTheRestitution) {
  for (const double e : {0.2, 0.5, 0.8, 1.0}) {
    for (const double mass : {1e-4, 1e-2}) {
      const double strength = mass * 4 / (kRange * kRange), step = 1e-8;
      const auto acceleration = [&](double gap, double rate) {
        return bouncing_push(barrier(gap, kRange, strength), e, 0.004, rate).force / mass;
      };
      double gap = kRange, rate = -2;
      while (gap <= kRange && rate < 2) {
        const double middle = rate + 0.5 * step * acceleration(gap, rate);
        gap += step * middle;
        rate = middle + 0.5 * step * acceleration(gap, middle);
      }
      EXPECT_NEAR(rate / 2, e, 1e-3 * e + 1e-4) << mass;
    }
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
  // At rest the factor over the speed is finite; at s = e the factor and its slope are continuous.
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

constexpr double kDampingTime = 1e-3;  // s

DampedPush push_at(double gap, double rate) {
  return damped_push(at(gap), gap, kRange, kDampingTime, rate);
}

TEST(DampedPush, NeverPullsAndNeverPushesMoreThanTheBarrierWhereSurfacesPart) {
  for (int step = 1; step < 1200; ++step) {
    const double gap = 1e-3 * step * kRange, push = -at(gap).first;
    for (const double rate : {1e-6, 1e-3, 0.01, 0.1, 0.3, 1.0, 2.0, 50.0}) {
      EXPECT_GE(push_at(gap, rate).force, 0) << gap << " " << rate;
      EXPECT_LE(push_at(gap, rate).force, push) << gap << " " << rate;
      EXPECT_GE(push_at(gap, -rate).force, push) << gap << " " << rate;
      EXPECT_GE(push_at(gap, rate).damping, 0) << gap << " " << rate;
    }
  }
  EXPECT_EQ(push_at(0.4 * kRange, 2.0).force, 0);
}

TEST(DampedPush, IsTheBarrierAtRestAndDampsInProportionToItsStiffness) {
  for (const double fraction : {0.01, 0.3, 0.5, 0.8}) {
    const double gap = fraction * kRange;
    EXPECT_EQ(push_at(gap, 0).force, -at(gap).first);
    EXPECT_EQ(push_at(gap, 0).stiffness, at(gap).second);
    const double damping = (push_at(gap, -0.2).force - push_at(gap, 0).force) / 0.2;
    EXPECT_NEAR(damping, kDampingTime * at(gap).second, 0.06 * damping);
  }
}

TEST(DampedPush, SlopesAgreeWithDifferences) {
  for (const double fraction : {0.02, 0.3, 0.5, 0.9, 0.985, 0.999}) {
    for (const double rate : {-3.0, -0.1, -0.001, 0.001, 0.05, 0.2}) {
      const double gap = fraction * kRange, scale = at(gap).second;
      const double by_gap =
          slope_of([&](double g) { return push_at(g, rate).force; }, gap, 1e-5 * (kRange - gap));
      const double by_rate =
          slope_of([&](double r) { return push_at(gap, r).force; }, rate, 1e-6 * std::abs(rate));
      EXPECT_NEAR(push_at(gap, rate).stiffness, -by_gap, 1e-6 * scale * (1 + std::abs(rate)));
      EXPECT_NEAR(push_at(gap, rate).damping, -by_rate, 1e-6 * kDampingTime * scale);
    }
  }
}

// Both slopes are continuous where the push ends: at the range, at rest, and where surfaces part so
// fast that the push vanishes.
TEST(DampedPush, IsSmoothWhereItChanges) {
  const double scale = at(0.5 * kRange).second;
  for (const double rate : {-5.0, -0.3, 0.002}) {
    EXPECT_NEAR(push_at(kRange * (1 - 1e-9), rate).stiffness, 0, 1e-4 * scale) << rate;
    EXPECT_EQ(push_at(kRange, rate).force, 0);
  }
  const double gap = 0.5 * kRange;
  const double release = -at(gap).first / push_at(gap, 0).damping;
  for (const double edge : {0.0, release}) {
    const DampedPush below = push_at(gap, edge - 1e-9), above = push_at(gap, edge + 1e-9);
    EXPECT_NEAR(below.force, above.force, 1e-8 * -at(gap).first);
    EXPECT_NEAR(below.stiffness, above.stiffness, 1e-6 * scale);
    EXPECT_NEAR(below.damping, above.damping, 1e-6 * kDampingTime * scale);
  }
  EXPECT_EQ(push_at(gap, 1.001 * release).force, 0);
}

// Returns the restitution of a particle of mass m thrown against the barrier: its speed afterwards
// over that before, integrated here in small steps.
double restitution(double mass, double speed) {
  double gap = kRange, rate = -speed;
  const double step = 1e-8;
  while (gap <= kRange) {
    const double middle = rate + step / 2 * push_at(gap, rate).force / mass;
    gap += step * middle;
    rate = middle + step / 2 * push_at(gap, middle).force / mass;
  }
  return rate / speed;
}

// The table of docs/theory.md, section 7: cloth of 0.2 kg/m^2 at the default stiffness, range and
// damping time.
TEST(DampedPush, RestitutionFallsWithSpeedAsTheTableSays) {
  const double mass = kStiffness / 1e6 * 0.2;
  for (const auto& [speed, expected] : {std::pair(0.01, 0.701), std::pair(0.1, 0.321),
                                        std::pair(1.0, 0.118), std::pair(5.0, 0.051)}) {
    EXPECT_NEAR(restitution(mass, speed), expected, 1e-3) << speed;
  }
}

}  // namespace
}  // namespace weft::materials::contact_test
