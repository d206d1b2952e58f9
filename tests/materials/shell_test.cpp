#include "materials/shell.h"

#include <gtest/gtest.h>

#include <random>
#include <utility>

#include "tests/dense_algebra.h"

namespace weft::materials::shell_test {
namespace {

constexpr int nodes = 9;
using Basis = ShellBasis<nodes>;
using Nodes = NodesOf<double, nodes>;
using Blocks = StencilMatrix<double, nodes>;

// A point of a curved quadratic surface, with nodes near the rest shape.
class ShellPoint : public testing::Test {
 protected:
  ShellPoint() {
    for (int j = 0, node = 0; j < 3; ++j) {
      for (int i = 0; i < 3; ++i, ++node) {
        const std::array<double, 3> value{0.32, 0.66, 0.02}, slope{-0.8, 0.6, 0.2},
            second{1, -2, 1};
        basis_.u[node] = slope[i] * value[j];
        basis_.v[node] = value[i] * slope[j];
        basis_.uu[node] = second[i] * value[j];
        basis_.vv[node] = value[i] * second[j];
        basis_.uv[node] = slope[i] * slope[j];
        rest_.col(node) = Vec3(i, 0.8 * j + 0.3 * i, 0.2 * i * i - 0.1 * i * j);
      }
    }
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-0.2, 0.2);
    for (int i = 0; i < nodes; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        x_(axis, i) = rest_(axis, i) + uniform(random);
        v_(axis, i) = uniform(random);
      }
    }
    const SurfaceDerivatives at_rest = derivatives(basis_, rest_);
    stretch_ = membrane_law(at_rest, 1000, 0.3, 0.2, 0.7);
    bend_ = bending_law(at_rest, 1000, 0.3, 0.2, 0.7);
    fibre_ = fibre_law(FibreAxis::v, at_rest, 1000, 0.3, 0.2, 0.7);
  }

  ShellFibre fibre(const Nodes& x) const { return ShellFibre(x * basis_.v.matrix()); }
  double fibre_energy(const Nodes& x) const {
    const double strain = fibre(x).strain(fibre_);
    return 0.5 * fibre_.modulus * strain * strain;
  }
  Nodes fibre_gradient(const Nodes& x) const {
    Nodes sum = Nodes::Zero();
    fibre(x).add_gradient<nodes>(fibre_.modulus * fibre(x).strain(fibre_), basis_.v, sum);
    return sum;
  }
  double stretch_energy(const Nodes& x) const {
    const Vec3 strain = ShellStretch(derivatives(basis_, x)).strain(stretch_);
    return 0.5 * strain.dot(stretch_.modulus * strain);
  }
  double bend_energy(const Nodes& x) const {
    const Vec3 bending = ShellBend(derivatives(basis_, x)).bending(bend_);
    return 0.5 * bending.dot(bend_.modulus * bending);
  }
  Nodes stretch_gradient(const Nodes& x) const {
    const ShellStretch stretch(derivatives(basis_, x));
    Nodes sum = Nodes::Zero();
    stretch.add_gradient(Vec3(stretch_.modulus * stretch.strain(stretch_)), basis_, sum);
    return sum;
  }
  Nodes bend_gradient(const Nodes& x) const {
    const ShellBend bend(derivatives(basis_, x));
    Nodes sum = Nodes::Zero();
    bend.add_gradient(Vec3(bend_.modulus * bend.bending(bend_)), basis_, sum);
    return sum;
  }
  template <class Function>
  auto difference(const Function& function, int component) const
      -> decltype(function(std::declval<Nodes>())) {
    constexpr double step = 1e-5;
    Nodes more = x_, less = x_;
    more.data()[component] += step;
    less.data()[component] -= step;
    return (function(more) - function(less)) / (2 * step);
  }
  template <class Gradient>
  void expect_hessian(const Blocks& blocks, const Gradient& gradient, double tolerance) const {
    const Eigen::Matrix<double, 3 * nodes, 3 * nodes> all = blocks.dense();
    for (int c = 0; c < 3 * nodes; ++c) {
      const Nodes column = difference(gradient, c);
      for (int r = 0; r < 3 * nodes; ++r)
        EXPECT_NEAR(all(r, c), column.data()[r], tolerance) << r << ", " << c;
    }
  }

