#include "materials/membrane.h"

#include <gtest/gtest.h>

#include <vector>

#include "bench/triangle_springs.h"
#include "tests/materials/finite_difference.h"

namespace weft::materials::membrane_test {
namespace {

using Mat9 = Eigen::Matrix<double, 9, 9>;

constexpr int kTrials = 100;

// A random triangle whose angles are not too small for finite differences.
Nodes3 random_triangle(std::mt19937& generator) {
  for (;;) {
    auto x = random_matrix<Nodes3>(generator);
    const Nodes3 edges = opposite_edges(x);
    const double double_area = edges.col(0).cross(edges.col(1)).norm();
    if (double_area > 0.2 * edges.colwise().squaredNorm().maxCoeff() && double_area > 0.1) return x;
  }
}

struct State {
  TriangleMembrane membrane;
  Nodes3 x, v;
};

State random_state(std::mt19937& generator, double damping_time) {
  std::uniform_real_distribution<double> poisson(-0.9, 0.9);
  State state;
  state.membrane =
      make_triangle_membrane(random_triangle(generator), 100, poisson(generator), damping_time);
  state.x = random_triangle(generator);
  state.v = random_matrix<Nodes3>(generator);
  return state;
}

TEST(Membrane, EnergyIsSaintVenantKirchhoff) {
  const std::vector<bench::TriangleEnergies> all = bench::random_triangle_energies(2000);
  ASSERT_EQ(all.size(), 2000);
  for (const auto& [springs, green_strain] : all)
    EXPECT_NEAR(springs, green_strain, 1e-12 * green_strain);
}

TEST(Membrane, ForceIsMinusTheGradientOfTheEnergy) {
  std::mt19937 generator(2);
  for (int trial = 0; trial < kTrials; ++trial) {
    const State s = random_state(generator, 0);
    const auto energy = [&](const Nodes3& x) { return as_matrix(membrane_energy(s.membrane, x)); };
    const Nodes3 forces = membrane_forces<double>(s.membrane, s.x, s.v);
    EXPECT_LT(relative_error(finite_difference(energy, s.x), -flattened(forces).transpose()), 1e-9);
  }
}

TEST(Membrane, StiffnessIsMinusTheDerivativeOfTheForces) {
  std::mt19937 generator(3);
  for (int trial = 0; trial < kTrials; ++trial) {
    const State s = random_state(generator, 0);
    const auto forces = [&](const Nodes3& x) -> Eigen::MatrixXd {
      return -membrane_forces<double>(s.membrane, x, s.v);
    };
    const Mat9 stiffness = membrane_stiffness(s.membrane, s.x, s.v).dense();
    EXPECT_LT(relative_error(finite_difference(forces, s.x), stiffness), 1e-9);
    EXPECT_LT((stiffness - stiffness.transpose()).norm(), 1e-14 * stiffness.norm());
  }
}

// With damping, the geometric part contains the damped tensions. The stiffness is then the
// derivative of the forces of an undamped triangle whose rest lengths are shifted by -beta q' to
// the same stress.
TEST(Membrane, DampedStiffnessHasTheDampedStress) {
  std::mt19937 generator(4);
  for (int trial = 0; trial < kTrials; ++trial) {
    const State s = random_state(generator, 0.05);
    const Nodes3 edges = opposite_edges(s.x);
    const Nodes3 edge_velocities = opposite_edges(s.v);
    TriangleMembrane shifted = s.membrane;
    shifted.damping_time = 0;
    for (int i = 0; i < 3; ++i) {
      shifted.rest_squared_length[i] -= 0.05 * 2 * edges.col(i).dot(edge_velocities.col(i));
    }
    EXPECT_LT(relative_error(membrane_stiffness(s.membrane, s.x, s.v).dense(),
                             membrane_stiffness(shifted, s.x, s.v).dense()),
              1e-13);
    EXPECT_LT(relative_error(membrane_forces<double>(s.membrane, s.x, s.v),
                             membrane_forces<double>(shifted, s.x, s.v)),
              1e-12);
  }
}

TEST(Membrane, DampingIsMinusTheDerivativeByVelocity) {
  std::mt19937 generator(5);
  for (int trial = 0; trial < kTrials; ++trial) {
    const State s = random_state(generator, 0.05);
    const auto forces = [&](const Nodes3& v) -> Eigen::MatrixXd {
      return -membrane_forces<double>(s.membrane, s.x, v);
    };
    const Mat9 damping =
        s.membrane.damping_time * membrane_material_stiffness(s.membrane, s.x).dense();
    EXPECT_LT(relative_error(finite_difference(forces, s.v), damping), 1e-9);
    EXPECT_GT(eigenvalues(damping)[0], -1e-13 * damping.norm());
  }
}

TEST(Membrane, ForcesBalanceAndDampingTakesEnergy) {
  std::mt19937 generator(6);
  for (int trial = 0; trial < kTrials; ++trial) {
    const State s = random_state(generator, 0.05);
    const Nodes3 forces = membrane_forces<double>(s.membrane, s.x, s.v);
    EXPECT_LT(forces.rowwise().sum().norm(), 1e-13 * forces.norm());
    EXPECT_LT(torque(s.x, forces).norm(), 1e-13 * forces.norm());
    const Nodes3 damped = forces - membrane_forces<double>(s.membrane, s.x, Nodes3::Zero());
    EXPECT_LE(damped.cwiseProduct(s.v).sum(), 0);
  }
}

TEST(Membrane, RigidMotionGivesNoForce) {
  std::mt19937 generator(7);
  for (int trial = 0; trial < kTrials; ++trial) {
    const Nodes3 rest = random_triangle(generator);
    const TriangleMembrane membrane = make_triangle_membrane(rest, 100, 0.3, 0.05);
    const Vec3 axis = random_matrix<Vec3>(generator).normalized();
    Nodes3 x = Eigen::AngleAxisd(trial, axis).toRotationMatrix() * rest;
    x.colwise() += random_matrix<Vec3>(generator);
    const Nodes3 v =
        rigid_velocity(x, random_matrix<Vec3>(generator), random_matrix<Vec3>(generator));
    const double scale = Mat3::NullaryExpr([&](Eigen::Index i, Eigen::Index j) {
                           return membrane.modulus(static_cast<int>(i), static_cast<int>(j));
                         }).norm();
    EXPECT_LT(membrane_forces<double>(membrane, x, v).norm(), 1e-13 * scale);
    EXPECT_LT(membrane_energy(membrane, x), 1e-26 * scale);
  }
}

// A unit square of two triangles is pulled to lambda along x with free sides. Saint
// Venant-Kirchhoff then has P = E h lambda (lambda^2 - 1)/2 and lambda_t^2 = 1 - nu (lambda^2 - 1).
TEST(Membrane, UniaxialPullHasTheClosedForm) {
  const Eigen::Matrix<double, 3, 4> square{{0, 1, 1, 0}, {0, 0, 1, 1}, {0, 0, 0, 0}};
  const double stiffness = 7;
  for (const double poisson_ratio : {-0.3, 0.0, 0.3, 0.5}) {
    for (const double lambda : {0.8, 1.1, 1.4}) {
      const double across = std::sqrt(1 - poisson_ratio * (lambda * lambda - 1));
      Eigen::Matrix<double, 3, 4> forces = Eigen::Matrix<double, 3, 4>::Zero();
      for (const auto& nodes : {std::array{0, 1, 2}, std::array{0, 2, 3}}) {
        const Nodes3 rest = square(Eigen::all, nodes);
        const Nodes3 x = Vec3(lambda, across, 1).asDiagonal() * rest;
        forces(Eigen::all, nodes) += membrane_forces<double>(
            make_triangle_membrane(rest, stiffness, poisson_ratio, 0), x, Nodes3::Zero());
      }
      const double pull = stiffness * lambda * (lambda * lambda - 1) / 2;
      EXPECT_NEAR(forces(0, 1) + forces(0, 2), -pull, 1e-13);
      EXPECT_NEAR(forces(1, 2) + forces(1, 3), 0, 1e-13);
    }
  }
}

// An affine map stresses every triangle alike, so inner nodes of any mesh feel nothing.
TEST(Membrane, AffinePatchLeavesInnerNodesInBalance) {
  constexpr int kSide = 9;
  std::mt19937 generator(8);
  std::uniform_real_distribution<double> shake(-0.25, 0.25);
  const auto is_inner = [](int row, int column) {
    return row > 0 && row < kSide - 1 && column > 0 && column < kSide - 1;
  };
  std::vector<Vec3> rest;
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      Vec3 position(column, row, 0);
      if (is_inner(row, column)) position += Vec3(shake(generator), shake(generator), 0);
      rest.push_back(position);
    }
  }
  const auto gradient = random_matrix<Mat3>(generator);
  std::vector<Vec3> forces(rest.size(), Vec3::Zero());
  double largest = 0;
  const auto add_triangle = [&](const std::array<int, 3>& nodes) {
    Nodes3 rest_triangle;
    for (int i = 0; i < 3; ++i) rest_triangle.col(i) = rest[nodes[i]];
    const Nodes3 triangle_forces =
        membrane_forces<double>(make_triangle_membrane(rest_triangle, 50, 0.3, 0),
                                gradient * rest_triangle, Nodes3::Zero());
    for (int i = 0; i < 3; ++i) forces[nodes[i]] += triangle_forces.col(i);
    largest = std::max(largest, triangle_forces.cwiseAbs().maxCoeff());
  };
  for (int row = 0; row + 1 < kSide; ++row) {
    for (int column = 0; column + 1 < kSide; ++column) {
      const int a = row * kSide + column;
      const bool flip = generator() % 2 == 0;  // diagonals at random: unstructured
      add_triangle(flip ? std::array{a, a + 1, a + kSide + 1} : std::array{a, a + 1, a + kSide});
      add_triangle(flip ? std::array{a, a + kSide + 1, a + kSide}
                        : std::array{a + 1, a + kSide + 1, a + kSide});
    }
  }
  ASSERT_GT(largest, 1);
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      if (!is_inner(row, column)) continue;
      EXPECT_LT(forces[row * kSide + column].norm(), 1e-13 * largest);
    }
  }
}

}  // namespace
}  // namespace weft::materials::membrane_test
