#include "sim/solver/multigrid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "sim/base/parallel.h"
#include "sim/case/case_reader.h"
#include "sim/solver/velocity_system.h"
#include "tests/dense_algebra.h"

namespace weft::sim::multigrid_test {
namespace {

std::string sheet(int rows, int cols) {
  return "{ type = \"rectangle\", size = [1.0, 1.0], resolution = [" + std::to_string(rows) + ", " +
         std::to_string(cols) + "] }";
}

struct Setting {
  std::string shape{};
  std::string more{};      // pins, obstacles, further bodies
  std::string material{};  // keys
  std::string contact = "enabled = false";
  std::string preconditioner = "multigrid";
  int threads = 1;
  std::string time{};  // keys
};

// The dynamics of a slightly stretched body.
class DeformedScene {
 public:
  explicit DeformedScene(const Setting& setting)
      : scene_(build_scene(parse_case(
            "[time]\npreconditioner = \"" + setting.preconditioner + "\"\n" + setting.time +
                "\n[contact]\n" + setting.contact + "\n[compute]\nbackend = \"cpu\"\nthreads = " +
                std::to_string(setting.threads) + "\n[material.cloth]\n" + setting.material +
                "\n[[body]]\nname = \"body\"\nshape = " + setting.shape + "\n" + setting.more,
            "test.toml", {}))),
        dynamics_(*scene_, statistics_),
        state_(dynamics_.initial_state()) {
    auto* x = reinterpret_cast<Vec3*>(state_.data());
    for (int i = 0; i < dynamics_.particle_count(); ++i) {
      if (scene_->pinned[i] != 0 || scene_->source.contact.enabled) continue;
      // Out of its plane, a sheet is stretched everywhere.
      const Vec3 p = x[i];
      const double pi = std::numbers::pi;
      if (setting.shape.find("rectangle") != std::string::npos) {
        x[i].z() += std::cos(pi * p.x()) * std::cos(pi * p.y()) *
                    (0.1 + 0.002 * std::sin(17 * p.x() + 7 * p.y()));
      } else {
        x[i] *= 1.01 + 0.005 * std::sin(3 * p.x());
      }
    }
    rate_.resize(state_.size());
    raise(0);
  }

  // Raises all free particles and evaluates the forces there.
  void raise(double height) {
    auto* x = reinterpret_cast<Vec3*>(state_.data());
    for (int i = 0; i < dynamics_.particle_count(); ++i) {
      if (scene_->pinned[i] == 0) x[i].z() += height;
    }
    EXPECT_FALSE(dynamics_.rate(0, state_, rate_));
    dynamics_.assemble(0, state_);
  }

  Dynamics& dynamics() { return dynamics_; }
  const Scene& scene() const { return *scene_; }

  // The right-hand side of the first Newton iteration of a step, zero positions.
  std::vector<double> right_side(double gamma) const {
    std::vector<double> b(rate_.size());
    for (std::size_t i = b.size() / 2; i < b.size(); ++i) b[i] = gamma * rate_[i];
    return b;
  }
  // Solves for the right-hand side of that iteration to a relative residual, in the norm of
  // accelerations.
  VelocitySystem::Outcome solve(VelocitySystem& system, double gamma, double relative,
                                std::vector<double>& correction) const {
    const std::vector<double> b = right_side(gamma), weight(b.size(), 1.0);
    double square = 0;
    for (double value : b) square += value * value;
    correction.assign(b.size(), 0.0);
    system.set_up(gamma);
    return system.solve(gamma, b, weight, {.residual = relative * std::sqrt(square)}, correction);
  }

