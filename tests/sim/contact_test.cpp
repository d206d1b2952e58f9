// Contact: forces against their energy, candidate pairs against brute force, friction against
// closed forms, and refusal of paths that would cross.
#include "sim/contact/contact.h"

#include <cmath>
#include <numbers>
#include <random>

#include "sim/case/case_error.h"
#include "sim/run/initial_state.h"
#include "sim/run/recorded_run.h"
#include "sim/view/crossings.h"
#include "simulated_case.h"

namespace weft::sim::contact_test {
namespace {

// Two sheets, crumpled at random, slightly above each other and over a sphere: every kind of pair
// is in reach.
std::string two_sheets(double friction, double damping) {
  return R"(
[time]
duration = 1
[contact]
range = 0.05
stiffness = 1e4
search_slack = 0.02
friction = )" +
         std::to_string(friction) + "\ndamping_time = " + std::to_string(damping) + R"(
[[body]]
name = "lower"
thickness = 0.002
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [9, 9] }
[[body]]
name = "upper"
position = [0.03, 0.02, 0.055]
rotation_deg = [1, 1.5, 40]
thickness = 0.004
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [9, 9] }
[[obstacle]]
name = "ball"
position = [0, 0, -0.33]
shape = { type = "sphere", radius = 0.3, resolution = [7] }
)";
}

struct RandomState {
  std::vector<Vec3> position, velocity;
};

RandomState random_state(const Scene& scene, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-0.012, 0.012);
  RandomState state{scene.initial_position, std::vector<Vec3>(scene.particle_count, Vec3::Zero())};
  for (int i = 0; i < scene.dynamic_particles; ++i) {
    state.position[i] += Vec3(shift(random), shift(random), shift(random));
    state.velocity[i] = 10 * Vec3(shift(random), shift(random), shift(random));
  }
  return state;
}

double energy_at(Contact& contact, const RandomState& state) {
  EXPECT_FALSE(contact.evaluate(state.position, state.velocity, 1));
  return contact.energy();
}

std::vector<Vec3> forces_at(Contact& contact, const Scene& scene, const RandomState& state) {
  EXPECT_FALSE(contact.evaluate(state.position, state.velocity, 1));
  std::vector<Vec3> force(scene.dynamic_particles, Vec3::Zero());
  contact.add_forces(force);
  return force;
}

TEST(Contact, ForceIsMinusTheSlopeOfTheEnergy) {
  const auto scene = build_scene(parse_case(two_sheets(0, 0), "test.toml"));
  Statistics statistics;
  Contact contact(*scene, statistics);
  RandomState state = random_state(*scene, 1);
  for (Vec3& v : state.velocity) v.setZero();
  const std::vector<Vec3> force = forces_at(contact, *scene, state);
  ASSERT_GT(contact.pairs_in_reach(), 70U);
  const double step = 1e-7;
  double largest = 0;
  for (const Vec3& f : force) largest = std::max(largest, f.norm());
  for (int i = 0; i < scene->dynamic_particles; i += 7) {
    for (int axis = 0; axis < 3; ++axis) {
      RandomState moved = state;
      moved.position[i][axis] += step;
      const double above = energy_at(contact, moved);
      moved.position[i][axis] -= 2 * step;
      const double below = energy_at(contact, moved);
      EXPECT_NEAR(force[i][axis], -(above - below) / (2 * step), 1e-5 * largest);
    }
  }
}

TEST(Contact, DampingBlocksAreTheSlopeOfTheForceInVelocity) {
  for (double friction : {0.0, 0.4}) {
    const auto scene = build_scene(parse_case(two_sheets(friction, 1e-3), "test.toml"));
    Statistics statistics;
    Contact contact(*scene, statistics);
    const RandomState state = random_state(*scene, 2);
    // For gamma -> 0, the product with gamma K + D leaves D, which is exact: the limit of friction
    // is the push of the barrier, which does not depend on the velocity.
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    std::vector<Vec3> direction(scene->dynamic_particles);
    for (Vec3& d : direction) d = Vec3(normal(random), normal(random), normal(random));
    const double step = 1e-6;
    RandomState ahead = state, behind = state;
    for (int i = 0; i < scene->dynamic_particles; ++i) {
      ahead.velocity[i] += step * direction[i];
      behind.velocity[i] -= step * direction[i];
    }
    const std::vector<Vec3> above = forces_at(contact, *scene, ahead),
                            below = forces_at(contact, *scene, behind);
    forces_at(contact, *scene, state);
    std::vector<Vec3> product(scene->dynamic_particles, Vec3::Zero());
    const double gamma = 1e-9;
    contact.add_product(gamma, direction, product);
    double difference = 0, size = 0;
    for (int i = 0; i < scene->dynamic_particles; ++i) {
      const Vec3 slope = -(above[i] - below[i]) / (2 * step);
      difference += (slope - product[i] / gamma).squaredNorm();
      size += slope.squaredNorm();
    }
    EXPECT_LT(std::sqrt(difference / size), 1e-4) << friction;
  }
}

