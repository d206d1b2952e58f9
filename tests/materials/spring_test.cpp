#include "materials/spring.h"

#include <gtest/gtest.h>

#include "tests/materials/finite_difference.h"

namespace weft::materials::spring_test {
namespace {

constexpr int kTrials = 200;

struct State {
  Spring spring;
  Vec3 x0, x1, v0, v1;
};

// Returns springs that are long beside the difference step, so that its error is small.
State random_state(std::mt19937& generator) {
  std::uniform_real_distribution<double> uniform(0.5, 2);
  State state;
  state.spring = {uniform(generator), 100 * uniform(generator), 0.1 * uniform(generator)};
  state.x0 = random_matrix<Vec3>(generator);
  state.x1 = state.x0 + uniform(generator) * random_matrix<Vec3>(generator).normalized();
  state.v0 = random_matrix<Vec3>(generator);
  state.v1 = random_matrix<Vec3>(generator);
  return state;
}

TEST(Spring, ForceIsMinusTheGradientOfTheEnergy) {
  std::mt19937 generator(1);
  for (int trial = 0; trial < kTrials; ++trial) {
    State s = random_state(generator);
    s.spring.damping_time = 0;
    const auto energy = [&](const Vec3& x) { return as_matrix(spring_energy(s.spring, x, s.x1)); };
    const Vec3 gradient = finite_difference(energy, s.x0).transpose();
    EXPECT_LT((spring_force(s.spring, s.x0, s.x1, s.v0, s.v1) + gradient).norm(),
              1e-9 * s.spring.stiffness);
  }
}

TEST(Spring, StiffnessIsMinusTheDerivativeOfTheForce) {
  std::mt19937 generator(2);
  for (int trial = 0; trial < kTrials; ++trial) {
    State s = random_state(generator);
    s.spring.damping_time = 0;
    const auto force = [&](const Vec3& x) -> Eigen::MatrixXd {
      return -spring_force(s.spring, x, s.x1, s.v0, s.v1);
    };
    EXPECT_LT(relative_error(finite_difference(force, s.x0),
                             spring_stiffness(s.spring, s.x0, s.x1, s.v0, s.v1)),
              1e-8);
  }
}

// With damping, the stiffness has the whole tension in its geometric part: rotating the spring at
// constant length and velocity of extension rotates the damped force too.
TEST(Spring, StiffnessTurnsTheDampedTension) {
  std::mt19937 generator(3);
  for (int trial = 0; trial < kTrials; ++trial) {
    const State s = random_state(generator);
    const Vec3 direction = (s.x1 - s.x0).normalized();
    const Vec3 across = direction.cross(random_matrix<Vec3>(generator)).normalized();
    const double rate = direction.dot(s.v1 - s.v0);
    const Vec3 force = spring_force(s.spring, s.x0, s.x1, s.v0, s.v1);
    const Mat3 stiffness = spring_stiffness(s.spring, s.x0, s.x1, s.v0, s.v1);
    const double tension_over_length = force.dot(direction) / (s.x1 - s.x0).norm();
    EXPECT_NEAR(tension_over_length * (s.x1 - s.x0).norm(),
                s.spring.stiffness *
                    ((s.x1 - s.x0).norm() - s.spring.rest_length + s.spring.damping_time * rate),
                1e-10 * s.spring.stiffness);
    EXPECT_LT((stiffness * across - tension_over_length * across).norm(), 1e-10 * stiffness.norm());
    EXPECT_LT((stiffness * direction - s.spring.stiffness * direction).norm(),
              1e-10 * stiffness.norm());
  }
}

TEST(Spring, DampingIsMinusTheDerivativeByVelocity) {
  std::mt19937 generator(4);
  for (int trial = 0; trial < kTrials; ++trial) {
    const State s = random_state(generator);
    const auto force = [&](const Vec3& v) -> Eigen::MatrixXd {
      return -spring_force(s.spring, s.x0, s.x1, v, s.v1);
    };
    const Mat3 damping = spring_damping(s.spring, s.x0, s.x1);
    EXPECT_LT(relative_error(finite_difference(force, s.v0), damping), 1e-9);
    EXPECT_GT(eigenvalues(damping)[0], -1e-12 * damping.norm());
  }
}

TEST(Spring, ForceIsOppositeOnTheOtherNodeAndAlongTheSpring) {
  std::mt19937 generator(5);
  for (int trial = 0; trial < kTrials; ++trial) {
    const State s = random_state(generator);
    const Vec3 force0 = spring_force(s.spring, s.x0, s.x1, s.v0, s.v1);
    const Vec3 force1 = spring_force(s.spring, s.x1, s.x0, s.v1, s.v0);
    EXPECT_LT((force0 + force1).norm(), 1e-12 * force0.norm());
    EXPECT_LT((s.x1 - s.x0).cross(force0).norm(), 1e-12 * force0.norm());
  }
}

TEST(Spring, DampingTakesEnergyAndSparesRigidMotion) {
  std::mt19937 generator(6);
  for (int trial = 0; trial < kTrials; ++trial) {
    State s = random_state(generator);
    const Vec3 damped = spring_force(s.spring, s.x0, s.x1, s.v0, s.v1) -
                        spring_force(s.spring, s.x0, s.x1, Vec3::Zero(), Vec3::Zero());
    EXPECT_LE(damped.dot(s.v0 - s.v1), 0);
    const Vec3 omega = random_matrix<Vec3>(generator);
    s.spring.rest_length = (s.x1 - s.x0).norm();
    const Vec3 rigid = spring_force(s.spring, s.x0, s.x1, omega.cross(s.x0), omega.cross(s.x1));
    EXPECT_LT(rigid.norm(), 1e-13 * s.spring.stiffness);
  }
}

TEST(Spring, CoincidentNodesGiveNoForce) {
  const Vec3 x(1, 2, 3);
  const Vec3 v(1, 0, 0);
  for (const double rest_length : {0.0, 1.0}) {
    const Spring spring{rest_length, 10, 0.1};
    EXPECT_EQ(spring_force(spring, x, x, v, -v), Vec3(Vec3::Zero()));
    EXPECT_EQ(spring_stiffness(spring, x, x, v, -v), Mat3(10 * Mat3::Identity()));
    EXPECT_EQ(spring_damping(spring, x, x), Mat3(Mat3::Zero()));
  }
}

}  // namespace
}  // namespace weft::materials::spring_test
