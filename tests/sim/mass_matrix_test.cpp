// The mass matrix of scenes against the definition of kinetic energy and closed forms.
#include "sim/motion/mass_matrix.h"

#include <cmath>
#include <numbers>

#include "shell_model.h"

namespace weft::sim::mass_matrix_test {
namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::SparseMatrix<double>;

constexpr const char* roof = R"(
[contact]
enabled = false
[material.steel]
model = "shell"
youngs_modulus = 1e6
shell_thickness = 0.01
volume_density = 1000
[material.cloth]
density = 0.2
[[body]]
name = "sheet"
material = "cloth"
position = [0, 0, 10]
shape = { type = "rectangle", size = [1, 1], resolution = [3, 4] }
[[body]]
name = "roof"
material = "steel"
shape = { type = "cylinder", radius = 2, length = 3, angle_deg = 90, resolution = [7, 9] }
)";

std::unique_ptr<const Scene> scene_of(const std::string& text,
                                      const std::vector<std::string>& overrides = {}) {
  return build_scene(parse_case(text, "test.toml", overrides));
}

TEST(MassMatrix, HasTheMassesOfTheSceneAsRowSums) {
  for (const char* degree : {"2", "3"}) {
    const auto scene = scene_of(roof, {std::string("material.steel.spline_degree=") + degree});
    const Matrix mass = mass_matrix(*scene);
    const Vector sums = mass * Vector::Ones(mass.cols());
    double largest = 0;
    for (const double each : scene->mass) largest = std::max(largest, each);
    for (int i = 0; i < scene->dynamic_particles; ++i)
      EXPECT_NEAR(sums[i], scene->mass[i], 1e-13 * largest) << i;
    EXPECT_LT((mass - Matrix(mass.transpose())).norm(), 1e-15 * mass.norm());
  }
}

TEST(MassMatrix, IsDiagonalForClothAndCouplesNoBodies) {
  const auto scene = scene_of(roof);
  const Matrix mass = mass_matrix(*scene);
  const int cloth = scene->bodies[0].particle_count();
  ASSERT_EQ(scene->bodies[0].name, "sheet");
  for (int i = 0; i < cloth; ++i) {
    EXPECT_EQ(mass.col(i).nonZeros(), 1);
    EXPECT_EQ(mass.coeff(i, i), scene->mass[i]);
  }
  for (int i = cloth; i < mass.cols(); ++i) {
    for (Matrix::InnerIterator each(mass, i); each; ++each) EXPECT_GE(each.row(), cloth);
  }
}

// Open splines of uniform spacing over [0, L], with f(x) = x as control points: 1/2 M f f is 1/2
// rho h W L^3 / 3. Row sums alone would give a larger value.
TEST(MassMatrix, IntegratesVelocitiesThatAreLinearInPlace) {
  for (const char* degree : {"2", "3"}) {
    const auto scene = scene_of(
        shell_case(1e6, 0.3, 0.01, "type = \"rectangle\", size = [3, 2], resolution = [7, 9]"),
        {std::string("material.solid.spline_degree=") + degree});
    const Matrix mass = mass_matrix(*scene);
    Vector velocity(mass.cols());
    for (int i = 0; i < mass.cols(); ++i) velocity[i] = scene->initial_position[i].x();
    const double exact = 1000 * 0.01 * 2 * std::pow(3, 3) / 12;  // about the middle
    EXPECT_NEAR(velocity.dot(mass * velocity), exact, 1e-12 * exact);
  }
}

// The energy of a velocity field on a curved surface is the integral of its square, here by the
// midpoint rule on a fine grid.
TEST(MassMatrix, IsTheIntegralOfTheBasisOverTheCurvedSurface) {
  const ShellModel model(shell_case(
      1e6, 0.3, 0.01,
      "type = \"cylinder\", radius = 2, length = 3, angle_deg = 90, resolution = [6, 9]"));
  const SceneBody& body = model.body();
  const Matrix mass = mass_matrix(model.scene());
  Vector velocity(mass.cols());
  for (int i = 0; i < mass.cols(); ++i) velocity[i] = std::sin(1.3 * i) + 0.2;
  constexpr int points = 60;  // per element
  double sum = 0;
  const int nu = points * static_cast<int>(model.length_u());
  const int nv = points * static_cast<int>(model.length_v());
  for (int i = 0; i < nu; ++i) {
    for (int j = 0; j < nv; ++j) {
      const SplineSurface::Point at =
          body.spline->at(body.atlas, {0, (i + 0.5) / points, (j + 0.5) / points});
      double v = 0;
      for (std::size_t k = 0; k < at.value.size(); ++k)
        v += at.value[k] * velocity[at.control_points[k]];
      sum += v * v * at.tangent_u(body.rest).cross(at.tangent_v(body.rest)).norm();
    }
  }
  sum *= 1000 * 0.01 / (points * points);
  EXPECT_NEAR(velocity.dot(mass * velocity), sum, 2e-4 * sum);
}

TEST(MassMatrix, IsPositiveDefinite) {
  const auto scene = scene_of(roof);
  Eigen::SimplicialLLT<Matrix> factors(mass_matrix(*scene));
  EXPECT_EQ(factors.info(), Eigen::Success);
}

}  // namespace
}  // namespace weft::sim::mass_matrix_test