  Basis basis_;
  Nodes rest_, x_, v_;
  ShellLaw stretch_, bend_;
  FibreLaw fibre_;
};

TEST_F(ShellPoint, FeelsNoForceAtRest) {
  EXPECT_EQ(stretch_energy(rest_), 0);
  EXPECT_EQ(bend_energy(rest_), 0);
  EXPECT_EQ(fibre_energy(rest_), 0);
}

TEST_F(ShellPoint, FeelsNoForceWhenMovedRigidly) {
  const Eigen::AngleAxisd turn(1.1, Vec3(0.3, -0.5, 0.8).normalized());
  const Nodes moved = (turn.toRotationMatrix() * rest_).colwise() + Vec3(1, 2, 3);
  EXPECT_NEAR(stretch_energy(moved), 0, 1e-20);
  EXPECT_NEAR(bend_energy(moved), 0, 1e-20);
  EXPECT_NEAR(fibre_energy(moved), 0, 1e-20);
}

TEST_F(ShellPoint, GradientsAreThoseOfTheEnergies) {
  const Nodes stretch = stretch_gradient(x_), bend = bend_gradient(x_), fibre = fibre_gradient(x_);
  for (int c = 0; c < 3 * nodes; ++c) {
    EXPECT_NEAR(stretch.data()[c], difference([&](const Nodes& x) { return stretch_energy(x); }, c),
                1e-6);
    EXPECT_NEAR(fibre.data()[c], difference([&](const Nodes& x) { return fibre_energy(x); }, c),
                1e-6);
    EXPECT_NEAR(bend.data()[c], difference([&](const Nodes& x) { return bend_energy(x); }, c),
                1e-7);
  }
}

TEST_F(ShellPoint, HessiansAreThoseOfTheEnergies) {
  Blocks stretch, bend, line;
  stretch.blocks.fill(Mat3::Zero());
  line.blocks.fill(Mat3::Zero());
  fibre(x_).add_stiffness<nodes>(fibre_.modulus, fibre_.modulus * fibre(x_).strain(fibre_),
                                 basis_.v, line);
  expect_hessian(
      line, [&](const Nodes& x) { return fibre_gradient(x); }, 1e-5);
  bend.blocks.fill(Mat3::Zero());
  const ShellStretch stretching(derivatives(basis_, x_));
  stretching.add_stiffness(stretch_.modulus, Vec3(stretch_.modulus * stretching.strain(stretch_)),
                           basis_, stretch);
  expect_hessian(
      stretch, [&](const Nodes& x) { return stretch_gradient(x); }, 1e-5);
  const ShellBend bending(derivatives(basis_, x_));
  bending.add_stiffness(bend_.modulus, Vec3(bend_.modulus * bending.bending(bend_)), true, basis_,
                        bend);
  expect_hessian(
      bend, [&](const Nodes& x) { return bend_gradient(x); }, 1e-6);
}

TEST_F(ShellPoint, RatesAreTheSlopesOfStrainAndBendingAlongTheMotion) {
  constexpr double step = 1e-6;
  const auto slope = [&](const auto& value) {
    return Vec3((value(Nodes(x_ + step * v_)) - value(Nodes(x_ - step * v_))) / (2 * step));
  };
  const SurfaceDerivatives now = derivatives(basis_, x_), rate = derivatives(basis_, v_);
  const Vec3 strain =
      slope([&](const Nodes& x) { return ShellStretch(derivatives(basis_, x)).strain(stretch_); });
  const Vec3 bending =
      slope([&](const Nodes& x) { return ShellBend(derivatives(basis_, x)).bending(bend_); });
  const double along =
      slope([&](const Nodes& x) { return Vec3(fibre(x).strain(fibre_), 0, 0); }).x();
  EXPECT_NEAR(fibre(x_).strain_rate(v_ * basis_.v.matrix()), along, 1e-8);
  EXPECT_LT((ShellStretch(now).strain_rate(rate) - strain).norm(), 1e-8);
  EXPECT_LT((ShellBend(now).bending_rate(rate) - bending).norm(), 1e-8);
}