 private:
  std::unique_ptr<const Scene> scene_;
  Statistics statistics_;
  Dynamics dynamics_;
  std::vector<double> state_, rate_;
};

// A sheet that touches a floor with one corner, until it is raised.
Setting sheet_on_floor(const std::string& material) {
  return {.shape = sheet(13, 13),
          .more = "[[obstacle]]\nname = \"floor\"\nposition = [0.6, 0.3, -0.0025]\nshape = " +
                  sheet(4, 4),
          .material = material,
          .contact = "range = 0.004\nfriction = 0.3"};
}

// Returns a linear map of velocities as a matrix: column i is its result for unit vector i. Rows
// and columns are zero for pinned particles.
template <class Map>
Eigen::MatrixXd dense(const Scene& scene, const Map& map) {
  const int count = scene.dynamic_particles;
  Eigen::MatrixXd result(3 * count, 3 * count);
  std::vector<Vec3> in(count, Vec3::Zero()), out(count);
  for (int i = 0; i < 3 * count; ++i) {
    in[i / 3][i % 3] = scene.pinned[i / 3] != 0 ? 0 : 1;
    map(in, out);
    in[i / 3].setZero();
    result.col(i) = Eigen::Map<const Eigen::VectorXd>(out[0].data(), 3 * count);
  }
  return result;
}

const std::string shell =
    "model = \"shell\"\nyoungs_modulus = 1e6\npoisson_ratio = 0.3\nshell_thickness = 1e-2\n"
    "volume_density = 1000\n";

std::vector<Setting> settings() {
  const std::string pins = "[[body.pin]]\ncorners = [\"last_first\", \"last_last\"]\n";
  const std::string touching = "range = 0.004\nfriction = 0.3";
  return {
      {.shape = sheet(16, 16), .more = pins},
      {.shape = sheet(17, 13),
       .more = "[[body.pin]]\nedges = [\"first_row\"]\n",
       .material = "bending_stiffness = 1e-4"},
      {.shape = sheet(11, 18),
       .more = pins,
       .material = "membrane = \"springs\"\nbend_stiffness = 10"},
      {.shape = sheet(13, 13),
       .more = pins,
       .material = "stiffness_damping = 1e-3\nmass_damping = 1.0\nnormal_drag = 1.0"},
      {.shape = sheet(2, 40), .more = pins},
      {.shape = R"({ type = "cylinder", radius = 0.3, length = 1.0, resolution = [11, 17] })"},
      {.shape =
           R"({ type = "torus", major_radius = 0.5, minor_radius = 0.2, resolution = [12, 15] })"},
      {.shape = R"({ type = "sphere", radius = 0.5, resolution = [7] })",
       .material = "bending_stiffness = 1e-3"},
      // Shells: open, quadratic and damped; closed and clamped.
      {.shape = sheet(11, 14),
       .more = pins,
       .material = shell + "spline_degree = 2\nstiffness_damping = 1e-3\nmass_damping = 1.0"},
      {.shape = R"({ type = "cylinder", radius = 0.3, length = 1.0, resolution = [11, 13] })",
       .more = "[[body.pin]]\nedges = [\"first_row\"]\nclamp = true\n",
       .material = shell},
      // A sheet on an obstacle.
      {.shape = sheet(13, 13),
       .more = "[[obstacle]]\nname = \"floor\"\nposition = [0, 0, -0.0025]\nshape = " + sheet(4, 4),
       .contact = touching},
      // Two sheets on each other, held by one.
      {.shape = sheet(11, 11),
       .more = pins + "[[body]]\nname = \"upper\"\nposition = [0.03, 0.02, 0.003]\nshape = " +
               sheet(10, 12),
       .contact = touching},
  };
}

// The matrix is formed for several gammas from the same K and D. It is in single precision where
// Newton's iteration corrects its rounding, and where this is small beside the mass.
TEST(VelocityMatrix, IsTheSumOfMassDampingAndStiffness) {
  const std::string by_number = "method = \"euler\"\nstep = 0.01\nnewton = 1";
  for (const auto& [damping, time] : {std::pair<std::string, std::string>("", ""),
                                      {"stiffness_damping = 1e-3\nmass_damping = 1.0", ""},
                                      {"stiffness_damping = 1e-3", by_number}}) {
    for (const std::string& model : {std::string(), shell}) {
      DeformedScene deformed({.shape = sheet(7, 9), .material = model + damping, .time = time});
      const Dynamics& dynamics = deformed.dynamics();
      VelocityMatrix matrix(dynamics);
      for (const double gamma : {100.0, 10.0, 3e-5}) {
        matrix.form(gamma);
        EXPECT_EQ(matrix.is_single(),
                  model.empty() && !damping.empty() && time.empty() && gamma == 3e-5);
        const Eigen::MatrixXd expected = dense(deformed.scene(), [&](const auto& in, auto& out) {
          dynamics.stiffness().multiply(in, out, 1);
          std::vector<Vec3> damped(in.size(), Vec3::Zero());
          if (dynamics.has_damping()) dynamics.damping().multiply(in, damped, 1);
          for (int i = 0; i < dynamics.particle_count(); ++i)
            out[i] = dynamics.mass().row_product(i, in.data()) + gamma * damped[i] +
                     gamma * gamma * out[i];
        });
        const double rounding = (matrix.is_single() ? 1e-7 : 1e-14) * expected.norm();
        const Eigen::MatrixXd product =
            dense(deformed.scene(), [&](const auto& in, auto& out) { matrix.multiply(in, out); });
        EXPECT_LT((product - expected).norm(), rounding) << damping;
        SingleBlockMatrix copy(matrix.pattern());
        matrix.copy_to(copy);
        for (int row = 0; row < copy.pattern().rows(); ++row) {
          for (int slot = copy.pattern().row_begin(row); slot < copy.pattern().row_end(row);
               ++slot) {
            const Mat3 block = expected.block<3, 3>(3 * row, 3 * copy.pattern().column(slot));
            EXPECT_LT((matrix.block(row, slot) - block).norm(), rounding) << damping;
            EXPECT_LT((copy.block(row, slot).cast<double>() - block).norm(), 1e-6 * block.norm())
                << damping;
          }
        }
      }
    }
  }
}

// Blocks without contact are inverted once, as long as A without contact stays the same.
TEST(BlockJacobi, FollowsContactThatComesAndGoes) {
  DeformedScene deformed(sheet_on_floor("stiffness_damping = 1e-3"));
  VelocityMatrix matrix(deformed.dynamics());
  std::vector<Vec3> r(deformed.dynamics().particle_count()), z(r.size()), expected(r.size());
  for (int i = 0; i < std::ssize(r); ++i) r[i] = Vec3(1, 2 + std::sin(i), -1.5);
  BlockJacobi kept;
  std::vector<Vec3> at_start;
  for (const double gamma : {1e-3, 2e-3}) {
    matrix.form(gamma);
    for (const double change : {0.05, -0.05, 0.0, 0.05, -0.0503, 0.0503, -0.05}) {
      const bool touches = change <= 0;
      deformed.raise(change);
      EXPECT_EQ(matrix.has_contact(), touches);
      EXPECT_TRUE(kept.update(matrix));
      const double product = kept.apply(matrix, r, z);
      EXPECT_NEAR(product, dot(r, z, 1), 1e-12 * product);
      BlockJacobi fresh;
      EXPECT_TRUE(fresh.update(matrix));
      fresh.apply(matrix, r, expected);
      EXPECT_EQ(z, expected) << gamma << " " << change;
      if (at_start.empty()) at_start = z;
      EXPECT_EQ(z == at_start, !touches && gamma == 1e-3) << gamma << " " << change;
    }
  }
}

TEST(Multigrid, GalerkinProductIsThatOfDenseMatrices) {
  DeformedScene deformed({.shape = sheet(10, 13),
                          .more = "[[body.pin]]\ncorners = [\"all\"]\n",
                          .material = "bending_stiffness = 1e-3"});
  VelocityMatrix matrix(deformed.dynamics());
  matrix.form(0.01);
  const Prolongation p = coarsen_images(deformed.scene())[0];
  SingleBlockMatrix fine(matrix.pattern());
  matrix.copy_to(fine);
  const GalerkinProduct product(matrix.pattern(), p);
  SingleBlockMatrix coarse(product.pattern());
  product.form(fine, coarse, 2);
  const Eigen::MatrixXd a =
      dense(deformed.scene(), [&](const auto& in, auto& out) { matrix.multiply(in, out); });
  Eigen::MatrixXd interpolation = Eigen::MatrixXd::Zero(3 * p.fine_count(), 3 * p.coarse_count());
  for (int i = 0; i < p.fine_count(); ++i) {
    for (int k = p.row_start[i]; k < p.row_start[i + 1]; ++k)
      interpolation.block<3, 3>(3 * i, 3 * p.column[k]) = p.weight[k] * Mat3::Identity();
  }
  Eigen::MatrixXd expected = congruent(a, interpolation);
  const double size = expected.cwiseAbs().maxCoeff();
  for (int row = 0; row < coarse.pattern().rows(); ++row) {
    for (int slot = coarse.pattern().row_begin(row); slot < coarse.pattern().row_end(row); ++slot)
      expected.block<3, 3>(3 * row, 3 * coarse.pattern().column(slot)) -=
          coarse.block(row, slot).cast<double>();
  }
  EXPECT_LT(expected.cwiseAbs().maxCoeff(), 1e-6 * size);
}

// Sets up with the coarse matrices of another step.
void set_up_with_old_coarse_matrices(Multigrid& multigrid, VelocityMatrix& matrix) {
  matrix.form(0.002);
  ASSERT_TRUE(multigrid.set_up(matrix));
  matrix.form(0.01);
  ASSERT_TRUE(multigrid.update(matrix));
}

TEST(Multigrid, IsSymmetricAndPositiveDefinite) {
  for (const Setting& setting : settings()) {
    for (std::size_t w_cycle_levels : {0, 1, 2}) {
      SCOPED_TRACE(setting.shape + setting.more);
      DeformedScene deformed(setting);
      VelocityMatrix matrix(deformed.dynamics());
      Multigrid multigrid(deformed.scene(), matrix.pattern(), w_cycle_levels);
      set_up_with_old_coarse_matrices(multigrid, matrix);
      Eigen::MatrixXd p = dense(
          deformed.scene(), [&](const auto& in, auto& out) { multigrid.apply(matrix, in, out); });
      EXPECT_LT((p - p.transpose()).cwiseAbs().maxCoeff(), 1e-5 * p.cwiseAbs().maxCoeff());
      for (int i = 0; i < deformed.scene().dynamic_particles; ++i) {
        if (deformed.scene().pinned[i] != 0) p.diagonal().segment<3>(3 * i).setOnes();
      }
      const Eigen::MatrixXd symmetric = 0.5 * (p + p.transpose());
      EXPECT_GT(eigenvalues(symmetric)[0], 0);
    }
  }
}

TEST(Multigrid, ReturnsTheResidualThatTheProductHas) {
  for (const Setting& setting : settings()) {
    SCOPED_TRACE(setting.shape + setting.more);
    DeformedScene deformed(setting);
    VelocityMatrix matrix(deformed.dynamics());
    Multigrid multigrid(deformed.scene(), matrix.pattern());
    set_up_with_old_coarse_matrices(multigrid, matrix);
    const int count = deformed.scene().dynamic_particles;
    std::vector<Vec3> r(count, Vec3::Zero()), z(count), product(count);
    for (int i = 0; i < count; ++i) {
      if (deformed.scene().pinned[i] == 0) r[i] = Vec3(std::sin(i), std::cos(3 * i), 1);
    }
    multigrid.apply(matrix, r, z);
    matrix.multiply(z, product);
    EXPECT_EQ(multigrid.residual().empty(), matrix.has_contact());
    for (std::size_t i = 0; i < multigrid.residual().size(); ++i)
      EXPECT_LT((multigrid.residual()[i] - (r[i] - product[i])).norm(), 1e-4) << i;
  }
}

// The norm is the energy norm, |e| = sqrt(e.A e); A e is the residual.
TEST(Multigrid, TwoCyclesOfTheCoarserLevelsSolveBetter) {
  DeformedScene deformed({.shape = sheet(25, 25),
                          .more = "[[body.pin]]\nedges = [\"first_row\"]\n",
                          .material = "bending_stiffness = 1e-4"});
  VelocityMatrix matrix(deformed.dynamics());
  matrix.form(0.1);
  const int count = deformed.scene().dynamic_particles;
  Eigen::MatrixXd a =
      dense(deformed.scene(), [&](const auto& in, auto& out) { matrix.multiply(in, out); });
  std::vector<Vec3> r(count, Vec3(0, 0, 1));
  for (int i = 0; i < count; ++i) {
    if (deformed.scene().pinned[i] == 0) continue;
    a.diagonal().segment<3>(3 * i).setOnes();
    r[i].setZero();
  }
  const auto error_after = [&](std::size_t w_cycle_levels) {
    Multigrid multigrid(deformed.scene(), matrix.pattern(), w_cycle_levels);
    EXPECT_TRUE(multigrid.set_up(matrix));
    std::vector<Vec3> z(count);
    multigrid.apply(matrix, r, z);
    const Eigen::Map<const Eigen::VectorXd> left(multigrid.residual()[0].data(), 3 * count);
    return std::sqrt(left.dot(solve_definite(a, left)));
  };
  EXPECT_LT(error_after(2), 0.9 * error_after(0));
}

// The matrix A and the right-hand side M b_v, for zero positions.
struct DenseSystem {
  Eigen::MatrixXd a;
  Eigen::VectorXd right;
};

DenseSystem dense_system(DeformedScene& deformed, double gamma) {
  VelocityMatrix matrix(deformed.dynamics());
  matrix.form(gamma);
  DenseSystem system;
  system.a = dense(deformed.scene(), [&](const auto& in, auto& out) { matrix.multiply(in, out); });
  const std::vector<double> b = deformed.right_side(gamma);
  const auto* const velocity = reinterpret_cast<const Vec3*>(b.data() + b.size() / 2);
  system.right.resize(system.a.rows());
  for (int i = 0; i < deformed.scene().dynamic_particles; ++i) {
    system.right.segment<3>(3 * i) = deformed.dynamics().mass().row_product(i, velocity);
    if (deformed.scene().pinned[i] == 0) continue;
    system.right.segment<3>(3 * i).setZero();
    system.a.diagonal().segment<3>(3 * i).setOnes();
  }
  return system;
}

double squared_in_masses(const Scene& scene, const Eigen::VectorXd& velocity) {
  double sum = 0;
  for (int i = 0; i < scene.dynamic_particles; ++i)
    sum += scene.mass[i] * velocity.segment<3>(3 * i).squaredNorm();
  return sum;
}

TEST(Multigrid, SolvesAsADirectSolverDoes) {
  for (const Setting& setting : settings()) {
    SCOPED_TRACE(setting.shape + setting.more);
    DeformedScene deformed(setting);
    const double gamma = 0.01;
    VelocitySystem system(deformed.dynamics());
    std::vector<double> correction;
    const auto outcome = deformed.solve(system, gamma, 1e-9, correction);
    EXPECT_TRUE(outcome.converged);
    EXPECT_TRUE(outcome.multigrid);
    const auto [a, right] = dense_system(deformed, gamma);
    const Eigen::VectorXd expected = solve_definite(a, right);
    const Eigen::Map<const Eigen::VectorXd> found(correction.data() + correction.size() / 2,
                                                  a.rows());
    EXPECT_LT((found - expected).norm(), 1e-6 * expected.norm());
  }
}

// Coarse matrices from before the contact and for a shorter step become useless within the solve.
TEST(Multigrid, LeavesTheResidualAskedForWhenContactComesAndGoes) {
  for (double relative : {1e-2, 1e-4, 1e-9}) {
    SCOPED_TRACE(relative);
    DeformedScene deformed(sheet_on_floor("bending_stiffness = 0.1"));
    VelocitySystem system(deformed.dynamics());
    for (double height : {0.05, -0.05, 0.05, -0.05}) {
      deformed.raise(height);
      const double gamma = height > 0 ? 1e-4 : 1e-2;
      std::vector<double> correction;
      const auto outcome = deformed.solve(system, gamma, relative, correction);
      EXPECT_TRUE(outcome.converged);
      EXPECT_TRUE(outcome.multigrid);
      EXPECT_EQ(VelocityMatrix(deformed.dynamics()).has_contact(), height < 0);
      auto [a, right] = dense_system(deformed, gamma);
      const Eigen::Map<const Eigen::VectorXd> found(correction.data() + correction.size() / 2,
                                                    a.rows());
      Eigen::VectorXd residual = right - a * found;
      for (int i = 0; i < deformed.scene().dynamic_particles; ++i) {
        residual.segment<3>(3 * i) /= deformed.scene().mass[i];
        right.segment<3>(3 * i) /= deformed.scene().mass[i];
      }
      EXPECT_LT(residual.norm(), 1.01 * relative * right.norm());
    }
  }
}

// A stiff pair at a slope, in single precision, leaves no stiffness along the surfaces.
TEST(Multigrid, SolvesWithPairsWhoseRoundingExceedsTheMass) {
  for (const std::string stiffness : {"1e5", "1e8", "1e10", "1e12"}) {
    SCOPED_TRACE(stiffness);
    const std::string turned = "rotation_deg = [31.0, 17.0, 5.0]\n";
    DeformedScene deformed(
        {.shape = sheet(13, 13),
         .more = turned + "[[obstacle]]\nname = \"floor\"\n" + turned +
                 "position = [-0.00075, 0.00124, -0.00204]\nshape = " + sheet(4, 4),
         .material = "membrane_stiffness = 1.0\nbending_stiffness = 1e-6",
         .contact = "range = 0.004\nstiffness = " + stiffness});
    VelocitySystem system(deformed.dynamics());
    std::vector<double> correction;
    const auto outcome = deformed.solve(system, 1e-3, 1e-4, correction);
    EXPECT_TRUE(VelocityMatrix(deformed.dynamics()).has_contact());
    EXPECT_TRUE(outcome.converged);
    EXPECT_TRUE(outcome.multigrid);
    EXPECT_LE(outcome.iterations, 25);
  }
}

// A bound of the mean alone would be met by a solution that is wrong at one particle only.
TEST(VelocitySystem, BoundsTheResidualOfEachParticle) {
  DeformedScene deformed({.shape = sheet(33, 33), .preconditioner = "block_jacobi"});
  const int count = deformed.scene().dynamic_particles, kicked = count / 2;
  const double gamma = 2e-4;
  std::vector<double> b(6 * count, 0.0), correction(b.size());
  const std::vector<double> weight(b.size(), 1.0);
  b[3 * (count + kicked) + 2] = 1;
  VelocityMatrix matrix(deformed.dynamics());
  matrix.form(gamma);
  VelocitySystem system(deformed.dynamics());
  system.set_up(gamma);
  std::vector<Vec3> product(count);
  for (const double bound : {0.9, 0.1, 1e-3}) {
    EXPECT_TRUE(system.solve(gamma, b, weight, {.residual = bound}, correction).converged);
    matrix.multiply(
        std::span(reinterpret_cast<const Vec3*>(correction.data()) + count, std::size_t(count)),
        product);
    double sum = 0, largest = 0;
    for (int i = 0; i < count; ++i) {
      const Vec3 left = Vec3(0, 0, i == kicked ? 1 : 0) - product[i] / deformed.scene().mass[i];
      sum += left.squaredNorm();
      largest = std::max(largest, left.norm());
    }
    EXPECT_LE(std::sqrt(sum), 1.01 * bound);
    EXPECT_LE(largest, 1.01 * 10 * bound / std::sqrt(count));
  }
}

// The error stays within the uncertainty of its estimate, with any preconditioner, and even if
// residuals tell little about it.
TEST(VelocitySystem, LeavesTheErrorAskedFor) {
  using Scale = VelocitySystem::Goal::Scale;
  for (const std::string preconditioner : {"multigrid", "block_jacobi"}) {
    for (const std::string pins : {"corners = [\"all\"]", "edges = [\"first_row\"]"}) {
      DeformedScene deformed({.shape = sheet(17, 17),
                              .more = "[[body.pin]]\n" + pins + "\n",
                              .material = "bending_stiffness = 1e-5",
                              .preconditioner = preconditioner});
      for (double gamma : {1e-3, 1.0 / 60, 1.0}) {
        const auto [a, right] = dense_system(deformed, gamma);
        const Eigen::VectorXd expected = solve_definite(a, right);
        const double kinetic = squared_in_masses(deformed.scene(), expected);
        const std::vector<double> b = deformed.right_side(gamma), weight(b.size(), 1.0);
        for (double fraction : {5e-2, 1e-2, 1e-4, 1e-6}) {
          for (Scale scale : {Scale::mass, Scale::matrix}) {
            SCOPED_TRACE(preconditioner + " " + pins + " " + std::to_string(gamma) + " " +
                         std::to_string(fraction));
            VelocitySystem system(deformed.dynamics());
            system.set_up(gamma);
            std::vector<double> correction(b.size());
            EXPECT_TRUE(
                system.solve(gamma, b, weight, {.error = fraction, .scale = scale}, correction)
                    .converged);
            const Eigen::VectorXd error =
                Eigen::Map<const Eigen::VectorXd>(correction.data() + b.size() / 2, a.rows()) -
                expected;
            const double all = scale == Scale::mass ? kinetic : expected.dot(a * expected);
            EXPECT_LT(std::sqrt(error.dot(a * error)), 4 * fraction * std::sqrt(all));
          }
        }
      }
    }
  }
}

TEST(Multigrid, IterationsDependOnNeitherSizeNorStep) {
  for (int n : {17, 33, 48, 65, 101, 129}) {
    DeformedScene deformed({.shape = sheet(n, n),
                            .more = "[[body.pin]]\ncorners = [\"last_first\", \"last_last\"]\n",
                            .material = "bending_stiffness = 1e-5"});
    for (double gamma : {1e-3, 1.0 / 60, 0.1}) {
      VelocitySystem system(deformed.dynamics());
      std::vector<double> correction;
      const auto outcome = deformed.solve(system, gamma, 1e-4, correction);
      EXPECT_TRUE(outcome.converged && outcome.multigrid) << n << ", " << gamma;
      EXPECT_LE(outcome.iterations, 12) << n << ", " << gamma;
      RecordProperty("iterations_" + std::to_string(n) + "_" + std::to_string(gamma),
                     outcome.iterations);
    }
  }
}

TEST(Multigrid, HasTheSameBitsOnAnyNumberOfThreads) {
  for (const char* shape : {R"({ type = "rectangle", size = [1.0, 1.0], resolution = [60, 70] })",
                            R"({ type = "sphere", radius = 0.5, resolution = [25] })"}) {
    std::vector<double> first;
    for (int threads : {1, 2, 3}) {
      DeformedScene deformed(
          {.shape = shape, .material = "bending_stiffness = 1e-5", .threads = threads});
      VelocitySystem system(deformed.dynamics());
      std::vector<double> correction;
      EXPECT_TRUE(deformed.solve(system, 0.01, 1e-6, correction).multigrid);
      if (first.empty()) first = correction;
      EXPECT_EQ(first, correction);
    }
  }
}

TEST(Multigrid, IsChosenForLongStepsAlone) {
  DeformedScene deformed({.shape = sheet(33, 33), .preconditioner = "automatic"});
  VelocitySystem system(deformed.dynamics());
  std::vector<double> correction;
  EXPECT_FALSE(deformed.solve(system, 19 / system.highest_frequency(), 1e-2, correction).multigrid);
  EXPECT_TRUE(deformed.solve(system, 21 / system.highest_frequency(), 1e-2, correction).multigrid);
}

// Systems of a short gamma begin with block-Jacobi. One that takes long goes on with multigrid, and
// so do the next ones of its gamma, but none of a shorter gamma.
TEST(Multigrid, ReplacesBlockJacobiThatTakesLong) {
  DeformedScene deformed({.shape = sheet(33, 33), .preconditioner = "automatic"});
  VelocitySystem system(deformed.dynamics());
  std::vector<double> correction;
  const double gamma = 5.5 / system.highest_frequency();
  EXPECT_FALSE(deformed.solve(system, gamma, 1e-1, correction).multigrid);
  const auto hard = deformed.solve(system, gamma, 1e-11, correction);
  EXPECT_TRUE(hard.converged && hard.multigrid);
  EXPECT_GT(hard.iterations, 60);
  const auto next = deformed.solve(system, gamma, 1e-11, correction);
  EXPECT_TRUE(next.converged && next.multigrid);
  EXPECT_LT(next.iterations, hard.iterations);
  EXPECT_FALSE(deformed.solve(system, 0.1 * gamma, 1e-4, correction).multigrid);
}

TEST(Multigrid, KeepsItsCoarseMatricesWhileTheyServe) {
  DeformedScene deformed({.shape = sheet(33, 33), .more = "[[body.pin]]\ncorners = [\"all\"]\n"});
  VelocitySystem system(deformed.dynamics());
  std::vector<double> correction;
  int set_ups = deformed.solve(system, 0.01, 1e-4, correction).multigrid_set_ups;
  EXPECT_EQ(set_ups, 1);
  for (double gamma : {0.0101, 0.0102, 0.0099})
    set_ups += deformed.solve(system, gamma, 1e-4, correction).multigrid_set_ups;
  EXPECT_EQ(set_ups, 1);
  // A step a hundred times as long needs other coarse matrices.
  for (int i = 0; i < 3; ++i)
    set_ups += deformed.solve(system, 1.0, 1e-4, correction).multigrid_set_ups;
  EXPECT_EQ(set_ups, 2);
}

// Matrices formed before the contact, with which no solve has taken iterations, are not kept.
TEST(Multigrid, FormsCoarseMatricesWhenContactComes) {
  DeformedScene deformed(sheet_on_floor("bending_stiffness = 0.1"));
  VelocitySystem system(deformed.dynamics());
  std::vector<double> correction;
  deformed.raise(0.05);
  const auto apart = deformed.solve(system, 1e-2, 1.0, correction);
  EXPECT_EQ(apart.iterations, 0);
  EXPECT_EQ(apart.multigrid_set_ups, 1);
  deformed.raise(-0.05);
  const auto touching = deformed.solve(system, 1e-2, 1e-4, correction);
  EXPECT_EQ(touching.multigrid_set_ups, 1);
  EXPECT_LE(touching.iterations, 20);
}

// The cloth is compressed, so that A is indefinite. The solver reports it, and nothing else
// happens.
TEST(Multigrid, ReportsAnIndefiniteMatrix) {
  DeformedScene deformed({.shape = sheet(17, 17)});
  std::vector<double> state = deformed.dynamics().initial_state();
  for (std::size_t i = 0; i < state.size() / 2; ++i) state[i] *= 0.5;
  deformed.dynamics().assemble(0, state);
  VelocitySystem system(deformed.dynamics());
  std::vector<double> correction;
  const auto outcome = deformed.solve(system, 0.1, 1e-8, correction);
  EXPECT_FALSE(outcome.converged);
  EXPECT_TRUE(outcome.indefinite);
}

}  // namespace
}  // namespace weft::sim::multigrid_test
