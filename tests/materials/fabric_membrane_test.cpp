// Membranes by curves and by measured coefficients.
#include "materials/fabric_membrane.h"

#include <gtest/gtest.h>

#include <numbers>

#include "materials/measured_stretch.h"
#include "materials/orthotropic_membrane.h"
#include "materials/stretch_curve.h"
#include "tests/materials/finite_difference.h"
#include "tests/measured_fabrics.h"

namespace weft::materials::fabric_membrane_test {
namespace {

using Strain = std::array<double, 3>;

// The strain (E_11, E_22, 2 E_12) with these principal Green strains, the first at an angle to the
// warp.
Strain strain_of(double major, double minor, double degrees) {
  const double c = std::cos(degrees * std::numbers::pi / 180),
               s = std::sin(degrees * std::numbers::pi / 180);
  return {major * c * c + minor * s * s, major * s * s + minor * c * c,
          2 * (major - minor) * c * s};
}
double green(double stretch) { return 0.5 * (stretch * stretch - 1); }

MeasuredStretch law_of(const MeasuredFabric& fabric) {
  return MeasuredStretch(clamped_coefficients(fabric));
}

CurvedStretch curved_law() {
  const std::vector<double> strains{-0.1, 0, 0.02, 0.05, 0.2}, tensions{-30, 0, 1, 8, 90};
  const std::vector<double> shear{0, 0.1, 0.5}, shear_tensions{0, 0.2, 6};
  return {TensionCurve(strains, tensions), TensionCurve(400),
          TensionCurve::mirrored(shear, shear_tensions)};
}

// Differences of the energy and of the tension, against the jets.
template <class Law>
void expect_derivatives(const Law& law, const Strain& at) {
  const auto jet = energy_jet<2>(law, at);
  const auto as_strain = [](const Vec3& v) { return Strain{v[0], v[1], v[2]}; };
  const auto energy = [&](const Vec3& v) { return as_matrix(law.energy(as_strain(v))); };
  const auto tension = [&](const Vec3& v) -> Eigen::MatrixXd {
    const auto first = energy_jet<1>(law, as_strain(v)).first;
    return Vec3(first[0], first[1], first[2]);
  };
  const Vec3 x(at[0], at[1], at[2]);
  const double step = 1e-3 * x.cwiseAbs().maxCoeff();
  const Vec3 first(jet.first[0], jet.first[1], jet.first[2]);
  Mat3 second;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) second(i, j) = jet.second[Symmetric3Of<double>::index(i, j)];
  }
  EXPECT_LT(relative_error(finite_difference(energy, x, step), first.transpose()), 1e-6);
  EXPECT_LT(relative_error(finite_difference(tension, x, step), second), 1e-5);
  EXPECT_EQ(jet.value, law.energy(at));
}

TEST(TensionCurve, GoesThroughItsPointsAndStraightBetweenAndBeyond) {
  const std::vector<double> strains{-0.1, 0, 0.02, 0.05, 0.2}, tensions{-30, 0, 1, 8, 90};
  const TensionCurve curve(strains, tensions);
  const auto tension = [&](double strain) {
    return curve.energy(Jet<double, 1>::variable(strain, 0)).first[0];
  };
  for (std::size_t i = 0; i < strains.size(); ++i)
    EXPECT_NEAR(tension(strains[i]), tensions[i], 1e-12);
  EXPECT_NEAR(tension(0.01), 0.5, 1e-12);
  EXPECT_NEAR(tension(0.125), 49, 1e-12);
  EXPECT_NEAR(tension(0.35), 172, 1e-11);
  EXPECT_NEAR(tension(-0.15), -45, 1e-12);
  EXPECT_NEAR(curve.energy(0.05), 0.5 * 0.02 * 1 + 0.03 * 4.5, 1e-14);
  EXPECT_NEAR(curve.energy(-0.1), 1.5, 1e-14);
  EXPECT_EQ(curve.energy(0.0), 0);
  EXPECT_NEAR(curve.largest_stiffness(), 82 / 0.15, 1e-9);
}