// Evaluates contact at an iterate, and returns the product of its matrix for `gamma` (s) with the
// velocities.
std::vector<Vec3> product_at(Contact& contact, const Scene& scene, const RandomState& iterate,
                             double gamma) {
  forces_at(contact, scene, iterate);
  std::vector<Vec3> product(scene.dynamic_particles, Vec3::Zero());
  contact.add_product(gamma, std::span<const Vec3>(iterate.velocity).first(product.size()),
                      product);
  return product;
}

// Beyond friction_speed, friction has no slope along the sliding velocity. An iterate that slides
// against the last one gets the secant there: the product with its own sliding velocity is the
// friction, but for its sign. The next iterate, which does not turn back, has the derivative again.
TEST(Contact, FrictionHasTheSlopeOfItsSecantWhereAnIterateTurnsBack) {
  const auto scene = build_scene(parse_case(two_sheets(0.4, 0), "test.toml"));
  Statistics statistics;
  Contact contact(*scene, statistics);
  RandomState state = random_state(*scene, 2), back = state;
  for (Vec3& v : state.velocity) v *= 1e4;
  for (std::size_t i = 0; i < back.velocity.size(); ++i) back.velocity[i] = -state.velocity[i];
  const double gamma = 1e-9;
  const std::vector<Vec3> derivative = product_at(contact, *scene, back, gamma);
  contact.begin_newton();
  product_at(contact, *scene, state, gamma);
  const std::vector<Vec3> turned = product_at(contact, *scene, back, gamma);
  EXPECT_EQ(product_at(contact, *scene, back, gamma), derivative);
  std::vector<Vec3> normal(turned.size(), Vec3::Zero()), friction = normal;
  contact.add_forces(normal, friction);
  double difference = 0, size = 0;
  for (std::size_t i = 0; i < turned.size(); ++i) {
    difference += ((turned[i] - derivative[i]) / gamma + friction[i]).squaredNorm();
    size += friction[i].squaredNorm();
  }
  EXPECT_GT(size, 0);
  EXPECT_LT(std::sqrt(difference / size), 1e-6);
  contact.begin_newton();
  EXPECT_EQ(product_at(contact, *scene, back, gamma), derivative);
}

// With a given number of corrections, all iterates have the secant wherever they slide.
TEST(Contact, FrictionHasTheSlopeOfItsSecantInGivenCorrections) {
  const auto scene =
      build_scene(parse_case(two_sheets(0.4, 0), "test.toml",
                             {"time.method=\"euler\"", "time.newton=1", "time.step=1e-3"}));
  Statistics statistics;
  Contact contact(*scene, statistics);
  contact.keep_matrix_definite();
  RandomState state = random_state(*scene, 2);
  for (Vec3& v : state.velocity) v *= 1e4;
  const double gamma = 1e-9;
  const std::vector<Vec3> derivative = product_at(contact, *scene, state, gamma);
  for (int solve = 0; solve < 2; ++solve) {
    contact.begin_newton();
    const std::vector<Vec3> secant = product_at(contact, *scene, state, gamma);
    EXPECT_NE(secant, derivative);
    for (int iterate = 1; iterate < 5; ++iterate)
      EXPECT_EQ(product_at(contact, *scene, state, gamma), secant);
  }
}

