#include "materials/crease.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "materials/bending.h"
#include "tests/materials/finite_difference.h"

namespace weft::materials::crease_test {
namespace {

constexpr double stiffness = 2e-3, poisson_ratio = 0.3;  // N m
constexpr double yield_curvature = 40, hardening = 0.2;  // 1/m

struct Triangle {
  Mat3 modulus;
  YieldLaw law;
  double area = 0;
  Nodes3 rest;
};

Triangle triangle(double harden = hardening) {
  Triangle result;
  result.rest << 0, 0.02, 0.003, 0, 0, 0.015, 0, 0, 0;
  result.modulus =
      triangle_bending_modulus(result.rest, {true, true, true}, stiffness, poisson_ratio);
  result.area = 0.5 * 0.02 * 0.015;
  result.law = make_yield_law(result.area, stiffness, yield_curvature, harden);
  return result;
}

// The angles of a triangle whose surface bends to a curvature along a direction in its plane:
// theta_i = h_i kappa (n . m_i)^2 does that for uniform curvature only in the sum; the angles of
// the header's formula solve kappa = sum theta_i / h_i m_i m_i^T.
Vec3 angles_of(const Triangle& of, const Eigen::Matrix2d& curvature) {
  Mat3 system;
  for (int i = 0; i < 3; ++i) {
    const Vec3 edge = of.rest.col((i + 2) % 3) - of.rest.col((i + 1) % 3);
    const double length = edge.norm(), height = 2 * of.area / length;
    const Eigen::Vector2d outward(edge.y() / length, -edge.x() / length);
    system.col(i) << outward[0] * outward[0], outward[0] * outward[1], outward[1] * outward[1];
    system.col(i) /= height;
  }
  return system.inverse() * Vec3(curvature(0, 0), curvature(0, 1), curvature(1, 1));
}

Vec3 cylinder(const Triangle& of, double curvature, double direction) {
  const Eigen::Vector2d along(std::cos(direction), std::sin(direction));
  return angles_of(of, curvature * along * along.transpose());
}

struct Response {
  Vec3 moments;
  Crease crease;
  Mat3 slope;
  double energy = 0;
};

Response respond(const Triangle& of, const Vec3& angles, const Crease& before) {
  const Vec3 trial = angles - before.angles, moments = of.modulus * trial;
  const YieldedOf<double> response = yielded<double>(of.law, before.curvature, trial, moments);
  Response result;
  result.moments = response.kept * moments;
  result.slope = response.kept * of.modulus - response.drop * (moments * moments.transpose());
  result.crease = before;
  result.crease.angles += (1 - response.kept) * trial;
  result.crease.curvature += response.flow;
  const Vec3 elastic = response.kept * trial;
  result.energy = 0.5 * elastic.dot(of.modulus * elastic);
  return result;
}

}  // namespace

// Bent to a cylinder in any direction, the elastic curvature is D kappa up to the yield curvature
// and rises by `hardening` D beyond; what is left after unloading is (1 - hardening) (kappa -
// kappa_y).
TEST(Crease, KeepsWhatTheFormulaSays) {
  const Triangle of = triangle();
  for (const double direction : {0.0, 0.4, 1.1, 2.5}) {
    for (const double curvature : {30.0, 45.0, 100.0, -250.0}) {
      const Response bent = respond(of, cylinder(of, curvature, direction), {});
      const double size = std::abs(curvature);
      const double left = std::max(0.0, (1 - hardening) * (size - yield_curvature));
      EXPECT_NEAR(bent.crease.curvature, left, 1e-10 * size);
      const Vec3 expected = cylinder(of, std::copysign(left, curvature), direction);
      EXPECT_LT((bent.crease.angles - expected).norm(), 1e-12);
      // Released, it has no moment at its crease.
      EXPECT_LT(respond(of, bent.crease.angles, bent.crease).moments.norm(), 1e-15);
      EXPECT_NEAR(bent.energy, 0.5 * of.area * stiffness * std::pow(size - left, 2),
                  1e-12 * bent.energy + 1e-18);
    }
  }
}

TEST(Crease, OneStepIsAsGoodAsMany) {
  const Triangle of = triangle();
  Crease many;
  for (int i = 1; i <= 100; ++i) many = respond(of, cylinder(of, 1.5 * i, 0.7), many).crease;
  const Crease one = respond(of, cylinder(of, 150, 0.7), {}).crease;
  EXPECT_LT((many.angles - one.angles).norm(), 1e-12);
  EXPECT_NEAR(many.curvature, one.curvature, 1e-9);
  // A state repeated changes nothing.
  const Crease again = respond(of, cylinder(of, 150, 0.7), one).crease;
  EXPECT_LT((again.angles - one.angles).norm(), 1e-13);
  EXPECT_NEAR(again.curvature, one.curvature, 1e-11);
}

// Bent forth and back, the yield curvature has grown by what has flowed (isotropic hardening).
TEST(Crease, HardensBothWays) {
  const Triangle of = triangle();
  const double beta = hardening / (1 - hardening);
  const Crease forth = respond(of, cylinder(of, 100, 0), {}).crease;
  const double raised = yield_curvature + beta * forth.curvature;
  const double back = forth.curvature - raised;  // where it yields on the way back
  const Crease before = respond(of, cylinder(of, 0.999 * back, 0), forth).crease;
  EXPECT_EQ(before.curvature, forth.curvature);
  const Crease after = respond(of, cylinder(of, back - 20, 0), forth).crease;
  EXPECT_NEAR(after.curvature - forth.curvature, 20 / (1 + beta), 1e-10);
}

// The moments derive from the elastic energy and what is dissipated in the step.
TEST(Crease, MomentsAndSlopesDeriveFromThePotential) {
  std::mt19937 generator(3);
  const Triangle of = triangle();
  Crease before = respond(of, cylinder(of, 90, 1.2), {}).crease;
  for (int trial = 0; trial < 30; ++trial) {
    const Vec3 angles = random_matrix<Vec3>(generator, trial % 2 == 0 ? 3.0 : 0.5);
    const auto potential = [&](const Vec3& at) {
      const Response response = respond(of, at, before);
      return as_matrix(response.energy + of.law.dissipated(response.crease.curvature));
    };
    const Response response = respond(of, angles, before);
    const Vec3 slope = finite_difference(potential, angles, 1e-5).transpose();
    EXPECT_LT((response.moments - slope).norm(), 1e-6 * response.moments.norm());
    const auto moments = [&](const Vec3& at) -> Eigen::MatrixXd {
      return respond(of, at, before).moments;
    };
    const Mat3 differences = finite_difference(moments, angles, 1e-5);
    EXPECT_LT((response.slope - differences).norm(), 1e-6 * response.slope.norm());
    const Eigen::VectorXd values = eigenvalues(response.slope);
    EXPECT_GE(values[0], -1e-12 * values[2]);
  }
}

// Work done in a cycle is what the crease has dissipated: work = loss + elastic energy at the end.
TEST(Crease, DissipatesTheWorkOfACycle) {
  const Triangle of = triangle();
  Crease crease;
  Vec3 angles = Vec3::Zero();
  double work = 0, dissipated = 0;
  const auto go_to = [&](double curvature) {
    const Vec3 start = angles, end = cylinder(of, curvature, 0.3);
    constexpr int steps = 4000;
    for (int i = 1; i <= steps; ++i) {
      const Vec3 next = start + (end - start) * i / steps;
      const Response before = respond(of, angles, crease), after = respond(of, next, crease);
      work += 0.5 * (before.moments + after.moments).dot(next - angles);
      crease = after.crease;
      angles = next;
      EXPECT_GE(of.law.dissipated(crease.curvature), dissipated);
      dissipated = of.law.dissipated(crease.curvature);
    }
  };
  for (const double curvature : {120.0, -80.0, 60.0}) go_to(curvature);
  const double elastic = respond(of, angles, crease).energy;
  EXPECT_GT(dissipated, 0.5 * work);
  EXPECT_NEAR(work, dissipated + elastic, 1e-4 * work);
}

// At the angles to which a crease has just flowed, the slope is elastic, however the trial value
// is rounded: that of a small motion back.
TEST(Crease, HasTheElasticSlopeWhereItHasFlowed) {
  for (const double harden : {0.0, hardening, 0.9}) {
    const Triangle of = triangle(harden);
    Crease crease;
    for (int i = 1; i <= 500; ++i) {
      const Vec3 angles = cylinder(of, 50 + 0.37 * i * i, 0.1 * i);
      crease = respond(of, angles, crease).crease;
      const Response after = respond(of, angles, crease);
      ASSERT_EQ(after.slope, of.modulus) << harden << ' ' << i;
      ASSERT_EQ(after.crease.curvature, crease.curvature) << harden << ' ' << i;
    }
  }
}

TEST(Crease, IdealPlasticityHoldsTheMoment) {
  const Triangle of = triangle(0);
  const Response one = respond(of, cylinder(of, 80, 0), {}),
                 other = respond(of, cylinder(of, 300, 0), {});
  EXPECT_LT((one.moments - other.moments).norm(), 1e-12 * one.moments.norm());
}

TEST(Crease, ElasticTrianglesStayElastic) {
  const Triangle of = triangle();
  const Vec3 trial = cylinder(of, 1e6, 0), moments = of.modulus * trial;
  const YieldedOf<double> response = yielded<double>(YieldLaw(), 0, trial, moments);
  EXPECT_EQ(response.kept, 1);
  EXPECT_EQ(response.drop, 0);
  EXPECT_EQ(response.flow, 0);
  EXPECT_EQ(YieldLaw().dissipated(0), 0);
}

}  // namespace weft::materials::crease_test
