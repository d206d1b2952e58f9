// A single correction leaves the momentum of bodies that fly freely as forces make it.
#include "sim/solver/free_translations.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/sim/simulated_case.h"

namespace weft::sim::free_translations_test {
namespace {

// Two sewn pieces spin and fall beside a third one, which hangs from the pinned edge of a fourth,
// and beside a fifth, which flies by itself.
constexpr const char* pieces = R"(
[time]
duration = 0.4
[contact]
enabled = false
[material.cloth]
density = 0.3
membrane_stiffness = 1000
bending_stiffness = 1e-3
stiffness_damping = 1e-3
bending_damping = 1e-3
[[body]]
name = "left"
velocity = [2, 0, 3]
angular_velocity_deg = [0, 0, 360]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [9, 9] }
[[body]]
name = "right"
position = [0.3, 0, 0]
velocity = [2, 1.885, 3]
angular_velocity_deg = [0, 0, 360]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [7, 7] }
[[body]]
name = "hanging"
position = [5, 0, 0]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [5, 5] }
[[body]]
name = "pinned"
position = [5.3, 0, 0]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [5, 5] }
[[body.pin]]
edges = ["last_col"]
[[body]]
name = "alone"
position = [-5, 0, 0]
velocity = [0, -1, 0]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [4, 4] }
[[seam]]
body = "left"
edge = "last_col"
to = "right"
to_edge = "first_col"
[[seam]]
body = "hanging"
edge = "last_col"
to = "pinned"
to_edge = "first_col"
)";

Overrides single_corrections(double step, const Overrides& more = {}) {
  Overrides all = method("euler", {key("step", step), "time.newton=1"});
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

// Returns the mean velocity (m/s) of the particles of bodies `first` to `last`, by mass.
Vec3 mean_velocity(const SimulatedCase& run, std::span<const double> y, int first, int last) {
  Vec3 momentum = Vec3::Zero();
  double mass = 0;
  for (int b = first; b <= last; ++b) {
    const SceneBody& body = run.scene().bodies[b];
    for (int i = body.first_particle; i < body.first_particle + body.particle_count(); ++i) {
      momentum += run.scene().mass[i] * StateView::of(y).velocity[i];
      mass += run.scene().mass[i];
    }
  }
  return momentum / mass;
}

// The bodies that fly together, by their numbers.
constexpr std::array<std::array<int, 2>, 2> flying{{{0, 1}, {4, 4}}};

TEST(FreeTranslations, TakeTheMomentumThatGravityGives) {
  for (const double step : {0.0125, 0.004, 0.001}) {
    SimulatedCase run(pieces, single_corrections(step));
    std::vector<Vec3> before;
    for (const auto& [first, last] : flying)
      before.push_back(mean_velocity(run, run.integrator().state(), first, last));
    while (run.integrator().time() < 0.4 - 1e-9) ASSERT_FALSE(run.integrator().step());
    const Vec3 gained = Vec3(0, 0, -9.81 * run.integrator().time());
    for (std::size_t i = 0; i < flying.size(); ++i) {
      const Vec3 after = mean_velocity(run, run.integrator().state(), flying[i][0], flying[i][1]);
      EXPECT_LT((after - before[i] - gained).norm(), 1e-9) << step << ' ' << i;
    }
  }
}

// Drag along the normals makes A more than the mass along one axis. Nothing moves in bodies that
// hang, not even where they are sewn to pinned ones.
TEST(FreeTranslations, TakeTheResidualOfEachFreeBodyAndLeaveHeldBodiesAlone) {
  SimulatedCase run(pieces, single_corrections(0.01, {"material.cloth.normal_drag=20"}));
  Dynamics& dynamics = run.dynamics();
  const std::vector<double> y = dynamics.initial_state();
  std::vector<double> rate(y.size());
  ASSERT_FALSE(dynamics.rate(0, y, rate));
  dynamics.assemble(0, y);
  VelocityMatrix matrix(dynamics);
  matrix.form(0.01);
  std::vector<Vec3> residual(dynamics.particle_count()), correction(residual), product(residual);
  for (std::size_t i = 0; i < residual.size(); ++i)
    residual[i] = run.scene().pinned[i] != 0 ? Vec3(0, 0, 0) : Vec3(1, 0.01 * double(i), -2);
  ASSERT_TRUE(FreeTranslations(matrix).correct(residual, correction, product));

  std::vector<Vec3> expected(residual.size());
  matrix.multiply(correction, expected);
  for (std::size_t i = 0; i < residual.size(); ++i)
    EXPECT_LT((product[i] - expected[i]).norm(), 1e-9) << i;
  for (const auto& [first, last] : flying) {
    const int begin = run.scene().bodies[first].first_particle;
    const int end =
        run.scene().bodies[last].first_particle + run.scene().bodies[last].particle_count();
    Vec3 left = Vec3::Zero(), force = Vec3::Zero();
    double mass = 0;
    for (int i = begin; i < end; ++i) {
      EXPECT_EQ(correction[i], correction[begin]) << i;
      force += residual[i];
      left += residual[i] - product[i];
      mass += run.scene().mass[i];
    }
    EXPECT_LT(left.norm(), 1e-9 * force.norm()) << first;
    EXPECT_NEAR(correction[begin].x(), force.x() / mass, 1e-2 * force.x() / mass) << first;
    EXPECT_LT(std::abs(correction[begin].z()), 0.9 * std::abs(force.z()) / mass) << first;
  }
  for (const int b : {2, 3}) {
    const SceneBody& body = run.scene().bodies[b];
    for (int i = body.first_particle; i < body.first_particle + body.particle_count(); ++i)
      EXPECT_EQ(correction[i], Vec3(0, 0, 0)) << i;
  }
}

}  // namespace
}  // namespace weft::sim::free_translations_test