TEST(Contact, ForcesBetweenBodiesSumToZeroAndDissipate) {
  const auto scene = build_scene(
      parse_case(two_sheets(0.3, 1e-3), "test.toml", {"obstacle.ball.position=[0, 0, -9]"}));
  Statistics statistics;
  Contact contact(*scene, statistics);
  const RandomState state = random_state(*scene, 4);
  const std::vector<Vec3> force = forces_at(contact, *scene, state);
  Vec3 sum = Vec3::Zero();
  double size = 0;
  for (const Vec3& f : force) {
    sum += f;
    size += f.norm();
  }
  ASSERT_GT(size, 0);
  EXPECT_LT(sum.norm(), 1e-12 * size);
  // There is no torque: barrier and damping act along the lines between closest points, and
  // friction acts at one point for both sides.
  Vec3 torque = Vec3::Zero();
  for (int i = 0; i < scene->dynamic_particles; ++i) torque += state.position[i].cross(force[i]);
  EXPECT_LT(torque.norm(), 1e-12 * size);
  // Damping and friction take power from the motion.
  const auto frictionless =
      build_scene(parse_case(two_sheets(0, 0), "test.toml", {"obstacle.ball.position=[0, 0, -9]"}));
  Contact barrier(*frictionless, statistics);
  const std::vector<Vec3> elastic = forces_at(barrier, *frictionless, state);
  double power = 0;
  for (int i = 0; i < scene->dynamic_particles; ++i)
    power += (force[i] - elastic[i]).dot(state.velocity[i]);
  EXPECT_LT(power, 0);
}

// A rigid motion of all bodies together has no friction, however fast it rotates.
TEST(Contact, FrictionAndDampingTakeNoPowerFromARigidMotion) {
  for (const std::string ball :
       {"obstacle.ball.position=[0, 0, -9]", "obstacle.ball.motion.velocity=[1, 0, 0]"}) {
    const auto scene = build_scene(parse_case(two_sheets(0.5, 1e-3), "test.toml", {ball}));
    const auto bare = build_scene(parse_case(two_sheets(0, 0), "test.toml", {ball}));
    Statistics statistics;
    Contact contact(*scene, statistics), barrier(*bare, statistics);
    RandomState state = random_state(*scene, 7);
    const Vec3 spin(3, -4, 5), drift(1, 2, -3);
    for (int i = 0; i < scene->particle_count; ++i)
      state.velocity[i] = drift + spin.cross(state.position[i]);
    const std::vector<Vec3> force = forces_at(contact, *scene, state);
    const std::vector<Vec3> elastic = forces_at(barrier, *bare, state);
    double largest = 0, extra = 0;
    for (int i = 0; i < scene->dynamic_particles; ++i) {
      largest = std::max(largest, elastic[i].norm());
      extra = std::max(extra, (force[i] - elastic[i]).norm());
    }
    ASSERT_GT(largest, 0);
    EXPECT_LT(extra, 1e-9 * largest) << ball;
  }
}

// A sheet over a plane is raised as a whole. The slope of the force in the gap equals the matrix,
// at rest and while the sheet approaches or departs.
TEST(Contact, StiffnessBlocksAreTheSlopeOfThePushInTheGap) {
  const auto scene = build_scene(parse_case(R"(
[time]
duration = 1
[contact]
range = 0.05
[material.cloth]
[[body]]
name = "sheet"
position = [0.1, 0.05, 0.03]
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [5, 5] }
[[obstacle]]
name = "plane"
shape = { type = "rectangle", size = [3.0, 3.0], resolution = [4, 4] }
)",
                                            "test.toml"));
  Statistics statistics;
  Contact contact(*scene, statistics);
  for (double speed : {0.0, -2.0, 1.0}) {
    RandomState state{scene->initial_position,
                      std::vector<Vec3>(scene->particle_count, Vec3::Zero())};
    for (int i = 0; i < 25; ++i) state.velocity[i].z() = speed;
    const auto sum_raised_by = [&](double height) {
      RandomState raised = state;
      for (int i = 0; i < 25; ++i) raised.position[i].z() += height;
      double sum = 0;
      for (const Vec3& f : forces_at(contact, *scene, raised)) sum += f.z();
      return sum;
    };
    const double step = 1e-7;
    const double slope = (sum_raised_by(step) - sum_raised_by(-step)) / (2 * step);
    forces_at(contact, *scene, state);
    std::vector<Vec3> product(25, Vec3::Zero());
    contact.subtract_stiffness(1, std::vector<Vec3>(25, Vec3::UnitZ()), product);
    double sum = 0;
    for (const Vec3& p : product) sum += p.z();
    EXPECT_NE(slope, 0);
    EXPECT_NEAR(sum, slope, 1e-6 * std::abs(slope)) << speed;
  }
}