// A curve for one side only continues its first slope to the other.
TEST(TensionCurve, IsStraightThroughZeroWhereOneSideHasNoPoints) {
  const std::vector<double> strains{0, 0.1, 0.2}, tensions{0, 5, 50};
  const TensionCurve curve(strains, tensions);
  EXPECT_NEAR(curve.energy(-0.3), 0.5 * 50 * 0.09, 1e-14);
  EXPECT_NEAR(TensionCurve(70).energy(-0.1), 0.35, 1e-15);
}

TEST(CurvedStretch, PullsHaveTheTensionsOfTheCurves) {
  const CurvedStretch law = curved_law();
  for (const double stretch : {0.93, 1.01, 1.03, 1.1, 1.4}) {
    // The force per rest width is the derivative by the stretch: stretch S_11.
    const Strain at{green(stretch), -0.1, 0};
    const double force = stretch * energy_jet<1>(law, at).first[0];
    const double table = law.warp.energy(Jet<double, 1>::variable(stretch - 1, 0)).first[0];
    EXPECT_NEAR(force, table, 1e-11);
    EXPECT_NEAR(stretch * energy_jet<1>(law, Strain{-0.1, green(stretch), 0}).first[1],
                400 * (stretch - 1), 1e-11);
  }
  EXPECT_NEAR(energy_jet<1>(law, Strain{0, 0, 0.3}).first[2], 3.1, 1e-12);
  EXPECT_NEAR(energy_jet<1>(law, Strain{0, 0, -0.3}).first[2], -3.1, 1e-12);
}

TEST(CurvedStretch, HasTheDerivativesOfItsEnergy) {
  std::mt19937 generator(1);
  for (int trial = 0; trial < 100; ++trial) {
    const auto x = random_matrix<Vec3>(generator, 0.4);
    // Differences across a corner of a curve have no limit.
    const double nominal = std::sqrt(1 + 2 * x[0]) - 1;
    const auto is_near = [](double value, double corner) {
      return std::abs(value - corner) < 2e-3;
    };
    if (is_near(nominal, -0.1) || is_near(nominal, 0) || is_near(nominal, 0.02) ||
        is_near(nominal, 0.05) || is_near(nominal, 0.2) || is_near(std::abs(x[2]), 0.1))
      continue;
    expect_derivatives(curved_law(), {x[0], x[1], x[2]});
  }
}

// The published tensions do work E : S on the way to a strain, and so does the energy.
TEST(MeasuredStretch, StretchInOneDirectionHasThePublishedForce) {
  const std::vector<MeasuredFabric> fabrics = measured_fabrics();
  ASSERT_EQ(fabrics.size(), 10);
  for (const MeasuredFabric& fabric : fabrics) {
    const MeasuredStretch law = law_of(fabric);
    for (const double degrees : {0.0, 22.5, 45.0, 67.5, 90.0}) {
      for (const double stretch : {1.0001, 1.01, 1.05, 1.12, 1.166, 1.2, 1.5}) {
        for (const double contraction : {0.0, 0.3, 0.99}) {
          const double major = green(stretch), minor = -contraction * major;
          if (1 + 2 * minor < 0.05) continue;
          const Strain at = strain_of(major, minor, degrees);
          const auto s = published_tension(fabric, at[0], at[1], 0.5 * at[2]);
          const double published = s[0] * at[0] + s[1] * at[1] + s[2] * at[2];
          const auto own = energy_jet<1>(law, at).first;
          EXPECT_NEAR(own[0] * at[0] + own[1] * at[1] + own[2] * at[2], published, 1e-6 * published)
              << fabric.name << ' ' << degrees << ' ' << stretch << ' ' << contraction;
        }
      }
    }
  }
}

TEST(MeasuredStretch, EqualStretchHasThePublishedSumOfForces) {
  for (const MeasuredFabric& fabric : measured_fabrics()) {
    for (const double stretch : {1.001, 1.05, 1.15, 1.3}) {
      const double e = green(stretch);
      const auto s = published_tension(fabric, e, e, 0);
      const auto own = energy_jet<1>(law_of(fabric), Strain{e, e, 0}).first;
      EXPECT_NEAR(own[0] + own[1], s[0] + s[1], 1e-6 * (s[0] + s[1])) << fabric.name;
    }
  }
}

