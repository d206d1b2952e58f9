#include "materials/drag.h"

#include <gtest/gtest.h>

#include "tests/materials/finite_difference.h"

namespace weft::materials::drag_test {
namespace {

constexpr int kTrials = 100;
const Drag kDrag{1.2 * 1.28, 1.2 * 0.05};
const Nodes3 kPlate{{0, 2, 0}, {0, 0, 3}, {1, 1, 1}};  // area 3 m^2, normal z

TEST(Drag, PlateFacingTheWindAndAlongIt) {
  const double speed = 4;
  const Nodes3 rest = Nodes3::Zero();
  const Vec3 facing = drag_force<double>(kDrag, kPlate, rest, {0, 0, -speed});
  EXPECT_NEAR(facing.z(), -0.5 * kDrag.normal * 3 * speed * speed, 1e-12);
  EXPECT_EQ(facing.head<2>().norm(), 0);
  const Vec3 along = drag_force<double>(kDrag, kPlate, rest, {speed, 0, 0});
  EXPECT_NEAR(along.x(), 0.5 * kDrag.tangential * 3 * speed * speed, 1e-12);
  EXPECT_EQ(along.tail<2>().norm(), 0);
}

TEST(Drag, OnlyTheRelativeWindCountsAndNeitherSideIsTheFront) {
  std::mt19937 generator(1);
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto x = random_matrix<Nodes3>(generator);
    auto v = random_matrix<Nodes3>(generator);
    const auto wind = random_matrix<Vec3>(generator);
    const auto shift = random_matrix<Vec3>(generator);
    const Vec3 force = drag_force<double>(kDrag, x, v, wind);
    Nodes3 turned;
    turned << x.col(1), x.col(0), x.col(2);
    EXPECT_LT((drag_force<double>(kDrag, turned, v, wind) - force).norm(), 1e-14);
    v.colwise() += shift;
    EXPECT_LT((drag_force<double>(kDrag, x, v, wind + shift) - force).norm(), 1e-13);
  }
}

TEST(Drag, TakesEnergyInStillAir) {
  std::mt19937 generator(2);
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto x = random_matrix<Nodes3>(generator);
    const auto v = random_matrix<Nodes3>(generator);
    EXPECT_LT(drag_force<double>(kDrag, x, v, Vec3::Zero()).dot(v.rowwise().mean()), 0);
  }
}

// A plate of mass m falling flat: m g = rho/2 C A v^2. Explicit steps from rest must end there.
TEST(Drag, FallsAtTheTerminalVelocity) {
  const double mass = 0.5;
  const double gravity = 9.81;
  const double terminal = std::sqrt(2 * mass * gravity / (kDrag.normal * 3));
  double speed = 0;
  for (int step = 0; step < 20000; ++step) {
    Nodes3 v = Nodes3::Zero();
    v.row(2).setConstant(-speed);
    const double lift = drag_force<double>(kDrag, kPlate, v, Vec3::Zero()).z();
    speed += 1e-3 * (gravity - lift / mass);
  }
  EXPECT_NEAR(speed, terminal, 1e-10 * terminal);
}

TEST(Drag, DampingIsExactAlongTheWindAndForNormalAndParallelFlow) {
  std::mt19937 generator(3);
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto x = random_matrix<Nodes3>(generator);
    const auto v = random_matrix<Nodes3>(generator);
    const Vec3 mean = v.rowwise().mean();
    const Vec3 normal = Vec3(x.col(1) - x.col(0)).cross(Vec3(x.col(2) - x.col(0))).normalized();
    const Vec3 in_plane = (x.col(1) - x.col(0)).normalized();
    for (const Vec3& relative : {normal, in_plane, Vec3(random_matrix<Vec3>(generator))}) {
      const Vec3 wind = mean + 3 * relative;
      // The derivative by the wind is minus that by the velocity of the centroid.
      const auto force = [&](const Vec3& w) -> Eigen::MatrixXd {
        return drag_force<double>(kDrag, x, v, w);
      };
      const Mat3 exact = finite_difference(force, wind);
      const Mat3 damping = drag_damping<double>(kDrag, x, v, wind);
      EXPECT_LT(((damping - exact) * relative).norm(), 1e-9 * exact.norm());
      if (relative == normal || relative == in_plane) {
        EXPECT_LT(relative_error(damping, exact), 1e-9);
      }
    }
  }
}

// Only the mean of the nodes' velocities matters.
TEST(Drag, NodeVelocitiesShareTheDamping) {
  std::mt19937 generator(4);
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto x = random_matrix<Nodes3>(generator);
    const Vec3 normal = Vec3(x.col(1) - x.col(0)).cross(Vec3(x.col(2) - x.col(0))).normalized();
    const Nodes3 v = (-2 * normal).replicate<1, 3>();
    const auto force = [&](const Nodes3& u) -> Eigen::MatrixXd {
      return -drag_force<double>(kDrag, x, u, Vec3::Zero());
    };
    const Eigen::Matrix<double, 3, 9> exact =
        (drag_damping<double>(kDrag, x, v, Vec3::Zero()) / 3).replicate<1, 3>();
    EXPECT_LT(relative_error(finite_difference(force, v), exact), 1e-9);
  }
}

TEST(Drag, DampingIsSymmetricAndPositive) {
  std::mt19937 generator(5);
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto x = random_matrix<Nodes3>(generator);
    const Drag drag = trial % 2 == 0 ? kDrag : Drag{kDrag.normal, 0};
    const Mat3 damping = drag_damping<double>(drag, x, random_matrix<Nodes3>(generator), {1, 2, 3});
    EXPECT_LT((damping - damping.transpose()).norm(), 1e-14 * damping.norm());
    EXPECT_GT(eigenvalues(damping)[0], -1e-13 * damping.norm());
  }
}

TEST(Drag, NothingWithoutAreaOrWind) {
  const Nodes3 point = Vec3(1, 2, 3).replicate<1, 3>();
  const Nodes3 rest = Nodes3::Zero();
  EXPECT_EQ(drag_force<double>(kDrag, point, rest, {1, 2, 3}).norm(), 0);
  EXPECT_EQ(drag_damping<double>(kDrag, point, rest, {1, 2, 3}).norm(), 0);
  EXPECT_EQ(drag_force<double>(kDrag, kPlate, rest, Vec3::Zero()).norm(), 0);
  EXPECT_EQ(drag_damping<double>(kDrag, kPlate, rest, Vec3::Zero()).norm(), 0);
}

}  // namespace
}  // namespace weft::materials::drag_test