// Two sheets in a line, edge to edge; their edges cross at an angle.
std::unique_ptr<const Scene> edges_at_angle(double degrees, const Overrides& overrides = {}) {
  return build_scene(parse_case(
      R"(
[time]
duration = 1
[contact]
range = 0.02
[material.cloth]
[[body]]
name = "first"
thickness = 0
position = [0, -5, 0]
shape = { type = "rectangle", size = [10.0, 10.0], resolution = [2, 2] }
[[body]]
name = "second"
thickness = 0
position = [0, 5.002, 0]
rotation_deg = [0, )" +
          std::to_string(degrees) + R"(, 0]
shape = { type = "rectangle", size = [10.0, 10.0], resolution = [2, 2] }
)",
      "test.toml", overrides));
}

RandomState state_at_rest(const Scene& scene) {
  return {scene.initial_position, std::vector<Vec3>(scene.particle_count, Vec3::Zero())};
}

// The barrier fades near parallel edges, since their closest points then run along them.
TEST(Contact, TheBarrierOfEdgesFadesWhereTheyBecomeParallel) {
  const auto energy_at_angle = [](double degrees) {
    const auto scene = edges_at_angle(degrees);
    Statistics statistics;
    Contact contact(*scene, statistics);
    return energy_at(contact, state_at_rest(*scene));
  };
  const double crossing = energy_at_angle(30);
  EXPECT_GT(crossing, 0);
  EXPECT_NEAR(energy_at_angle(10), crossing, 1e-9 * crossing);
  // c / e = 1e3 sin^2, m = 2 c / e at the least
  const double share = 1e3 * std::pow(std::sin(0.5 * std::numbers::pi / 180), 2);
  EXPECT_NEAR(energy_at_angle(0.5), share * (2 - share) * crossing, 1e-6 * crossing);
}

// The forces of a fading barrier are the slope of its energy. They also turn the edges towards
// parallel, which lowers it.
TEST(Contact, ForcesOfFadingEdgesAreTheSlopeOfTheirEnergy) {
  const auto scene = edges_at_angle(0.5);
  Statistics statistics;
  Contact contact(*scene, statistics);
  const RandomState state = state_at_rest(*scene);
  const std::vector<Vec3> force = forces_at(contact, *scene, state);
  const double step = 1e-7;
  double largest = 0, largest_lift = 0;
  for (const Vec3& f : force) {
    largest = std::max(largest, f.norm());
    largest_lift = std::max(largest_lift, std::abs(f.z()));
  }
  // The barrier's own push is along y.
  ASSERT_GT(largest_lift, 0.01 * largest);
  for (int i = 0; i < scene->dynamic_particles; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      RandomState above = state, below = state;
      above.position[i][axis] += step;
      below.position[i][axis] -= step;
      const double slope = (energy_at(contact, above) - energy_at(contact, below)) / (2 * step);
      EXPECT_NEAR(force[i][axis], -slope, 1e-7 * largest) << i << " " << axis;
    }
  }
}

