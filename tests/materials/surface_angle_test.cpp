#include "materials/surface_angle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace weft::materials::surface_angle_test {
namespace {

constexpr int nodes = 5;
using Basis = AngleBasis<nodes>;
using Nodes = NodesOf<double, nodes>;

// Nodes 0 to 2 on the curve, 3 and 4 beside it on either side.
class AnglePoint : public testing::Test {
 protected:
  AnglePoint() {
    basis_.t << -0.7, 0.2, 0.5, 0, 0;
    basis_.a << -0.3, -0.6, -0.1, 1.0, 0;
    basis_.b << -0.4, -0.9, -0.2, 0, 1.5;
    rest_.col(0) = Vec3(0, 0, 0);
    rest_.col(1) = Vec3(1, 0.1, 0.2);
    rest_.col(2) = Vec3(2, -0.1, 0.1);
    rest_.col(3) = Vec3(1.3, 1, 0.4);
    rest_.col(4) = Vec3(0.6, -0.8, 0.6);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-0.3, 0.3);
    x_ = rest_;
    for (int i = 0; i < 3 * nodes; ++i) x_.data()[i] += uniform(random);
    const SurfaceAngle at_rest(basis_, rest_);
    law_ = {2.5, at_rest.cosine(), at_rest.sine()};
  }
  double angle(const Nodes& x) const {
    const SurfaceAngle now(basis_, x);
    return std::atan2(now.sine(), now.cosine());
  }

  Basis basis_;
  Nodes rest_, x_;
  AngleLaw law_;
};

TEST_F(AnglePoint, EnergyIsThatOfTheChangeOfTheAngle) {
  const double change = angle(x_) - angle(rest_);
  EXPECT_GT(std::abs(change), 0.1);
  const SurfaceAngle now(basis_, x_);
  EXPECT_NEAR(now.energy(law_), law_.stiffness * (1 - std::cos(change)), 1e-14);
  EXPECT_NEAR(now.moment(law_), law_.stiffness * std::sin(change), 1e-14);
  EXPECT_NEAR(now.moment_slope(law_), law_.stiffness * std::cos(change), 1e-14);
  EXPECT_EQ(SurfaceAngle(basis_, rest_).energy(law_), 0);
}

// The angle in the plane across a straight curve, whatever the slant of the tangents along it.
TEST(SurfaceAngle, IsTheAngleAcrossTheCurve) {
  for (const double degrees : {-150.0, -90.0, 30.0, 179.0}) {
    const double angle = degrees * std::acos(-1.0) / 180;
    const SurfaceAngle now(Vec3(2, 0, 0), Vec3(0.4, 3, 0),
                           Vec3(-0.7, 1.5 * std::cos(angle), 1.5 * std::sin(angle)));
    EXPECT_NEAR(std::atan2(now.sine(), now.cosine()), angle, 1e-14);
    EXPECT_NEAR(now.width(), 2.25, 1e-14);
    EXPECT_NEAR(now.length(), 2, 1e-14);
  }
}

TEST_F(AnglePoint, DoesNotChangeWhenMovedRigidly) {
  const Eigen::AngleAxisd turn(1.1, Vec3(0.3, -0.5, 0.8).normalized());
  const Nodes moved = (turn.toRotationMatrix() * rest_).colwise() + Vec3(1, 2, 3);
  EXPECT_NEAR(SurfaceAngle(basis_, moved).energy(law_), 0, 1e-28);
}

TEST_F(AnglePoint, GradientAndHessianAreThoseOfTheAngle) {
  constexpr double step = 1e-5;
  const Nodes gradient = SurfaceAngle(basis_, x_).gradient(basis_);
  StencilMatrix<double, nodes> blocks;
  blocks.blocks.fill(Mat3::Zero());
  SurfaceAngle(basis_, x_).add_hessian(1.7, basis_, blocks);
  const auto hessian = blocks.dense();
  for (int c = 0; c < 3 * nodes; ++c) {
    Nodes more = x_, less = x_;
    more.data()[c] += step;
    less.data()[c] -= step;
    EXPECT_NEAR(gradient.data()[c], (angle(more) - angle(less)) / (2 * step), 1e-8) << c;
    const Nodes column = (SurfaceAngle(basis_, more).gradient(basis_) -
                          SurfaceAngle(basis_, less).gradient(basis_)) /
                         (2 * step);
    for (int r = 0; r < 3 * nodes; ++r)
      EXPECT_NEAR(hessian(r, c), 1.7 * column.data()[r], 1e-7) << r << ", " << c;
  }
}

TEST_F(AnglePoint, HasNoMomentWhereASurfaceIsParallelToTheCurve) {
  const SurfaceAngle now(Vec3(1, 0, 0), Vec3(2, 0, 0), Vec3(0, 1, 0));
  EXPECT_TRUE(now.gradient(basis_).allFinite());
  EXPECT_EQ(now.moment(law_), 0);
  EXPECT_EQ(now.moment_slope(law_), 0);
}

}  // namespace
}  // namespace weft::materials::surface_angle_test