TEST(MeasuredStretch, HasTheDerivativesOfItsEnergy) {
  std::mt19937 generator(2);
  for (const MeasuredFabric& fabric : measured_fabrics()) {
    for (int trial = 0; trial < 60; ++trial) {
      const double scale = std::pow(10, -3 + 2.5 * trial / 60);
      const auto x = random_matrix<Vec3>(generator, scale);
      SCOPED_TRACE(fabric.name + ' ' + std::to_string(scale));
      expect_derivatives(law_of(fabric), {x[0], x[1], x[2]});
    }
  }
}

// Equal strains, pure contraction, uniaxial strains and no strain at all are seams of the formula.
TEST(MeasuredStretch, IsSmoothAcrossItsSeams) {
  for (const MeasuredFabric& fabric : measured_fabrics()) {
    const MeasuredStretch law = law_of(fabric);
    const double scale = std::abs(law.energy(Strain{0.1, 0.1, 0}));
    for (const Strain& at : {Strain{0.05, 0.05, 0},
                             {-0.05, -0.05, 0},
                             {0.05, 0, 0},
                             {0, 0.07, 0},
                             {0.04, -0.04, 0},
                             {0, -0.1, 0},
                             {0, 0, 0},
                             {0.02, -0.3, 0.01}}) {
      for (int i = 0; i < 3; ++i) {
        Strain before = at, after = at;
        before[i] -= 1e-7;
        after[i] += 1e-7;
        const auto one = energy_jet<1>(law, before).first, other = energy_jet<1>(law, after).first;
        for (int k = 0; k < 3; ++k)
          EXPECT_NEAR(one[k], other[k], 1e-2 * scale) << fabric.name << ' ' << i << ' ' << k;
      }
      const auto jet = energy_jet<2>(law, at);
      for (const double each : jet.second) EXPECT_TRUE(std::isfinite(each));
    }
    const auto rest = energy_jet<1>(law, Strain{0, 0, 0});
    for (const double each : rest.first) EXPECT_NEAR(each, 0, 1e-12);
  }
}

TEST(MeasuredStretch, ModuliAreSemiDefinite) {
  std::mt19937 generator(3);
  for (const MeasuredFabric& fabric : measured_fabrics()) {
    for (int trial = 0; trial < 100; ++trial) {
      const auto x = random_matrix<Vec3>(generator, 0.3);
      const auto c = law_of(fabric).semi_definite_moduli(Strain{x[0], x[1], x[2]});
      Mat3 matrix;
      matrix << c(0, 0), c(0, 1), c(0, 2), c(1, 0), c(1, 1), c(1, 2), c(2, 0), c(2, 1), c(2, 2);
      EXPECT_GT(eigenvalues(matrix)[0], -1e-12 * matrix.norm());
    }
    // At rest they are the first row of the table, over (E_11, E_22, 2 E_12).
    const auto row = clamped_coefficients(fabric)[0];
    const auto c = law_of(fabric).semi_definite_moduli(Strain{0, 0, 0});
    EXPECT_NEAR(c(0, 0), row[0], 1e-6 * row[0]);
    EXPECT_NEAR(c(2, 2), 0.5 * row[3], 1e-6 * row[3]);
  }
}

TEST(MeasuredStretch, LanesHaveTheNumbersOfSingleStrains) {
  std::mt19937 generator(4);
  for (const MeasuredFabric& fabric : measured_fabrics()) {
    const MeasuredStretch law = law_of(fabric);
    std::array<Lanes, 3> strains{};
    for (int lane = 0; lane < lane_count; ++lane) {
      const auto x = random_matrix<Vec3>(generator, 0.2);
      for (int i = 0; i < 3; ++i) strains[i].values[lane] = x[i];
    }
    const auto all = energy_jet<2>(law, strains);
    for (int lane = 0; lane < lane_count; ++lane) {
      const auto one = energy_jet<2>(
          law, Strain{strains[0].values[lane], strains[1].values[lane], strains[2].values[lane]});
      for (int i = 0; i < 3; ++i)
        EXPECT_NEAR(all.first[i].values[lane], one.first[i],
                    1e-12 * std::abs(one.first[i]) + 1e-12);
      for (int i = 0; i < 6; ++i)
        EXPECT_NEAR(all.second[i].values[lane], one.second[i],
                    1e-10 * std::abs(one.second[i]) + 1e-9);
    }
  }
}