// Friction of two edges follows the rotation of the plane along both. It has neither resultant nor
// torque, and vanishes in a rigid motion.
TEST(Contact, FrictionOfEdgesTakesNothingFromARigidMotion) {
  const auto scene = edges_at_angle(30, {"contact.friction=0.5"});
  const auto bare = edges_at_angle(30, {"contact.friction=0"});
  Statistics statistics;
  Contact contact(*scene, statistics), smooth(*bare, statistics);
  const auto friction_at = [&](const RandomState& state) {
    std::vector<Vec3> friction = forces_at(contact, *scene, state);
    const std::vector<Vec3> push = forces_at(smooth, *bare, state);
    for (std::size_t i = 0; i < push.size(); ++i) friction[i] -= push[i];
    return friction;
  };
  const auto size_of = [](const std::vector<Vec3>& force) {
    double size = 0;
    for (const Vec3& f : force) size += f.norm();
    return size;
  };
  RandomState state = state_at_rest(*scene);
  std::mt19937 random(9);
  std::normal_distribution<double> normal(0, 0.1);
  for (Vec3& v : state.velocity) v = Vec3(normal(random), normal(random), normal(random));
  const std::vector<Vec3> friction = friction_at(state);
  const double size = size_of(friction);
  ASSERT_GT(size, 1);
  Vec3 sum = Vec3::Zero(), torque = Vec3::Zero();
  for (int i = 0; i < scene->dynamic_particles; ++i) {
    sum += friction[i];
    torque += state.position[i].cross(friction[i]);
  }
  EXPECT_LT(sum.norm(), 1e-10 * size);
  EXPECT_LT(torque.norm(), 1e-10 * size);
  const Vec3 spin(3, -4, 5), drift(1, 2, -3);
  for (int i = 0; i < scene->dynamic_particles; ++i)
    state.velocity[i] = drift + spin.cross(state.position[i]);
  EXPECT_LT(size_of(friction_at(state)), 1e-9 * size);
}

// All forms of the matrix agree: as a product, by blocks, on its diagonal and for preconditioners.
// It is gamma^2 K + gamma D, with the K that is subtracted from right-hand sides.
TEST(Contact, TheFormsOfTheMatrixAgree) {
  const auto scene = build_scene(parse_case(two_sheets(0, 1e-3), "test.toml"));
  Statistics statistics;
  Contact contact(*scene, statistics);
  forces_at(contact, *scene, random_state(*scene, 2));
  const int count = scene->dynamic_particles;
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::vector<Vec3> direction(count);
  for (Vec3& d : direction) d = Vec3(normal(random), normal(random), normal(random));
  const auto product_at = [&](double gamma) {
    std::vector<Vec3> product(count, Vec3::Zero());
    contact.add_product(gamma, direction, product);
    return product;
  };
  const double gamma = 0.01;
  const std::vector<Vec3> product = product_at(gamma), whole = product_at(1);
  std::vector<Vec3> without_stiffness(count, Vec3::Zero()), by_blocks = without_stiffness;
  contact.subtract_stiffness(1, direction, without_stiffness);
  std::vector<Mat3> diagonal(count, Mat3::Zero()), diagonal_blocks = diagonal,
                                                   definite_blocks = diagonal;
  contact.add_diagonal(gamma, diagonal);
  contact.visit_blocks(gamma, [&](int row, int column, const Mat3& block) {
    by_blocks[row] += block * direction[column];
    if (row == column) diagonal_blocks[row] += block;
  });
  // Preconditioners take a matrix without its negative parts.
  contact.keep_matrix_definite();
  forces_at(contact, *scene, random_state(*scene, 2));
  std::vector<Mat3> definite(count, Mat3::Zero());
  contact.add_diagonal(gamma, definite);
  contact.visit_definite_couplings(gamma, [&](const Contact::Coupling& coupling) {
    for (std::size_t k = 0; k < coupling.particles.size(); ++k) {
      if (coupling.particles[k] < count)
        definite_blocks[coupling.particles[k]] +=
            coupling.weights[k] * coupling.weights[k] * coupling.block;
    }
  });
  double size = 0;
  for (int i = 0; i < count; ++i) size = std::max(size, product[i].norm());
  ASSERT_GT(size, 0);
  for (int i = 0; i < count; ++i) {
    const Vec3 stiffness = -without_stiffness[i], damping = whole[i] - stiffness;
    EXPECT_LT((product[i] - gamma * (gamma * stiffness + damping)).norm(), 1e-10 * size) << i;
    EXPECT_LT((product[i] - by_blocks[i]).norm(), 1e-10 * size) << i;
    EXPECT_LT((diagonal[i] - diagonal_blocks[i]).norm(), 1e-10 * size) << i;
    EXPECT_LT((definite[i] - definite_blocks[i]).norm(), 1e-10 * size) << i;
  }
}

