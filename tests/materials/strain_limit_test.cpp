#include "materials/strain_limit.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "materials/membrane.h"
#include "tests/materials/finite_difference.h"

namespace weft::materials::strain_limit_test {
namespace {

using Mat9 = Eigen::Matrix<double, 9, 9>;

constexpr double limit = 0.1, stiffness = 100;

Nodes3 rest_triangle(std::mt19937& generator) {
  for (;;) {
    const auto x = random_matrix<Nodes3>(generator);
    const Nodes3 edges = opposite_edges(x);
    const double double_area = edges.col(0).cross(edges.col(1)).norm();
    if (double_area > 0.3 * edges.colwise().squaredNorm().maxCoeff() && double_area > 0.1) return x;
  }
}

// The deformation gradient of a rest triangle to x, in a frame of the rest plane of its own.
Eigen::Matrix<double, 3, 2> gradient(const Nodes3& rest, const Nodes3& x) {
  const Vec3 along = (rest.col(2) - rest.col(1)).normalized();
  const Vec3 normal = along.cross(rest.col(0) - rest.col(1)).normalized();
  Eigen::Matrix<double, 3, 2> frame, rest_sides, sides;
  frame << along, normal.cross(along);
  rest_sides << rest.col(1) - rest.col(0), rest.col(2) - rest.col(0);
  sides << x.col(1) - x.col(0), x.col(2) - x.col(0);
  const Eigen::Matrix2d in_plane = frame.transpose() * rest_sides;
  return sides * in_plane.inverse();
}

// A placement of the rest triangle, turned at random, with these principal stretches.
Nodes3 stretched(std::mt19937& generator, const Nodes3& rest, double major, double minor) {
  const Vec3 axis = random_matrix<Vec3>(generator).normalized();
  const Mat3 turn = Eigen::AngleAxisd(random_matrix<Vec3>(generator).norm(), axis).matrix();
  const Vec3 along = (rest.col(1) - rest.col(0)).normalized();
  const Vec3 normal = along.cross(rest.col(2) - rest.col(0)).normalized();
  const Mat3 in_plane = Eigen::AngleAxisd(random_matrix<Vec3>(generator)[0] * 3, normal).matrix();
  const Vec3 first = in_plane * along, second = normal.cross(first);
  const Mat3 stretch = major * first * first.transpose() + minor * second * second.transpose() +
                       normal * normal.transpose();
  return turn * stretch * rest;
}

double area_of(const Nodes3& rest) {
  return 0.5 * Vec3(rest.col(1) - rest.col(0)).cross(Vec3(rest.col(2) - rest.col(0))).norm();
}

// The function b of the header, with the parabola that stands for it near the limit.
double barrier(double d) {
  if (d >= 1) return 0;
  if (d >= 0.02) return std::pow(1 - d, 3) / d;
  const double by = d - 0.02;
  return std::pow(0.98, 3) / 0.02 + (3 - 0.04 - 1 / 4e-4) * by + (1 / 8e-6 - 1) * by * by;
}

// The energy of the header from principal stretches.
double expected_energy(const Nodes3& rest, const Nodes3& x) {
  const Eigen::Matrix<double, 3, 2> deformation = gradient(rest, x);
  const Eigen::VectorXd squares = eigenvalues(deformation.transpose() * deformation);
  const double most = 1.1 * 1.1, onset = 1.05 * 1.05, range = most - onset;
  double sum = 0;
  for (const double square : squares) sum += barrier((most - square) / range);
  return area_of(rest) * stiffness * range * range / 8 * sum;
}

// Principal strains on either side of the onset and near the limit; equal ones, too.
const std::vector<std::array<double, 2>> strains = {{0.02, -0.2},   {0.07, 0.01},  {0.08, 0.06},
                                                    {0.09, 0.09},   {0.099, 0.06}, {0.0995, -0.3},
                                                    {0.098, 0.098}, {0.051, 0.049}};

}  // namespace

TEST(StrainLimit, EnergyIsThatOfThePrincipalStretches) {
  std::mt19937 generator(1);
  for (int trial = 0; trial < 50; ++trial) {
    const Nodes3 rest = rest_triangle(generator);
    const StrainLimit of = make_strain_limit(rest, limit, stiffness);
    for (const auto& [major, minor] : strains) {
      const Nodes3 x = stretched(generator, rest, 1 + major, 1 + minor);
      const double expected = expected_energy(rest, x);
      EXPECT_NEAR(strain_limit_energy(of, x), expected, 1e-7 * expected + 1e-12);
      EXPECT_NEAR(largest_squared_stretch(of, x), (1 + major) * (1 + major), 1e-12);
    }
    EXPECT_NEAR(limit_of_squared_stretch(of), 1.1 * 1.1, 1e-14);
  }
}

TEST(StrainLimit, BelowItsOnsetNothingActs) {
  std::mt19937 generator(2);
  const Nodes3 rest = rest_triangle(generator);
  const StrainLimit of = make_strain_limit(rest, limit, stiffness);
  const Nodes3 x = stretched(generator, rest, 1.0499, 0.4);
  EXPECT_EQ(strain_limit_energy(of, x), 0);
  EXPECT_EQ(strain_limit_forces(of, x).norm(), 0);
  EXPECT_EQ(strain_limit_stiffness(of, x).dense().norm(), 0);
}

TEST(StrainLimit, ForceIsMinusTheGradientOfTheEnergy) {
  std::mt19937 generator(3);
  for (int trial = 0; trial < 30; ++trial) {
    const Nodes3 rest = rest_triangle(generator);
    const StrainLimit of = make_strain_limit(rest, limit, stiffness);
    for (const auto& [major, minor] : strains) {
      const Nodes3 x = stretched(generator, rest, 1 + major, 1 + minor);
      const auto energy = [&](const Nodes3& at) { return as_matrix(strain_limit_energy(of, at)); };
      const Eigen::VectorXd slope = finite_difference(energy, x, 1e-6).transpose();
      const Eigen::VectorXd forces = flattened(strain_limit_forces(of, x));
      EXPECT_LT((forces + slope).norm(), 1e-4 * (forces.norm() + 1e-2)) << major << ' ' << minor;
    }
  }
}

// Near the limit the Hessian changes over a thousandth of the strain: steps are short.
TEST(StrainLimit, StiffnessIsMinusTheGradientOfTheForce) {
  std::mt19937 generator(4);
  for (int trial = 0; trial < 30; ++trial) {
    const Nodes3 rest = rest_triangle(generator);
    const StrainLimit of = make_strain_limit(rest, limit, stiffness);
    for (const auto& [major, minor] : strains) {
      const Nodes3 x = stretched(generator, rest, 1 + major, 1 + minor);
      const auto forces = [&](const Nodes3& at) -> Eigen::MatrixXd {
        return flattened(strain_limit_forces(of, at));
      };
      const Eigen::MatrixXd slope = finite_difference(forces, x, 1e-7);
      const Mat9 matrix = strain_limit_stiffness(of, x).dense();
      EXPECT_LT((matrix + slope).norm(), 1e-4 * (matrix.norm() + 1)) << major << ' ' << minor;
    }
  }
}

// Also beyond the limit, where iterates may pass.
TEST(StrainLimit, EnergyIsConvex) {
  std::mt19937 generator(5);
  for (int trial = 0; trial < 300; ++trial) {
    const Nodes3 rest = rest_triangle(generator);
    const StrainLimit of = make_strain_limit(rest, limit, stiffness);
    const double major = 0.05 + 0.1 * trial / 300, minor = -0.5 + 0.002 * trial;
    const Nodes3 x = stretched(generator, rest, 1 + major, 1 + std::min(major, minor));
    const Eigen::VectorXd values = eigenvalues(strain_limit_stiffness(of, x).dense());
    EXPECT_GE(values[0], -1e-10 * values[8]);
    const Nodes3 other = stretched(generator, rest, 1 + 0.5 * major, 1.02);
    const double middle = strain_limit_energy(of, Nodes3(0.5 * (x + other)));
    const double ends = 0.5 * (strain_limit_energy(of, x) + strain_limit_energy(of, other));
    EXPECT_LE(middle, ends * (1 + 1e-12));
  }
}

// At the onset of b, and at the place from which its quadratic continuation stands for it.
TEST(StrainLimit, TermsAreSmooth) {
  std::mt19937 generator(6);
  const StrainLimit of = make_strain_limit(rest_triangle(generator), limit, stiffness);
  for (const double d : {0.02, 1.0}) {
    const double square = of.onset + of.range * (1 - d), by = 1e-9 * of.range;
    const LimitTerm<double> below = limit_term(of, square - by),
                            above = limit_term(of, square + by);
    EXPECT_NEAR(below.value, above.value, 1e-5 * (1 + below.value));
    EXPECT_NEAR(below.slope, above.slope, 1e-5 * (1 + below.slope));
    EXPECT_NEAR(below.curvature, above.curvature, 1e-4 * (1 + below.curvature));
  }
  // Beyond the limit the force still grows.
  EXPECT_GT(limit_term(of, of.onset + 1.1 * of.range).slope,
            limit_term(of, of.onset + of.range).slope);
}

TEST(StrainLimit, ForcesHaveNoResultantAndNoMoment) {
  std::mt19937 generator(7);
  const Nodes3 rest = rest_triangle(generator);
  const StrainLimit of = make_strain_limit(rest, limit, stiffness);
  const Nodes3 x = stretched(generator, rest, 1.095, 1.07);
  const Nodes3 forces = strain_limit_forces(of, x);
  ASSERT_GT(forces.norm(), 1);
  EXPECT_LT(Vec3(forces.rowwise().sum()).norm(), 1e-12 * forces.norm());
  EXPECT_LT(torque(x, forces).norm(), 1e-12 * forces.norm());
}

TEST(StrainLimit, LanesAgreeWithSingleTriangles) {
  std::mt19937 generator(8);
  std::array<StrainLimit, lane_count> singles;
  std::array<Nodes3, lane_count> places;
  StrainLimitOf<Lanes> batch;
  NodesOf<Lanes, 3> x;
  for (int lane = 0; lane < lane_count; ++lane) {
    const Nodes3 rest = rest_triangle(generator);
    const auto& [major, minor] = strains[lane % strains.size()];
    singles[lane] = make_strain_limit(rest, limit, stiffness);
    places[lane] = stretched(generator, rest, 1 + major, 1 + minor);
    for (int node = 0; node < 2; ++node) {
      for (int k = 0; k < 2; ++k)
        batch.gradients[node][k].values[lane] = singles[lane].gradients[node][k];
    }
    batch.onset.values[lane] = singles[lane].onset;
    batch.range.values[lane] = singles[lane].range;
    batch.stiffness.values[lane] = singles[lane].stiffness;
    for (int i = 0; i < 9; ++i) x.data()[i].values[lane] = places[lane].data()[i];
  }
  const Lanes energy = strain_limit_energy(batch, x);
  const NodesOf<Lanes, 3> forces = strain_limit_forces(batch, x);
  const StencilMatrix<Lanes, 3> matrix = strain_limit_stiffness(batch, x);
  for (int lane = 0; lane < lane_count; ++lane) {
    const double single = strain_limit_energy(singles[lane], places[lane]);
    EXPECT_NEAR(energy.values[lane], single, 1e-12 * (1 + single));
    const Nodes3 expected = strain_limit_forces(singles[lane], places[lane]);
    const StencilMatrix<double, 3> blocks = strain_limit_stiffness(singles[lane], places[lane]);
    for (int i = 0; i < 9; ++i)
      EXPECT_NEAR(forces.data()[i].values[lane], expected.data()[i], 1e-12 * (1 + expected.norm()));
    for (int b = 0; b < 6; ++b) {
      for (int i = 0; i < 9; ++i) {
        EXPECT_NEAR(matrix.blocks[b].data()[i].values[lane], blocks.blocks[b].data()[i],
                    1e-11 * (1 + blocks.blocks[b].norm()));
      }
    }
  }
}

}  // namespace weft::materials::strain_limit_test
