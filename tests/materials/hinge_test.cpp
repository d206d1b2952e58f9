#include "materials/hinge.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/materials/finite_difference.h"
#include "tests/materials/hinge_hessian.h"

namespace weft::materials::hinge_test {
namespace {

constexpr double kPi = std::numbers::pi;

// A hinge of the given angle with a random shape, turned and moved at random.
Nodes4 random_hinge(std::mt19937& generator, double angle) {
  std::uniform_real_distribution<double> uniform(0.5, 1.5);
  const double foot2 = uniform(generator) - 0.5;
  const double foot3 = uniform(generator) - 0.5;
  const double height2 = uniform(generator);
  const double height3 = uniform(generator);
  Nodes4 local;
  local.col(0) = Vec3::Zero();
  local.col(1) = Vec3(uniform(generator), 0, 0);
  local.col(2) = Vec3(foot2, height2, 0);
  local.col(3) = Vec3(foot3, -height3 * std::cos(angle), height3 * std::sin(angle));
  const Vec3 axis = random_matrix<Vec3>(generator).normalized();
  const Mat3 rotation = Eigen::AngleAxisd(3 * uniform(generator), axis).toRotationMatrix();
  Nodes4 result = rotation * local;
  result.colwise() += random_matrix<Vec3>(generator);
  return result;
}

// Returns random angles and those at which naive formulas lose digits: nearly flat, nearly folded.
std::vector<double> angles_to_try(std::mt19937& generator) {
  std::vector<double> angles = {0,     1e-9, -1e-9, 1e-4, -1e-4, 0.01,
                                -0.01, 2.9,  -2.9,  3,    -3,    kPi / 2};
  std::uniform_real_distribution<double> uniform(-3, 3);
  for (int i = 0; i < 100; ++i) angles.push_back(uniform(generator));
  return angles;
}

TEST(Hinge, AngleIsWhatTheHingeWasBuiltWith) {
  std::mt19937 generator(1);
  for (const double angle : angles_to_try(generator)) {
    EXPECT_NEAR(hinge_angle(random_hinge(generator, angle)), angle, 1e-14);
  }
}

TEST(Hinge, AngleIsPositiveForAValley) {
  Nodes4 x;
  x.col(0) = Vec3(0, 0, 0);
  x.col(1) = Vec3(1, 0, 0);
  x.col(2) = Vec3(0, 1, 0);
  x.col(3) = Vec3(0, -1, 0.1);
  EXPECT_GT(hinge_angle(x), 0);
  x(2, 3) = -0.1;
  EXPECT_LT(hinge_angle(x), 0);
}

// Both triangles must have the same angle, whichever comes first.
TEST(Hinge, AngleDoesNotDependOnTheOrderOfTheTriangles) {
  std::mt19937 generator(2);
  for (const double angle : angles_to_try(generator)) {
    const Nodes4 x = random_hinge(generator, angle);
    Nodes4 swapped;
    swapped << x.col(1), x.col(0), x.col(3), x.col(2);
    EXPECT_NEAR(hinge_angle(swapped), hinge_angle(x), 1e-14);
  }
}

TEST(Hinge, GradientIsTheDerivativeOfTheAngle) {
  std::mt19937 generator(3);
  const auto angle_of = [](const Nodes4& x) { return as_matrix(hinge_angle(x)); };
  for (const double angle : angles_to_try(generator)) {
    const Nodes4 x = random_hinge(generator, angle);
    EXPECT_LT(relative_error(finite_difference(angle_of, x, 1e-3),
                             flattened(hinge_gradient(x)).transpose()),
              1e-8)
        << angle;
  }
}

TEST(Hinge, HessianIsTheDerivativeOfTheGradient) {
  std::mt19937 generator(4);
  const auto gradient_of = [](const Nodes4& x) -> Eigen::MatrixXd { return hinge_gradient(x); };
  for (const double angle : angles_to_try(generator)) {
    const Nodes4 x = random_hinge(generator, angle);
    const Eigen::MatrixXd hessian = hinge_hessian(x);
    EXPECT_LT(relative_error(finite_difference(gradient_of, x, 1e-3), hessian), 1e-7) << angle;
    EXPECT_LT((hessian - hessian.transpose()).norm(), 1e-14 * hessian.norm());
  }
}

// No net force, no net moment, and no rate of the angle under a rigid motion.
TEST(Hinge, GradientBalances) {
  std::mt19937 generator(5);
  for (const double angle : angles_to_try(generator)) {
    const Nodes4 x = random_hinge(generator, angle);
    const Nodes4 gradient = hinge_gradient(x);
    EXPECT_LT(gradient.rowwise().sum().norm(), 1e-14 * gradient.norm());
    EXPECT_LT(torque(x, gradient).norm(), 1e-13 * gradient.norm());
    const Nodes4 velocity =
        rigid_velocity(x, random_matrix<Vec3>(generator), random_matrix<Vec3>(generator));
    EXPECT_NEAR(gradient.cwiseProduct(velocity).sum(), 0, 1e-13 * gradient.norm());
  }
}

// A batch of hinges, some of them without area, equals the same hinges one by one.
TEST(Hinge, LanesAreHingesOneByOne) {
  std::mt19937 generator(7);
  NodesOf<Lanes, 4> together;
  NodesOf<Lanes, 3> triangles;
  std::vector<Nodes4> alone;
  for (int lane = 0; lane < lane_count; ++lane) {
    Nodes4 x = random_hinge(generator, 0.5 * lane - 2);
    if (lane == 3) x.col(2) = x.col(0);
    if (lane == 1) x.col(1) = x.col(0);
    for (int i = 0; i < 12; ++i) together.data()[i].values[lane] = x.data()[i];
    for (int i = 0; i < 9; ++i) triangles.data()[i].values[lane] = x.data()[i];
    alone.push_back(x);
  }
  const auto vectors = hinge_vectors(together);
  const auto gradient = hinge_gradient(vectors);
  const auto hessian = hinge_stress<Lanes>(triangles, {1.0, -2.0, 3.0});
  for (int lane = 0; lane < lane_count; ++lane) {
    const Nodes4& x = alone[lane];
    const double scale = std::max(1.0, hinge_gradient(x).norm());
    EXPECT_NEAR(hinge_angle(vectors).values[lane], hinge_angle(x), 1e-14);
    for (int i = 0; i < 12; ++i)
      EXPECT_NEAR(gradient.data()[i].values[lane], hinge_gradient(x).data()[i], 1e-14 * scale);
    const auto one = hinge_stress<double>(x.leftCols<3>(), Vec3(1, -2, 3));
    for (int i = 0; i < 81; ++i)
      EXPECT_NEAR(hessian.data()[i].values[lane], one.data()[i], 1e-13 * (1 + one.norm()));
  }
}

TEST(Hinge, FoldedOntoItselfIsFinite) {
  std::mt19937 generator(6);
  for (int trial = 0; trial < 100; ++trial) {
    const Nodes4 x = random_hinge(generator, trial % 2 == 0 ? kPi : -kPi);
    EXPECT_NEAR(std::abs(hinge_angle(x)), kPi, 1e-7);
    EXPECT_TRUE(hinge_gradient(x).allFinite());
    EXPECT_TRUE(hinge_hessian(x).allFinite());
  }
  Nodes4 exact;
  exact.col(0) = Vec3(0, 0, 0);
  exact.col(1) = Vec3(1, 0, 0);
  exact.col(2) = exact.col(3) = Vec3(0.5, 1, 0);
  EXPECT_NEAR(std::abs(hinge_angle(exact)), kPi, 1e-15);
  EXPECT_TRUE(hinge_gradient(exact).allFinite());
  EXPECT_TRUE(hinge_hessian(exact).allFinite());
}

TEST(Hinge, TrianglesWithoutAreaGiveNothing) {
  const Vec3 origin(0.1, 0.2, 0.3);
  const Vec3 along(0.3, 0.7, 0.1);
  Nodes4 sliver;  // x2 on the line of the edge
  sliver << origin, origin + along, origin + 0.3 * along, Vec3(1, 0, 0);
  Nodes4 point;  // the edge has no length
  point << origin, origin, Vec3(0, 1, 0), Vec3(1, 0, 0);
  Nodes4 other;  // x3 at x0
  other << origin, origin + along, Vec3(1, 0, 0), origin;
  for (const Nodes4& x : {sliver, point, other}) {
    EXPECT_EQ(hinge_angle(x), 0);
    EXPECT_EQ(hinge_gradient(x).norm(), 0);
  }
  const Nodes3 line = sliver.leftCols<3>(), corner = point.leftCols<3>();
  for (const Nodes3& x : {line, corner})
    EXPECT_EQ(hinge_stress<double>(x, Vec3(1, 1, 1)).norm(), 0);
}

// A failure upstream must stay visible.
TEST(Hinge, NotANumberIsHandedOn) {
  Nodes4 x = Nodes4::Random();
  x(1, 2) = std::nan("");
  EXPECT_TRUE(std::isnan(hinge_angle(x)));
  EXPECT_FALSE(hinge_gradient(x).allFinite());
}

}  // namespace
}  // namespace weft::materials::hinge_test
