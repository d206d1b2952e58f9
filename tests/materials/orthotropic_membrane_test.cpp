#include "materials/orthotropic_membrane.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numbers>

#include "tests/materials/finite_difference.h"

namespace weft::materials::orthotropic_membrane_test {
namespace {

Nodes3 random_triangle(std::mt19937& generator) {
  for (;;) {
    auto x = random_matrix<Nodes3>(generator);
    const Nodes3 edges = opposite_edges(x);
    const double double_area = edges.col(0).cross(edges.col(1)).norm();
    if (double_area > 0.2 * edges.colwise().squaredNorm().maxCoeff() && double_area > 0.1) return x;
  }
}

// E_11, E_22 and E_12 in the axes of warp and weft, from the deformation gradient.
Vec3 green_strain(const Nodes3& rest, const Vec3& warp, const Nodes3& x) {
  const Vec3 normal =
      Vec3(rest.col(1) - rest.col(0)).cross(Vec3(rest.col(2) - rest.col(0))).normalized();
  const Vec3 first = (warp - normal * normal.dot(warp)).normalized();
  Eigen::Matrix<double, 3, 2> axes, rest_sides, sides;
  axes << first, normal.cross(first);
  rest_sides << rest.col(1) - rest.col(0), rest.col(2) - rest.col(0);
  sides << x.col(1) - x.col(0), x.col(2) - x.col(0);
  const Eigen::Matrix2d rest_in_axes = axes.transpose() * rest_sides;
  const Eigen::Matrix<double, 3, 2> gradient = sides * rest_in_axes.inverse();
  const Eigen::Matrix2d strain =
      0.5 * (gradient.transpose() * gradient - Eigen::Matrix2d::Identity());
  return {strain(0, 0), strain(1, 1), strain(0, 1)};
}

double area_of(const Nodes3& x) {
  return 0.5 * Vec3(x.col(1) - x.col(0)).cross(Vec3(x.col(2) - x.col(0))).norm();
}

OrthotropicModuli random_moduli(std::mt19937& generator) {
  std::uniform_real_distribution<double> stiffness(1, 100), ratio(-0.9, 0.9);
  const double warp = stiffness(generator), weft = stiffness(generator);
  return orthotropic_moduli(warp, weft, stiffness(generator),
                            ratio(generator) * std::sqrt(warp / weft));
}

TEST(OrthotropicMembrane, EnergyIsThatOfTheGreenStrainAlongWarpAndWeft) {
  std::mt19937 generator(1);
  for (int trial = 0; trial < 2000; ++trial) {
    const Nodes3 rest = random_triangle(generator);
    const auto x = random_matrix<Nodes3>(generator);
    const auto warp = random_matrix<Vec3>(generator);
    const OrthotropicModuli c = random_moduli(generator);
    const Vec3 e = green_strain(rest, warp, x);
    const double exact = 0.5 * area_of(rest) *
                         (c.warp * e[0] * e[0] + 2 * c.coupling * e[0] * e[1] +
                          c.weft * e[1] * e[1] + 4 * c.shear * e[2] * e[2]);
    const OrthotropicMembrane membrane = make_orthotropic_membrane(rest, warp, c, 0);
    EXPECT_NEAR(membrane_energy(membrane, x), exact, 1e-10 * (1 + exact));
    EXPECT_GE(exact, 0);
  }
}

// With equal stiffness in all directions it is the isotropic membrane, whatever the warp.
TEST(OrthotropicMembrane, ContainsTheIsotropicMembrane) {
  std::mt19937 generator(2);
  for (int trial = 0; trial < 200; ++trial) {
    const Nodes3 rest = random_triangle(generator);
    const auto x = random_matrix<Nodes3>(generator), v = random_matrix<Nodes3>(generator);
    const double nu = -0.9 + 1.8 * trial / 200;
    const OrthotropicMembrane membrane =
        make_orthotropic_membrane(rest, random_matrix<Vec3>(generator),
                                  orthotropic_moduli(50, 50, 0.5 * 50 / (1 + nu), nu), 0.02);
    const TriangleMembrane isotropic = make_triangle_membrane(rest, 50, nu, 0.02);
    EXPECT_LT(relative_error(membrane_forces<double>(membrane, x, v),
                             membrane_forces<double>(isotropic, x, v)),
              1e-11);
    EXPECT_LT(relative_error(membrane_stiffness<double>(membrane, x, v).dense(),
                             membrane_stiffness<double>(isotropic, x, v).dense()),
              1e-11);
  }
}

TEST(OrthotropicMembrane, ForceAndStiffnessAreDerivatives) {
  std::mt19937 generator(3);
  for (int trial = 0; trial < 100; ++trial) {
    const OrthotropicMembrane membrane = make_orthotropic_membrane(
        random_triangle(generator), random_matrix<Vec3>(generator), random_moduli(generator), 0);
    const auto x = random_triangle(generator);
    const Nodes3 v = Nodes3::Zero();
    const auto energy = [&](const Nodes3& y) { return as_matrix(membrane_energy(membrane, y)); };
    const Nodes3 forces = membrane_forces<double>(membrane, x, v);
    EXPECT_LT(relative_error(finite_difference(energy, x), -flattened(forces).transpose()), 1e-9);
    const auto pull = [&](const Nodes3& y) -> Eigen::MatrixXd {
      return -membrane_forces<double>(membrane, y, v);
    };
    const Eigen::MatrixXd stiffness = membrane_stiffness<double>(membrane, x, v).dense();
    EXPECT_LT(relative_error(finite_difference(pull, x), stiffness), 1e-9);
    const Eigen::MatrixXd semi_definite = membrane_stiffness<double>(membrane, x, v, true).dense();
    EXPECT_GT(eigenvalues(semi_definite)[0], -1e-12 * semi_definite.norm());
  }
}

// Young's modulus at an angle to the warp, from the compliance in the axes of warp and weft:
//   1 / E = c^4 / E_1 + s^4 / E_2 + c^2 s^2 (1 / G - 2 nu / E_1).
TEST(OrthotropicMembrane, PullsHaveTheConstantsOfTheirDirection) {
  const double warp = 700, weft = 300, shear = 20, ratio = 0.4;
  const Mat3 compliance = orthotropic_moduli(warp, weft, shear, ratio).matrix().inverse();
  EXPECT_NEAR(-compliance(1, 0) / compliance(0, 0), ratio, 1e-12);
  EXPECT_NEAR(-compliance(0, 1) / compliance(1, 1), ratio * weft / warp, 1e-12);
  for (const double degrees : {0.0, 20.0, 45.0, 70.0, 90.0}) {
    const double c = std::cos(degrees * std::numbers::pi / 180),
                 s = std::sin(degrees * std::numbers::pi / 180);
    // A unit tension along (c, s), and the strain along it.
    const Vec3 strain = compliance * Vec3(c * c, s * s, c * s);
    const double along = Vec3(c * c, s * s, c * s).dot(strain);
    EXPECT_NEAR(along,
                std::pow(c, 4) / warp + std::pow(s, 4) / weft +
                    c * c * s * s * (1 / shear - 2 * ratio / warp),
                1e-12 * along);
  }
}

}  // namespace
}  // namespace weft::materials::orthotropic_membrane_test