// The lists contain every pair in reach while the bodies move on from where the lists were built.
TEST(Contact, EnergyIsThatOfFreshListsAlongAMotion) {
  const auto scene = build_scene(parse_case(two_sheets(0, 0), "test.toml"));
  Statistics kept_statistics, fresh_statistics;
  Contact kept(*scene, kept_statistics);
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, 1e-3);
  RandomState state = random_state(*scene, 6);
  for (int step = 0; step < 60; ++step) {
    for (int i = 0; i < scene->dynamic_particles; ++i) {
      state.position[i] +=
          Vec3(normal(random), normal(random), 0.2 * normal(random) + (i < 81 ? 1e-3 : 0));
    }
    const auto fault = kept.evaluate(state.position, state.velocity, 1);
    Contact fresh(*scene, fresh_statistics);
    const auto fresh_fault = fresh.evaluate(state.position, state.velocity, 1);
    ASSERT_EQ(fault.has_value(), fresh_fault.has_value());
    if (fault) break;
    ASSERT_EQ(kept.pairs_in_reach(), fresh.pairs_in_reach());
    ASSERT_EQ(kept.energy(), fresh.energy());  // the same pairs in the same order: the same bits
  }
  EXPECT_LT(kept_statistics.counters.rebuilds, fresh_statistics.counters.rebuilds / 2);
}

TEST(Contact, PathsThatCrossAreRefusedHoweverLong) {
  const auto scene = build_scene(parse_case(two_sheets(0, 0), "test.toml"));
  Statistics statistics;
  Contact contact(*scene, statistics);
  std::vector<Vec3> through = scene->initial_position, along = scene->initial_position;
  for (int i = 81; i < 162; ++i) {
    through[i].z() -= 5.0;  // the upper sheet ends far below the lower one
    along[i].z() += 5.0;
  }
  const auto fault = contact.check_path(scene->initial_position, through);
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->kind, ContactFault::Kind::crossing);
  EXPECT_FALSE(contact.check_path(scene->initial_position, along));
}

// Paths lead from one place to many that are near each other, all far longer than the slack. Lists
// are seldom rebuilt, and agree with new ones along the paths and at their ends.
TEST(Contact, ListsOfAPathServeThoseBesideIt) {
  const auto scene = build_scene(parse_case(two_sheets(0, 0), "test.toml"));
  Statistics kept_statistics, fresh_statistics;
  Contact kept(*scene, kept_statistics);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> shift(-0.001, 0.001);
  int refused = 0;
  for (int trial = 0; trial < 30; ++trial) {
    RandomState end{scene->initial_position,
                    std::vector<Vec3>(scene->particle_count, Vec3::Zero())};
    for (int i = 0; i < scene->dynamic_particles; ++i) {
      Vec3& x = end.position[i];
      x.z() += 0.2 + 0.3 * x.x() - (i >= 81 ? 0.0025 * trial : 0);
      x += Vec3(shift(random), shift(random), shift(random));
    }
    Contact fresh(*scene, fresh_statistics);
    const auto fault = kept.check_path(scene->initial_position, end.position);
    const auto fresh_fault = fresh.check_path(scene->initial_position, end.position);
    ASSERT_EQ(fault.has_value(), fresh_fault.has_value()) << trial;
    refused += fault ? 1 : 0;
    ASSERT_EQ(kept.evaluate(end.position, end.velocity, 1).has_value(),
              fresh.evaluate(end.position, end.velocity, 1).has_value());
    ASSERT_EQ(kept.pairs_in_reach(), fresh.pairs_in_reach()) << trial;
    ASSERT_EQ(kept.energy(), fresh.energy());
  }
  EXPECT_GT(refused, 3);
  EXPECT_LT(refused, 27);
  EXPECT_LT(kept_statistics.counters.rebuilds, fresh_statistics.counters.rebuilds / 3);
}

// The sheet lies on an inclined plane. It sticks while tan(angle) <= mu; otherwise it slides with a
// = g (sin - mu cos).
TEST(Contact, FrictionOnASlopeFollowsCoulomb) {
  const auto slide = [](double friction) {
    const std::string text = R"(
[time]
duration = 1
[contact]
friction_speed = 1e-3
friction = )" + std::to_string(friction) +
                             R"(
[world]
gravity = [4.905, 0, -8.495709]
[material.cloth]
density = 0.2
membrane_stiffness = 500
stiffness_damping = 1e-3
[[body]]
name = "sheet"
position = [-0.5, 0, 0.00296]
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [6, 6] }
[[obstacle]]
name = "slope"
shape = { type = "rectangle", size = [4, 2], resolution = [3, 4] }
)";
    SimulatedCase sim(text);
    const std::vector<double> y = sim.advance_to(0.5);
    const StateView state = StateView::of(y);
    double mean = 0;
    for (const Vec3& v : state.velocity) mean += v.x() / 36;
    return mean;
  };
  // At 30 degrees tan = 0.577. The sheet settles within the first centimetre per second.
  EXPECT_NEAR(slide(0.3), 0.5 * (9.81 * (0.5 - 0.3 * 0.8660254)), 0.03);
  EXPECT_LT(std::fabs(slide(0.7)), 2e-3);
  EXPECT_NEAR(slide(0.0), 0.5 * 4.905, 0.02);
}

