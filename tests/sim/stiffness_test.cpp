// The matrices of the forces: their storage, and the terms left out of semi-definite ones.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "sim/case/case_reader.h"
#include "sim/motion/dynamics.h"
#include "tests/dense_algebra.h"

namespace weft::sim::stiffness_test {
namespace {

TEST(BlockMatrix, HalfOfItIsAllOfIt) {
  constexpr int rows = 40;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> entry(-1, 1);
  std::vector<std::vector<int>> neighbours(rows);
  for (int k = 0; k < 150; ++k) {
    const int a = static_cast<int>(random() % rows), b = static_cast<int>(random() % rows);
    neighbours[a].push_back(b);
    neighbours[b].push_back(a);
  }
  BlockMatrix matrix(std::make_shared<const BlockPattern>(neighbours));
  const BlockPattern& pattern = matrix.pattern();
  ASSERT_EQ(2 * pattern.upper_count(), pattern.block_count() + rows);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(3 * rows, 3 * rows);
  for (int row = 0; row < rows; ++row) {
    for (int slot = pattern.diagonal_slot(row); slot < pattern.row_end(row); ++slot) {
      Mat3 block = Mat3::NullaryExpr([&] { return entry(random); });
      if (pattern.column(slot) == row) block = Mat3(block + block.transpose());
      matrix.upper_block(pattern.upper(row, slot)) = block;
      dense.block<3, 3>(3 * row, 3 * pattern.column(slot)) = block;
      dense.block<3, 3>(3 * pattern.column(slot), 3 * row) = block.transpose();
    }
  }
  for (int row = 0; row < rows; ++row) {
    for (int slot = pattern.row_begin(row); slot < pattern.row_end(row); ++slot)
      EXPECT_EQ(matrix.block(row, slot), (dense.block<3, 3>(3 * row, 3 * pattern.column(slot))));
  }
  std::vector<Vec3> in(rows), out(rows);
  for (Vec3& v : in) v = Vec3::NullaryExpr([&] { return entry(random); });
  matrix.multiply(in, out, 1);
  const Eigen::VectorXd expected = dense * Eigen::Map<Eigen::VectorXd>(in[0].data(), 3 * rows);
  EXPECT_LT((expected - Eigen::Map<Eigen::VectorXd>(out[0].data(), 3 * rows)).norm(), 1e-13);
}

// A sheet of 5 x 5 vertices out of its plane and stretched by a factor.
class Sheet {
 public:
  Sheet(const std::string& material, double factor)
      : scene_(build_scene(parse_case("[contact]\nenabled = false\n[material.cloth]\n" + material +
                                          R"(
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [5, 5] }
)",
                                      "test.toml", {}))),
        dynamics_(*scene_, statistics_),
        state_(dynamics_.initial_state()) {
    auto* x = reinterpret_cast<Vec3*>(state_.data());
    for (int i = 0; i < dynamics_.particle_count(); ++i) {
      x[i] *= factor;
      x[i].z() += 0.05 * std::sin(5 * x[i].x() + 3 * x[i].y());
    }
  }

  Dynamics& dynamics() { return dynamics_; }
  std::vector<double>& state() { return state_; }

  Eigen::MatrixXd stiffness(Definiteness definiteness) {
    dynamics_.assemble(0, state_, definiteness);
    const int count = dynamics_.particle_count();
    Eigen::MatrixXd dense(3 * count, 3 * count);
    std::vector<Vec3> in(count, Vec3::Zero()), out(count);
    for (int i = 0; i < 3 * count; ++i) {
      in[i / 3][i % 3] = 1;
      dynamics_.stiffness().multiply(in, out, 1);
      in[i / 3].setZero();
      dense.col(i) = Eigen::Map<const Eigen::VectorXd>(out[0].data(), 3 * count);
    }
    return dense;
  }
  // -dF/dx by central differences of M v'.
  Eigen::MatrixXd differences() {
    const int count = dynamics_.particle_count();
    constexpr double step = 1e-6;
    Eigen::MatrixXd dense(3 * count, 3 * count);
    std::vector<double> plus(state_.size()), minus(state_.size());
    for (int i = 0; i < 3 * count; ++i) {
      const double x = state_[i];
      state_[i] = x + step;
      EXPECT_FALSE(dynamics_.rate(0, state_, plus));
      state_[i] = x - step;
      EXPECT_FALSE(dynamics_.rate(0, state_, minus));
      state_[i] = x;
      for (int k = 0; k < 3 * count; ++k)
        dense(k, i) =
            -scene_->mass[k / 3] * (plus[3 * count + k] - minus[3 * count + k]) / (2 * step);
    }
    return dense;
  }

