// Bullet simulates the same physics: closed forms, and Weft's own solution of a sheet.
#include <gtest/gtest.h>

#include <cmath>

#include "bench/cloth_peers.h"
#include "bench/reference_run.h"
#include "sim/accuracy/error_monitor.h"
#include "sim/case/case_reader.h"

namespace weft::bench::bullet_cloth_test {
namespace {

using namespace sim;

ClothSettings settings_of(const char* method, double end, long steps, int iterations = 1) {
  ClothSettings settings{.method = method, .iterations = iterations, .budget = 60};
  settings.step = end / static_cast<double>(steps);
  settings.steps = steps;
  return settings;
}

// A mass below a held one, released where its spring is at rest. It hangs at L + m g / k (1 -
// cos(omega t)).
struct Pendulum {
  double mass = 0.02, stiffness = 200, length = 0.5, gravity = 9.81, end = 0.05;
  ClothProblem problem() const {
    return {.gravity = {0, 0, -gravity},
            .position = {{0, 0, 0}, {0, 0, -length}},
            .velocity = {{0, 0, 0}, {0, 0, 0}},
            .mass = {0, mass},
            .springs = {{{0, 1}, length, stiffness}}};
  }
  double sag() const { return mass * gravity / stiffness; }
  double exact() const {
    return -length - sag() * (1 - std::cos(std::sqrt(stiffness / mass) * end));
  }
  double error(const char* method, long steps, int iterations = 1) const {
    const ClothOutcome outcome =
        simulate_cloth(problem(), settings_of(method, end, steps, iterations));
    EXPECT_EQ(outcome.failure, "");
    EXPECT_EQ(outcome.position[0], (std::array<double, 3>{0, 0, 0}));
    return outcome.position[1][2] - exact();
  }
};

TEST(BulletCloth, DeformableSpringHasItsClosedForm) {
  const Pendulum pendulum;
  for (const char* method : {"deformable", "deformable-explicit"}) {
    const double coarse = pendulum.error(method, 1000), fine = pendulum.error(method, 2000);
    EXPECT_LT(std::abs(fine), 0.01 * pendulum.sag()) << method;
    EXPECT_NEAR(coarse / fine, 2, 0.05) << method;
  }
}

// A strain e makes the spring of a soft body stiffer by e / 2. Small swings converge to the closed
// form; large ones do not.
TEST(BulletCloth, SoftBodySpringIsRightForSmallStrain) {
  const auto limit_error = [](const Pendulum& pendulum, int iterations) {
    const double coarse = pendulum.error("soft-body", 2000, iterations),
                 fine = pendulum.error("soft-body", 4000, iterations);
    return std::abs(2 * fine - coarse) / pendulum.sag();
  };
  Pendulum small, large;
  small.gravity = 0.0981;
  large.gravity = 500;  // sags by a tenth of its length
  for (const int iterations : {1, 4}) {
    EXPECT_NEAR(
        small.error("soft-body", 2000, iterations) / small.error("soft-body", 4000, iterations), 2,
        0.15)
        << iterations;
    EXPECT_LT(limit_error(small, iterations), 1e-3) << iterations;
    EXPECT_GT(limit_error(large, iterations), 1e-2) << iterations;
  }
}

struct Sheet {
  std::unique_ptr<const Scene> scene;
  Reference reference;
  double error(const ClothSettings& settings) const {
    const ClothOutcome outcome = simulate_cloth(cloth_problem(*scene), settings);
    EXPECT_EQ(outcome.failure, "");
    std::vector<Vec3> position;
    for (const auto& p : outcome.position) position.emplace_back(p[0], p[1], p[2]);
    return rms_distance(position, reference.positions.back());
  }
};

Sheet make_sheet(const std::vector<std::string>& overrides) {
  std::vector<std::string> all{"body.sheet.shape.resolution=[9,9]"};
  all.insert(all.end(), overrides.begin(), overrides.end());
  const Case source = read_case(WEFT_CASES_DIR "/spring_sheet.toml", all);
  return {build_scene(source),
          find_reference(source, {0.15}, {.tolerance = 1e-8, .certainty = 1e-5, .budget = 30})};
}

// The error vanishes with the step, so the limit is Weft's; also for springs of two stiffnesses.
TEST(BulletCloth, DeformableSheetConvergesToThatOfWeft) {
  for (const char* shear : {"500", "250"}) {
    const Sheet sheet = make_sheet({std::string("material.net.shear_stiffness=") + shear});
    ASSERT_EQ(sheet.reference.horizon, 0.15);
    for (const char* method : {"deformable", "deformable-explicit"}) {
      const double coarse = sheet.error(settings_of(method, 0.15, 500)),
                   fine = sheet.error(settings_of(method, 0.15, 1000));
      EXPECT_LT(fine, 1e-3) << method;
      EXPECT_NEAR(coarse / fine, 2, 0.15) << method;
    }
    EXPECT_LT(sheet.error(settings_of("soft-body", 0.15, 4000)), 1e-3);
  }
}

// A point mass that falls on a ball stays on top of it.
// Nodes sink some millimetres into the ball, with shorter steps too.
TEST(BulletCloth, SoftBodyIsStoppedByABall) {
  ClothProblem problem;
  problem.gravity = {0, 0, -9.81};
  problem.position = {{0, 0, 0.3}, {0.01, 0, 0.3}};
  problem.velocity = {{0, 0, 0}, {0, 0, 0}};
  problem.mass = {0.01, 0.01};
  problem.springs = {{{0, 1}, 0.01, 100}};
  problem.ball = {{0, 0, 0}, 0.25, 0.002, 0.3};
  const ClothOutcome outcome = simulate_cloth(problem, settings_of("soft-body", 0.25, 60));
  EXPECT_EQ(outcome.failure, "");
  for (const auto& p : outcome.position) {
    EXPECT_GT(std::hypot(p[0], p[1], p[2]), 0.24);
    EXPECT_LT(std::hypot(p[0], p[1], p[2]), 0.26);
  }
  EXPECT_THROW(simulate_cloth(problem, settings_of("deformable", 0.1, 1)), std::invalid_argument);
}

TEST(BulletCloth, RefusesWhatItCannotExpress) {
  const Sheet sheet{
      build_scene(read_case(WEFT_CASES_DIR "/spring_sheet.toml",
                            {"body.sheet.shape.resolution=[9,9]", "material.net.shear_stiffness=1",
                             "material.net.bend_stiffness=2"})),
      {}};
  EXPECT_THROW(simulate_cloth(cloth_problem(*sheet.scene), settings_of("deformable", 0.1, 1)),
               std::invalid_argument);
  EXPECT_THROW(simulate_cloth(cloth_problem(*sheet.scene), settings_of("rigid", 0.1, 1)),
               std::invalid_argument);
}

}  // namespace
}  // namespace weft::bench::bullet_cloth_test