Nodes3 random_triangle(std::mt19937& generator) {
  for (;;) {
    auto x = random_matrix<Nodes3>(generator);
    if (Vec3(x.col(1) - x.col(0)).cross(Vec3(x.col(2) - x.col(0))).norm() > 0.5) return x;
  }
}

// Forces, stiffness and damping of a triangle near its rest shape.
template <class Law>
void expect_triangle_derivatives(const Law& law, unsigned seed) {
  std::mt19937 generator(seed);
  for (int trial = 0; trial < 40; ++trial) {
    const Nodes3 rest = random_triangle(generator);
    const FabricMembrane membrane =
        make_fabric_membrane(rest, random_matrix<Vec3>(generator), 0.03);
    const Nodes3 x = rest + 0.04 * random_matrix<Nodes3>(generator);
    const auto v = random_matrix<Nodes3>(generator);
    const auto energy = [&](const Nodes3& y) { return as_matrix(fabric_energy(membrane, law, y)); };
    const auto forces = [&](const Nodes3& y) -> Nodes3 {
      const Nodes3 edges = opposite_edges(y);
      return pulls_of(fabric_tensions(membrane, law, edges), edges);
    };
    EXPECT_LT(relative_error(finite_difference(energy, x, 1e-4), -flattened(forces(x)).transpose()),
              1e-5);
    const Nodes3 edges = opposite_edges(x);
    const Vec3 q = squared_length_changes(membrane, edges);
    StencilMatrix<double, 3> stiffness = membrane_material_stiffness(
        EdgeModulusOf<double>{law_tangent(membrane.strains, law, q, false)}, x);
    add_membrane_stress(fabric_tensions(membrane, law, edges), false, stiffness);
    const auto pull = [&](const Nodes3& y) -> Eigen::MatrixXd { return -forces(y); };
    EXPECT_LT(relative_error(finite_difference(pull, x, 1e-5), stiffness.dense()), 1e-4);
    const auto damped = [&](const Nodes3& w) -> Eigen::MatrixXd {
      return -pulls_of(fabric_tensions(membrane, law, edges, w), edges);
    };
    const Eigen::MatrixXd damping =
        0.03 * membrane_material_stiffness(
                   EdgeModulusOf<double>{law_viscosity(membrane.strains, law, q)}, x)
                   .dense();
    EXPECT_LT(relative_error(finite_difference(damped, v), damping), 1e-9);
    EXPECT_GT(eigenvalues(damping)[0], -1e-12 * damping.norm());
    EXPECT_LT(forces(x).rowwise().sum().norm(), 1e-12 * forces(x).norm());
    EXPECT_LT(torque(x, forces(x)).norm(), 1e-12 * forces(x).norm());
  }
}

TEST(FabricMembrane, ForcesAndMatricesAreDerivatives) {
  for (const MeasuredFabric& fabric : measured_fabrics()) {
    SCOPED_TRACE(fabric.name);
    expect_triangle_derivatives(law_of(fabric), 5);
  }
  expect_triangle_derivatives(LinearLaw{orthotropic_moduli(70, 30, 4, 0.2)}, 6);
}

// The linear law over a triangle's strains is the orthotropic membrane.
TEST(FabricMembrane, LinearLawIsTheOrthotropicMembrane) {
  std::mt19937 generator(7);
  for (int trial = 0; trial < 100; ++trial) {
    const Nodes3 rest = random_triangle(generator);
    const auto x = random_matrix<Nodes3>(generator), v = random_matrix<Nodes3>(generator);
    const auto warp = random_matrix<Vec3>(generator);
    const OrthotropicModuli moduli = orthotropic_moduli(70, 30, 4, 0.2);
    const FabricMembrane membrane = make_fabric_membrane(rest, warp, 0.02);
    const Nodes3 edges = opposite_edges(x);
    EXPECT_LT(
        relative_error(
            pulls_of(fabric_tensions(membrane, LinearLaw{moduli}, edges, v), edges),
            membrane_forces<double>(make_orthotropic_membrane(rest, warp, moduli, 0.02), x, v)),
        1e-10);
  }
}

}  // namespace
}  // namespace weft::materials::fabric_membrane_test