 private:
  std::unique_ptr<const Scene> scene_;
  Statistics statistics_;
  Dynamics dynamics_;
  std::vector<double> state_;
};

const std::vector<std::string> materials{"membrane_stiffness = 100",
                                         "membrane_stiffness = 100\nmembrane = \"springs\"",
                                         "membrane_stiffness = 100\nbending_stiffness = 0.5"};

TEST(Stiffness, ExactOneIsTheDerivativeOfTheForces) {
  for (const std::string& material : materials) {
    for (const double factor : {0.8, 1.3}) {
      Sheet sheet(material, factor);
      const Eigen::MatrixXd exact = sheet.stiffness(Definiteness::exact);
      EXPECT_LT((exact - sheet.differences()).norm(), 1e-6 * exact.norm()) << material << factor;
    }
  }
}

TEST(Stiffness, SemiDefiniteOneHasNoNegativeEigenvalueWhereTheExactOneHas) {
  for (const std::string& material : materials) {
    Sheet sheet(material, 0.8);
    const Eigen::MatrixXd exact = sheet.stiffness(Definiteness::exact);
    EXPECT_LT(eigenvalues(exact)[0], -1e-2 * exact.norm()) << material;
    EXPECT_GT(eigenvalues(sheet.stiffness(Definiteness::semi_definite))[0], -1e-12 * exact.norm())
        << material;
  }
}

// Only springs show this: edges opposite right angles of triangles are compressed at once, and
// bending leaves out the part of its stress in any case.
TEST(Stiffness, SemiDefiniteOneIsExactWhereNothingIsCompressed) {
  Sheet sheet(materials[1], 1.3);
  const Eigen::MatrixXd exact = sheet.stiffness(Definiteness::exact);
  EXPECT_LT((exact - sheet.stiffness(Definiteness::semi_definite)).norm(), 1e-14 * exact.norm());
}

// One matrix and one product are equivalent to two matrices.
TEST(Stiffness, DampingThatIsJoinedToItActsAsByItself) {
  for (const std::string& material : materials) {
    Sheet sheet(material +
                    "\nstiffness_damping = 0.1\nbending_damping = 0.2\nmass_damping = 0.3\n"
                    "normal_drag = 1\ntangential_drag = 0.5",
                1.1);
    Dynamics& dynamics = sheet.dynamics();
    const int count = dynamics.particle_count();
    std::mt19937 random(3);
    std::uniform_real_distribution<double> entry(-1, 1);
    const auto random_vectors = [&] {
      std::vector<Vec3> vectors(count);
      for (Vec3& v : vectors) v = Vec3::NullaryExpr([&] { return entry(random); });
      return vectors;
    };
    const std::vector<Vec3> residual = random_vectors(), in = random_vectors();
    for (int i = 3 * count; i < 6 * count; ++i) sheet.state()[i] = entry(random);
    constexpr double gamma = 0.07;

    dynamics.assemble(0, sheet.state());
    ASSERT_TRUE(dynamics.has_damping());
    std::vector<Vec3> separate(count), damping(count), of_residual(count), joined(count);
    dynamics.stiffness().multiply(in, separate, 1);
    dynamics.damping().multiply(in, damping, 1);
    dynamics.damping().multiply(residual, of_residual, 1);
    dynamics.assemble_joined(0, sheet.state(), Definiteness::exact, gamma, residual);
    ASSERT_FALSE(dynamics.has_damping());
    dynamics.stiffness().multiply(in, joined, 1);
    ASSERT_EQ(dynamics.damping_product().size(), residual.size());
    for (int i = 0; i < count; ++i) {
      const Vec3 expected = separate[i] + damping[i] / gamma;
      EXPECT_LT((joined[i] - expected).norm(), 1e-12 * expected.norm()) << material;
      EXPECT_LT((dynamics.damping_product()[i] - of_residual[i]).norm(),
                1e-12 * of_residual[i].norm())
          << material;
    }
  }
}

}  // namespace
}  // namespace weft::sim::stiffness_test