TEST(Contact, AFastSheetIsStoppedByAThinObstacle) {
  SimulatedCase sim(R"(
[time]
duration = 1
[world]
gravity = [0, 0, 0]
[material.cloth]
density = 0.2
membrane_stiffness = 500
stiffness_damping = 1e-3
[[body]]
name = "sheet"
position = [0.02, 0.01, 0.3]
velocity = [0, 0, -8]
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [9, 9] }
[[obstacle]]
name = "plate"
shape = { type = "rectangle", size = [1, 1], resolution = [4, 4] }
)");
  const std::vector<Vec3> x = sim.positions_at(0.1);
  for (int i = 0; i < 81; ++i) EXPECT_GT(x[i].z(), 0);
}

TEST(Contact, AnInitialIntersectionIsRefusedWithThePairs) {
  const auto scene = build_scene(
      parse_case(two_sheets(0, 0), "test.toml",
                 {"body.upper.position=[0, 0, 0]", "body.upper.rotation_deg=[20, 0, 0]"}));
  try {
    check_initial_state(*scene);
    FAIL() << "accepted";
  } catch (const CaseError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("intersecting pairs"), std::string::npos) << text;
    EXPECT_NE(text.find("body \"lower\", row"), std::string::npos) << text;
    EXPECT_NE(text.find("body \"upper\", row"), std::string::npos) << text;
  }
}

std::string refusal_of(const std::vector<std::string>& overrides) {
  const auto scene = build_scene(parse_case(two_sheets(0, 0), "test.toml", overrides));
  try {
    check_initial_state(*scene);
  } catch (const CaseError& error) {
    return error.what();
  }
  return "";
}

// A sheet of 1 m starts bent to a circle of 1.07 m: its ends are about 0.07 m apart.
TEST(Contact, AThicknessTooLargeForAShapeIsRefusedWithItsCause) {
  const std::string within =
      refusal_of({"body.lower.start={ bend_radius = 0.17 }", "body.lower.thickness=0.1",
                  "body.upper.position=[0, 0, 9]", "obstacle.ball.position=[0, 0, -9]"});
  EXPECT_NE(within.find("body \"lower\""), std::string::npos) << within;
  EXPECT_EQ(within.find("upper"), std::string::npos) << within;
  EXPECT_NE(within.find("make thickness smaller, or the layers of the shape farther apart"),
            std::string::npos)
      << within;
  const std::string between =
      refusal_of({"body.lower.thickness=0.07", "body.upper.thickness=0.07"});
  EXPECT_NE(between.find("upper"), std::string::npos) << between;
  EXPECT_NE(between.find("move the bodies apart"), std::string::npos) << between;
  for (const std::string& text : {within, between}) {
    const std::size_t gap = text.find("(gap -");
    ASSERT_NE(gap, std::string::npos) << text;
    EXPECT_LE(text.find(" m)", gap) - gap, std::string("(gap -0.00123456").size() + 2) << text;
  }
}

TEST(Contact, OneIntersectionIsCountedInTheSingular) {
  const std::string text =
      refusal_of({"body.upper.shape.resolution=[2, 2]", "body.upper.shape.size=[0.01, 0.01]",
                  "body.lower.shape.resolution=[2, 2]", "body.upper.rotation_deg=[90, 0, 45]",
                  "body.upper.position=[0.1, 0.2, 0.006]"});
  EXPECT_NE(text.find("has 1 intersecting pair of triangles, at\n"), std::string::npos) << text;
}

}  // namespace
}  // namespace weft::sim::contact_test
