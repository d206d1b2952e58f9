// The Newton system of the velocities and its diagonal blocks against dense solutions.
#include "sim/solver/velocity_system.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cstdlib>
#include <memory>
#include <numeric>
#include <vector>

#include "sim/case/case_reader.h"
#include "sim/scene/scene.h"

namespace weft::sim::velocity_system_test {
namespace {

constexpr double gamma = 1e-3;  // s

// A sheet that is bent and stretched, with damping and a pinned row.
class BentSheet {
 public:
  BentSheet()
      : scene_(build_scene(parse_case(R"([contact]
enabled = false
[material.cloth]
membrane_stiffness = 100
bending_stiffness = 1e-3
stiffness_damping = 1e-3
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [6, 7] }
[[body.pin]]
edges = ["first_row"]
)",
                                      "test.toml", {}))),
        dynamics_(*scene_, statistics_),
        system_(dynamics_) {
    std::vector<double> state = dynamics_.initial_state();
    auto* const x = reinterpret_cast<Vec3*>(state.data());
    for (int i = 0; i < dynamics_.particle_count(); ++i)
      if (scene_->pinned[i] == 0) x[i] += Vec3(0.2 * x[i].x(), 0, 3 * x[i].x() * x[i].y());
    dynamics_.assemble(0, state);
    system_.set_up(gamma);
  }

  int count() const { return dynamics_.particle_count(); }
  bool is_free(int i) const { return scene_->pinned[i] == 0; }
  // Returns dv for the right-hand side (b_x, 0) and weights of 1.
  Eigen::VectorXd solved(const Eigen::VectorXd& position) {
    std::vector<double> b(6 * count(), 0.0), correction(b.size());
    std::copy(position.begin(), position.end(), b.begin());
    const std::vector<double> weight(b.size(), 1.0);
    const auto outcome =
        system_.solve(gamma, b, weight, {.residual = 1e-9 * position.norm()}, correction);
    EXPECT_TRUE(outcome.converged);
    return Eigen::Map<const Eigen::VectorXd>(correction.data() + 3 * count(), 3 * count());
  }
  // Returns the same from dense matrices.
  Eigen::VectorXd expected(const Eigen::VectorXd& position) const {
    const int size = 3 * count();
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(size, size), stiffness = a;
    const BlockPattern& pattern = dynamics_.stiffness().pattern();
    for (int row = 0; row < count(); ++row) {
      for (int slot = pattern.row_begin(row); slot < pattern.row_end(row); ++slot) {
        const int column = pattern.column(slot);
        stiffness.block<3, 3>(3 * row, 3 * column) = dynamics_.stiffness().block(row, slot);
        a.block<3, 3>(3 * row, 3 * column) = gamma * dynamics_.damping().block(row, slot);
      }
      a.diagonal().segment<3>(3 * row).array() += scene_->mass[row];
    }
    a += gamma * gamma * stiffness;
    Eigen::VectorXd right = -gamma * stiffness * position;
    for (int i = 0; i < count(); ++i) {
      if (is_free(i)) continue;
      a.middleRows<3>(3 * i).setZero();
      a.middleCols<3>(3 * i).setZero();
      a.diagonal().segment<3>(3 * i).setOnes();
      right.segment<3>(3 * i).setZero();
    }
    return a.ldlt().solve(right);
  }

 private:
  std::unique_ptr<const Scene> scene_;
  Statistics statistics_;
  Dynamics dynamics_;
  VelocitySystem system_;
};

// Returns position residuals of which each is `share` of gamma times the tolerance of velocities,
// zero for pinned particles.
Eigen::VectorXd residuals(const BentSheet& sheet, double share) {
  Eigen::VectorXd b = Eigen::VectorXd::Zero(3 * sheet.count());
  for (int i = 0; i < sheet.count(); ++i) {
    if (sheet.is_free(i))
      b.segment<3>(3 * i) = share * gamma * Eigen::Vector3d(0.6, i % 2 == 0 ? 0.64 : -0.64, 0.48);
  }
  return b;
}

TEST(VelocitySystem, CountsResidualsOfPositions) {
  BentSheet sheet;
  for (const double share : {1.0, 1e-3, 3e-6}) {
    const Eigen::VectorXd b = residuals(sheet, share), expected = sheet.expected(b);
    EXPECT_GT(expected.norm(), 0.1 * b.norm() / gamma) << share;
    EXPECT_LT((sheet.solved(b) - expected).norm(), 1e-4 * expected.norm()) << share;
  }
}

// Residuals of positions below a millionth of the tolerance are left out. The solution depends on
// them by no more than the residuals divided by gamma.
TEST(VelocitySystem, LeavesOutRoundingErrorsOfPositions) {
  BentSheet sheet;
  const Eigen::VectorXd b = residuals(sheet, 0.9e-6);
  EXPECT_EQ(sheet.solved(b).norm(), 0);
  EXPECT_LT(sheet.expected(b).norm(), b.norm() / gamma);
}

// One residual that is larger than the bound is enough.
TEST(VelocitySystem, CountsSingleResidualsOfPositions) {
  BentSheet sheet;
  Eigen::VectorXd b = Eigen::VectorXd::Zero(3 * sheet.count());
  b[3 * (sheet.count() - 2)] = 0.1 * gamma;
  const Eigen::VectorXd expected = sheet.expected(b);
  EXPECT_LT((sheet.solved(b) - expected).norm(), 1e-4 * expected.norm());
}

TEST(BlockJacobi, InvertsDefiniteBlocksAlone) {
  std::srand(1);  // NOLINT(cert-msc51-cpp): any numbers will do
  int definite = 0;
  for (int i = 0; i < 1000; ++i) {
    const Mat3 any = Mat3::Random();
    const Mat3 block = any + any.transpose() + 1.5 * Mat3::Identity();
    const bool is_definite = Eigen::SelfAdjointEigenSolver<Mat3>(block).eigenvalues()[0] > 0;
    Mat3 inverse = Mat3::Constant(7);
    EXPECT_EQ(invert_definite(block, inverse), is_definite);
    if (is_definite) {
      ++definite;
      EXPECT_LT((block * inverse - Mat3::Identity()).norm(), 1e-12 * block.norm() * inverse.norm());
    } else {
      EXPECT_EQ(inverse, Mat3::Constant(7));
    }
  }
  EXPECT_GT(definite, 200);
  EXPECT_LT(definite, 800);
}

// A stiff pair on a light vertex, by the formula of Sherman and Morrison.
TEST(BlockJacobi, InvertsBlocksOfStiffPairs) {
  std::srand(1);  // NOLINT(cert-msc51-cpp): any numbers will do
  for (const double ratio : {1e4, 1e8, 1e10}) {
    for (int i = 0; i < 200; ++i) {
      const Vec3 normal = Vec3::Random().normalized();
      const Mat3 pair = normal * normal.transpose();
      Mat3 inverse = Mat3::Zero();
      ASSERT_TRUE(invert_definite(Mat3::Identity() + ratio * pair, inverse)) << ratio;
      const Mat3 expected = Mat3::Identity() - ratio / (1 + ratio) * pair;
      EXPECT_LT((inverse - expected).norm(), 1e-14 * ratio) << ratio;
      EXPECT_GT(Eigen::SelfAdjointEigenSolver<Mat3>(inverse).eigenvalues()[0], 0) << ratio;
    }
  }
}

}  // namespace
}  // namespace weft::sim::velocity_system_test
