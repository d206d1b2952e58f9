// Other libraries get the same problem that Weft simulates.
#include <gtest/gtest.h>

#include <random>
#include <sstream>

#include "bench/cloth_peers.h"
#include "sim/case/case_reader.h"
#include "sim/motion/dynamics.h"

namespace weft::bench::cloth_peers_test {
namespace {

using namespace sim;

std::unique_ptr<const Scene> sheet(const std::vector<std::string>& overrides) {
  return build_scene(read_case(WEFT_CASES_DIR "/spring_sheet.toml", overrides));
}

template <class T>
T through_text(const T& value) {
  std::stringstream text;
  text << value;
  T read;
  EXPECT_TRUE(text >> read);
  return read;
}

TEST(ClothText, IsExact) {
  ClothProblem problem = cloth_problem(*sheet({"body.sheet.shape.resolution=[3,4]"}));
  problem.ball = {{0.1, 1.0 / 3, -2}, 0.25, 2e-3, 0.3};
  const ClothProblem read = through_text(problem);
  EXPECT_EQ(read.gravity, problem.gravity);
  EXPECT_EQ(read.position, problem.position);
  EXPECT_EQ(read.velocity, problem.velocity);
  EXPECT_EQ(read.mass, problem.mass);
  ASSERT_EQ(read.springs.size(), problem.springs.size());
  for (std::size_t i = 0; i < read.springs.size(); ++i) {
    EXPECT_EQ(read.springs[i].ends, problem.springs[i].ends);
    EXPECT_EQ(read.springs[i].rest_length, problem.springs[i].rest_length);
    EXPECT_EQ(read.springs[i].stiffness, problem.springs[i].stiffness);
  }
  EXPECT_EQ(read.ball.centre, problem.ball.centre);
  EXPECT_EQ(read.ball.radius, problem.ball.radius);
  EXPECT_EQ(read.ball.gap, problem.ball.gap);
  EXPECT_EQ(read.ball.friction, problem.ball.friction);
  const ClothSettings settings =
      through_text(ClothSettings{"soft-body", 1.0 / 3, 7, 4, 1e-7, true, 0.1});
  EXPECT_EQ(settings.method, "soft-body");
  EXPECT_EQ(settings.step, 1.0 / 3);
  EXPECT_EQ(settings.steps, 7);
  EXPECT_EQ(settings.iterations, 4);
  EXPECT_EQ(settings.tolerance, 1e-7);
  EXPECT_TRUE(settings.line_search);
  EXPECT_EQ(settings.budget, 0.1);
  for (const std::string failure : {"", "two words"}) {
    const ClothOutcome outcome = through_text(ClothOutcome{failure, 0.1, {{1.0 / 3, 2, -3}}});
    EXPECT_EQ(outcome.failure, failure);
    EXPECT_EQ(outcome.cpu, 0.1);
    EXPECT_EQ(outcome.position, (std::vector<std::array<double, 3>>{{1.0 / 3, 2, -3}}));
  }
}

// At any positions, the problem has the energies that Weft's forces come from.
TEST(ClothProblem, HasTheEnergyOfTheScene) {
  const auto scene = sheet({"body.sheet.shape.resolution=[5,7]", "body.sheet.stretch=[1.1,1,1]",
                            "material.net.shear_stiffness=77", "material.net.bend_stiffness=11"});
  const ClothProblem problem = cloth_problem(*scene);
  ASSERT_EQ(problem.mass.size(), 35u);
  Statistics statistics;
  Dynamics dynamics(*scene, statistics);
  std::vector<double> state = dynamics.initial_state();
  std::mt19937 random(1);
  std::normal_distribution<double> shift(0, 0.03);
  const auto is_held = [&](std::size_t i) { return problem.mass[i] == 0; };
  std::vector<Vec3> position;
  for (std::size_t i = 0; i < 35; ++i) {
    EXPECT_EQ(is_held(i), !scene->is_free(static_cast<int>(i)));
    if (!is_held(i))
      for (std::size_t c = 0; c < 3; ++c) state[3 * i + c] = problem.position[i][c] + shift(random);
    position.emplace_back(state[3 * i], state[3 * i + 1], state[3 * i + 2]);
  }
  double elastic = 0, gravitational = 0;
  for (const ClothSpring& spring : problem.springs) {
    const double extension =
        (position[spring.ends[0]] - position[spring.ends[1]]).norm() - spring.rest_length;
    elastic += 0.5 * spring.stiffness * extension * extension;
  }
  for (std::size_t i = 0; i < 35; ++i) {
    const double mass = is_held(i) ? scene->mass[i] : problem.mass[i];
    gravitational -= mass * Eigen::Map<const Vec3>(problem.gravity.data()).dot(position[i]);
  }
  const Energies energies = dynamics.energies(0, state);
  EXPECT_NEAR(energies.total(), elastic + gravitational, 1e-12 * elastic);
  EXPECT_GT(elastic, 0.1);
}

TEST(ClothProblem, SaysWhatItCannotExpress) {
  const auto reason = [](const std::string& change) {
    return beyond_peers(*sheet({change})).value_or("");
  };
  EXPECT_EQ(beyond_peers(*sheet({})), std::nullopt);
  EXPECT_NE(reason("contact.enabled=true").find("contact"), std::string::npos);
  EXPECT_NE(reason("material.net.bending_stiffness=1e-5").find("bending"), std::string::npos);
  EXPECT_NE(reason("material.net.mass_damping=1").find("damping"), std::string::npos);
  EXPECT_NE(reason("material.net.stiffness_damping=1e-3").find("damping"), std::string::npos);
  EXPECT_NE(reason("material.net.normal_drag=1").find("drag"), std::string::npos);
  const auto triangles = build_scene(read_case(WEFT_CASES_DIR "/vibrating_membrane.toml"));
  EXPECT_NE(beyond_peers(*triangles).value_or("").find("springs"), std::string::npos);
}

}  // namespace
}  // namespace weft::bench::cloth_peers_test
