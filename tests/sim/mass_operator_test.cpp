// The mass matrix against integrals over the surface, dense algebra and laws of motion.
#include "sim/motion/mass_operator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "sim/case/case_reader.h"
#include "sim/motion/mass_matrix.h"
#include "sim/scene/spline_surface.h"
#include "tests/dense_algebra.h"

namespace weft::sim::mass_operator_test {
namespace {

const std::string solid = R"(
[contact]
enabled = false
[material.solid]
model = "shell"
youngs_modulus = 1e6
poisson_ratio = 0.3
shell_thickness = 0.01
volume_density = 1000
[material.cloth]
)";

std::string body(const std::string& name, const std::string& material, const std::string& shape,
                 const std::string& more = "") {
  return "[[body]]\nname = \"" + name + "\"\nmaterial = \"" + material + "\"\nshape = { " + shape +
         " }\n" + more;
}

const std::string roof =
    body("roof", "solid",
         "type = \"cylinder\", radius = 2, length = 3, angle_deg = 90, resolution = [7, 9]");
const std::string sheet =
    body("sheet", "cloth", "type = \"rectangle\", size = [1, 1], resolution = [4, 5]",
         "[[body.pin]]\ncorners = [\"first_first\"]\n");

std::unique_ptr<const Scene> scene_of(const std::string& text, const std::string& before = "") {
  return build_scene(parse_case(before + solid + text, "test.toml"));
}

std::vector<Vec3> random_vectors(std::size_t count, unsigned seed = 3) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> entry(-1, 1);
  std::vector<Vec3> vectors(count);
  for (Vec3& each : vectors) each = Vec3::NullaryExpr([&] { return entry(random); });
  return vectors;
}

// A mass matrix with the pattern of its own couplings.
struct Mass {
  explicit Mass(const Scene& scene, MassOperator::Form form = MassOperator::Form::consistent)
      : matrix(scene, form) {
    std::vector<std::vector<int>> neighbours(scene.dynamic_particles);
    matrix.add_couplings(neighbours);
    pattern = std::make_shared<const BlockPattern>(neighbours);
    matrix.attach(pattern);
  }
  Eigen::MatrixXd dense() const {
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(pattern->rows(), pattern->rows());
    for (int i = 0; i < pattern->rows(); ++i) {
      for (int slot = pattern->row_begin(i); slot < pattern->row_end(i); ++slot)
        result(i, pattern->column(slot)) = matrix.at(i, slot);
    }
    return result;
  }
  MassOperator matrix;
  std::shared_ptr<const BlockPattern> pattern;
};

TEST(MassOperator, RowSumsAreTheMasses) {
  for (const char* degree : {"", "spline_degree = 2\n"}) {
    std::string text = solid + roof + sheet;
    text.insert(text.find("[material.cloth]"), degree);
    const auto scene = build_scene(parse_case(text, "test.toml"));
    const Eigen::SparseMatrix<double> mass = mass_matrix(*scene);
    for (int i = 0; i < scene->dynamic_particles; ++i)
      EXPECT_NEAR(mass.col(i).sum(), scene->mass[i], 1e-12 * scene->mass[i]);
  }
}

// The kinetic energy of a surface whose velocity is a spline, summed over a fine grid of midpoints.
TEST(MassOperator, GivesTheKineticEnergyOfTheSurface) {
  const auto scene = scene_of(roof);
  const SceneBody& shell = scene->bodies[0];
  const std::vector<Vec3> velocity = random_vectors(scene->mass.size());
  const auto& [u, v] = shell.spline->patches()[0];
  constexpr int cells = 16;  // per element and axis
  double expected = 0;
  for (int j = 0; j < cells * v.elements(); ++j) {
    for (int i = 0; i < cells * u.elements(); ++i) {
      const SplineSurface::Point point =
          shell.spline->at(shell.atlas, {0, (i + 0.5) / cells, (j + 0.5) / cells});
      const double area = point.tangent_u(shell.rest).cross(point.tangent_v(shell.rest)).norm();
      expected +=
          0.5 * 1000 * 0.01 * area / (cells * cells) * point.position(velocity).squaredNorm();
    }
  }
  const Mass mass(*scene);
  EXPECT_NEAR(0.5 * mass.matrix.product(velocity, velocity, 1), expected, 2e-3 * expected);
}

