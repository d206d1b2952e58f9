// Modes of parts of symmetric shells: planes of symmetry and supports along axes hold exactly.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "mode_case.h"
#include "sim/modes/mode_unknowns.h"
#include "sim/scene/sliding_supports.h"

namespace weft::sim::symmetric_modes_test {
namespace {

constexpr double youngs_modulus = 2.1e11, poisson_ratio = 0.3, density = 7850;

double rigidity(double thickness) {
  return youngs_modulus * std::pow(thickness, 3) / (12 * (1 - poisson_ratio * poisson_ratio));
}

// A quarter of a simply supported square steel plate with sides of 1 m.
Case quarter_plate(double thickness, const std::string& more = "") {
  return parse_case(R"(
[time]
method = "static"
duration = 1
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.steel]
model = "shell"
youngs_modulus = 2.1e11
poisson_ratio = 0.3
volume_density = 7850
shell_thickness = )" + std::to_string(thickness) +
                        R"(
[[body]]
name = "plate"
position = [0.25, 0.25, 0]
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [13, 13] }
pin = [{ edges = ["first_col"], symmetry_normal = [1, 0, 0] },
       { edges = ["first_row"], symmetry_normal = [0, 1, 0] },
       { edges = ["last_col", "last_row"], axes = ["z"] }]
)" + more,
                    "plate.toml");
}

// Plates whose sides are 100 to 10,000 times their thickness. omega = pi^2 (m^2 + n^2) sqrt(D / rho
// h) with odd m and n.
TEST(QuarterPlate, HasTheSymmetricModesHoweverThin) {
  constexpr std::array expected{2.0, 10.0, 10.0, 18.0};
  for (const double thickness : {1e-2, 1e-3, 1e-4}) {
    const double unit =
        std::pow(std::numbers::pi, 2) * std::sqrt(rigidity(thickness) / (density * thickness));
    for (const int count : {1, 2, 4}) {
      const VibrationModes found = modes_of(quarter_plate(thickness), count);
      ASSERT_EQ(found.modes.size(), static_cast<std::size_t>(count));
      for (int i = 0; i < count; ++i) {
        EXPECT_EQ(found.modes[i].kind, VibrationMode::Kind::vibration);
        EXPECT_NEAR(found.modes[i].angular_frequency() / unit, expected[i], 1e-4 * expected[i])
            << thickness << ", " << i;
      }
    }
  }
}

// A plate under a force per length of 4 pi^2 D / L^2 along x buckles at the factor 1 (Navier).
TEST(QuarterPlate, BucklesAtItsLoadHoweverThin) {
  for (const double thickness : {1e-2, 1e-3, 1e-4}) {
    const double load = 4 * std::pow(std::numbers::pi, 2) * rigidity(thickness);
    char force[64];
    std::snprintf(force, sizeof force, "[%.17g, 0, 0]", -load);
    const BucklingModes found =
        buckling_of(quarter_plate(thickness,
                                  "[[load]]\nbody = \"plate\"\ntype = \"line\"\n"
                                  "edges = [\"last_col\"]\nforce = " +
                                      std::string(force) + "\n"),
                    1);
    ASSERT_FALSE(found.failure) << found.failure->text;
    EXPECT_NEAR(found.modes.at(0).load_factor, 1, 1e-4) << thickness;
  }
}

// Two planes of symmetry that meet both hold the height of the corner's neighbours.
TEST(ModeUnknowns, AreWhatPinsAndSupportsLeaveFree) {
  const auto scene = build_scene(quarter_plate(1e-3));
  const ModeUnknowns unknowns(*scene);
  std::vector<Vec3> moved(scene->dynamic_particles);
  for (Eigen::Index i = 0; i < unknowns.count(); ++i) {
    const Eigen::VectorXd one = Eigen::VectorXd::Unit(unknowns.count(), i);
    unknowns.scatter(one, moved);
    EXPECT_LT((unknowns.gather(moved) - one).norm(), 1e-13);
    const SceneBody& body = scene->bodies[0];
    for (const SlidingSupport& support : body.supports->all) {
      double held = support.direction.dot(moved[support.particle]);
      if (support.base >= 0) held -= support.direction.dot(moved[support.base]);
      EXPECT_LT(std::abs(held), 1e-13);
    }
  }
  // z: both borders on supports have none, and the rows and columns beside the planes of symmetry
  // move with those on them. x: the column on its plane has none, and the row beside the other
  // plane moves with that on it. y: likewise.
  EXPECT_EQ(unknowns.count(), 11 * 11 + 2 * 12 * 12);
}

}  // namespace
}  // namespace weft::sim::symmetric_modes_test