// A plate rolled onto a cylinder, seen at a point: W / A = D k^2 / 2 along every direction.
TEST(Shell, BendsAlikeInEveryDirection) {
  constexpr double youngs_modulus = 7e10, thickness = 1e-3, nu = 0.3, curvature = 2;
  const double rigidity = youngs_modulus * std::pow(thickness, 3) / 12 / (1 - nu * nu);
  for (double degrees = 0; degrees <= 135; degrees += 15) {
    const double angle = degrees * std::acos(-1.0) / 180, c = std::cos(angle), s = std::sin(angle);
    // Skewed parameters: u and v are not orthogonal.
    SurfaceDerivatives rest{{2, 0, 0}, {0.5, 1, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    const auto along = [&](const Vec3& a) { return c * a.x() + s * a.y(); };
    SurfaceDerivatives bent = rest;
    bent.uu.z() = curvature * along(rest.u) * along(rest.u);
    bent.vv.z() = curvature * along(rest.v) * along(rest.v);
    bent.uv.z() = curvature * along(rest.u) * along(rest.v);
    const ShellLaw law = bending_law(rest, youngs_modulus, nu, thickness, 1);
    const Vec3 bending = ShellBend(bent).bending(law);
    EXPECT_NEAR(0.5 * bending.dot(law.modulus * bending) / area_factor(rest),
                0.5 * rigidity * curvature * curvature, 1e-10 * rigidity)
        << degrees;
  }
}

// The parts of the membrane's modulus add up to the modulus, and none is indefinite.
TEST(Shell, MembraneIsTheSumOfItsParts) {
  const SurfaceDerivatives rest{{2, 0.3, 0}, {0.5, 1, 0.2}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  for (const double nu : {-0.5, 0.0, 0.3, 0.5}) {
    const Mat3 whole = 0.7 * area_factor(rest) * plane_stress_modulus(rest, 20, nu);
    const Mat3 coupled = membrane_law(rest, 1000, nu, 0.02, 0.7).modulus;
    const double u = fibre_law(FibreAxis::u, rest, 1000, nu, 0.02, 0.7).modulus;
    const double v = fibre_law(FibreAxis::v, rest, 1000, nu, 0.02, 0.7).modulus;
    const Mat3 sum = coupled + Mat3(Vec3(u, v, 0).asDiagonal());
    EXPECT_LT((sum - whole).norm(), 1e-12 * whole.norm()) << nu;
    EXPECT_GT(std::min(u, v), 0) << nu;
    EXPECT_NEAR(eigenvalues(coupled)[0], 0, 1e-12 * whole.norm()) << nu;
  }
}

TEST(Shell, PullingPartLeavesOutCompression) {
  const Vec3 stress(3, -1, 0.5), pull = pulling_part(stress);
  Eigen::Matrix2d all, part;
  all << stress[0], stress[2], stress[2], stress[1];
  part << pull[0], pull[2], pull[2], pull[1];
  EXPECT_NEAR(eigenvalues(part)[0], 0, 1e-14);
  EXPECT_NEAR(eigenvalues(part)[1], eigenvalues(all)[1], 1e-14);
  EXPECT_LT((pulling_part({2, 1, 0.3}) - Vec3(2, 1, 0.3)).norm(), 1e-14);
}

}  // namespace
}  // namespace weft::materials::shell_test