// Positions of a plate are splines exactly, so that its inertia is that of the solid.
TEST(MassOperator, GivesTheEnergyOfATurningPlate) {
  const auto scene =
      scene_of(body("plate", "solid", "type = \"rectangle\", size = [2, 1], resolution = [5, 8]"));
  std::vector<Vec3> velocity;
  for (const Vec3& x : scene->initial_position) velocity.push_back(Vec3(0, 0, 3).cross(x));
  const double inertia = 1000 * 0.01 * 2 * (2 * 2 + 1 * 1) / 12.0;
  const Mass mass(*scene);
  EXPECT_NEAR(0.5 * mass.matrix.product(velocity, velocity, 1), 0.5 * inertia * 9, 1e-12 * inertia);
}

TEST(MassOperator, SolvesOnTheFreeParticles) {
  const auto scene = scene_of(roof + "[[body.pin]]\nedges = [\"first_row\"]\n" + sheet);
  Mass mass(*scene);
  const Eigen::MatrixXd dense = mass.dense();
  ASSERT_FALSE(mass.matrix.is_diagonal());
  EXPECT_LT((dense - Eigen::MatrixXd(mass_matrix(*scene))).norm(), 1e-14 * dense.norm());
  const std::vector<Vec3> force = random_vectors(scene->mass.size());
  std::vector<Vec3> acceleration = force, product(force.size());
  mass.matrix.solve(acceleration);
  mass.matrix.multiply(acceleration, product, 1);
  for (int i = 0; i < scene->dynamic_particles; ++i) {
    if (scene->pinned[i] != 0) {
      EXPECT_EQ(acceleration[i], Vec3(Vec3::Zero()));
    } else {
      EXPECT_LT((product[i] - force[i]).norm(), 1e-12);
    }
  }
}

TEST(MassOperator, ProductsAreThoseOfTheDenseMatrix) {
  const auto scene = scene_of(roof + sheet);
  for (const MassOperator::Form form :
       {MassOperator::Form::lumped, MassOperator::Form::consistent}) {
    const Mass mass(*scene, form);
    EXPECT_EQ(mass.matrix.is_diagonal(), form == MassOperator::Form::lumped);
    const Eigen::MatrixXd dense = mass.dense();
    const auto a = random_vectors(scene->mass.size(), 1), b = random_vectors(a.size(), 2);
    const auto c = random_vectors(a.size(), 3);
    std::vector<Vec3> product(a.size());
    mass.matrix.multiply(a, product, 1);
    double all = 0, bent = 0, both = 0;
    for (int i = 0; i < dense.rows(); ++i) {
      Vec3 row = Vec3::Zero();
      for (int j = 0; j < dense.rows(); ++j) row += dense(i, j) * a[j];
      EXPECT_LT((product[i] - row).norm(), 1e-13);
      all += row.dot(a[i]);
      bent += row.dot(2 * a[i] - b[i] - c[i]);
      both += row.dot(b[i]);
    }
    EXPECT_NEAR(mass.matrix.product(a, b, 1), both, 1e-12);
    const VibrationProducts seen = mass.matrix.vibration(b, a, c, 1);
    EXPECT_NEAR(seen.all, all, 1e-12);
    EXPECT_NEAR(seen.bent, bent, 1e-12);
  }
}

TEST(MassOperator, IsDiagonalWithoutShells) {
  const auto scene = scene_of(sheet);
  EXPECT_TRUE(Mass(*scene).matrix.is_diagonal());
}

}  // namespace
}  // namespace weft::sim::mass_operator_test
