// Contact of surfaces whose points are combinations of particles: against the
// same contact between bodies made of these points, and the definition of the
// map and its transpose.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "sim/contact/contact.h"
#include "sim/motion/prescribed_paths.h"
#include "sim/run/initial_state.h"
#include "tests/sim/sampled_scene.h"

namespace weft::sim::sampled_contact_test {
namespace {

// Two crumpled sheets, one above the other, and a ball below: every kind of
// pair is in reach.
constexpr const char* two_sheets = R"(
[time]
duration = 1
[contact]
range = 0.03
stiffness = 1e4
search_slack = 0.01
friction = 0.3
damping_time = 1e-3
[[body]]
name = "lower"
thickness = 0.002
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [7, 7] }
[[body]]
name = "upper"
position = [0.03, 0.02, 0.035]
rotation_deg = [1, 1.5, 40]
thickness = 0.004
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [6, 8] }
[[obstacle]]
name = "ball"
position = [0, 0, -0.315]
shape = { type = "sphere", radius = 0.3, resolution = [5] }
)";

const Overrides without_friction{"contact.friction=0"};

struct State {
  std::vector<Vec3> position, velocity;
};

State random_state(const Scene& scene, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-0.008, 0.008);
  State state{scene.initial_position, std::vector<Vec3>(scene.particle_count, Vec3::Zero())};
  for (int i = 0; i < scene.dynamic_particles; ++i) {
    state.position[i] += Vec3(shift(random), shift(random), shift(random));
    state.velocity[i] = 10 * Vec3(shift(random), shift(random), shift(random));
  }
  return state;
}

std::vector<Vec3> random_vectors(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<Vec3> vectors(count);
  for (Vec3& v : vectors) v = Vec3(normal(random), normal(random), normal(random));
  return vectors;
}

double largest_norm(const std::vector<Vec3>& vectors) {
  double largest = 0;
  for (const Vec3& v : vectors) largest = std::max(largest, v.norm());
  return largest;
}

void expect_near(const std::vector<Vec3>& a, const std::vector<Vec3>& b, double part) {
  ASSERT_EQ(a.size(), b.size());
  const double size = largest_norm(b);
  ASSERT_GT(size, 0);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_LT((a[i] - b[i]).norm(), part * size) << i;
}

// Contact of a sampled scene beside that of the scene made of its points, both
// evaluated at once.
class Twins {
 public:
  explicit Twins(const SampledScene& sampled, unsigned seed = 1)
      : sampled_(sampled),
        points_(sampled.points_as_particles()),
        contact(sampled.scene(), statistics_),
        of_points(points_, statistics_) {
    evaluate(random_state(sampled.scene(), seed));
  }
  void evaluate(const State& now) {
    state = now;
    ASSERT_FALSE(contact.evaluate(now.position, now.velocity, 1));
    ASSERT_FALSE(
        of_points.evaluate(sampled_.on_points(now.position), sampled_.on_points(now.velocity), 1));
    ASSERT_GT(contact.pairs_in_reach(), 70U);
    ASSERT_EQ(contact.pairs_in_reach(), of_points.pairs_in_reach());
  }
  std::vector<Vec3> forces() const {
    std::vector<Vec3> force(sampled_.scene().particle_count, Vec3::Zero());
    contact.add_forces(force);
    return force;
  }
  std::vector<Vec3> forces_on_points() const {
    std::vector<Vec3> force(points_.particle_count, Vec3::Zero());
    of_points.add_forces(force);
    return force;
  }
  // Returns S^T A S in, by dynamic particle. multiply(contact, x, product) adds A x.
  template <class Multiply>
  std::vector<Vec3> expected_product(const std::vector<Vec3>& in, const Multiply& multiply) const {
    std::vector<Vec3> all = in;
    all.resize(sampled_.scene().particle_count, Vec3::Zero());
    std::vector<Vec3> on_points = sampled_.on_points(all);
    on_points.resize(points_.dynamic_particles);
    std::vector<Vec3> product(on_points.size(), Vec3::Zero());
    multiply(of_points, on_points, product);
    std::vector<Vec3> result = sampled_.on_particles(product);
    result.resize(in.size());
    return result;
  }

 private:
  const SampledScene& sampled_;
  Scene points_;
  Statistics statistics_;

 public:
  Contact contact, of_points;
  State state;
};

TEST(SampledSurface, RefinedPointsAreAverages) {
  const SampledScene sampled(two_sheets, {}, refined_surface);
  const Scene& scene = sampled.scene();
  EXPECT_EQ(scene.dynamic_points, 13 * 13 + 11 * 15);
  EXPECT_EQ(scene.point_count, scene.dynamic_points + 6 * 8 * 8 + 2);
  EXPECT_EQ(scene.bodies[1].first_point, 13 * 13);
  std::vector<Vec3> room;
  const auto position =
      scene.surface_map.points_of(scene.initial_position, scene.point_count, room);
  for (int row = 0; row < 13; ++row) {
    for (int col = 0; col < 13; ++col) {
      const Vec3 place(-0.5 + col / 12.0, -0.5 + row / 12.0, 0);
      EXPECT_LT((position[13 * row + col] - place).norm(), 1e-15);
    }
  }
  EXPECT_EQ(scene.describe_point(13 + 2), "body \"lower\", row 1, column 2 of its surface");
  EXPECT_EQ(scene.body_index_of_point(13 * 13), 1);
  EXPECT_EQ(scene.main_particle(13 * 2), 7);
  // Areas are those around points.
  EXPECT_NEAR(scene.contact_area[13 + 1], 1 / 144.0, 1e-15);
  double area = 0;
  for (int i = 0; i < 13 * 13; ++i) area += scene.contact_area[i];
  EXPECT_NEAR(area, 1, 1e-12);
}

TEST(SampledContact, ForcesAreThoseOfThePointsByTheTranspose) {
  const SampledScene sampled(two_sheets, {}, refined_surface);
  const Twins twins(sampled);
  expect_near(twins.forces(), sampled.on_particles(twins.forces_on_points()), 1e-13);
  EXPECT_DOUBLE_EQ(twins.contact.energy(), twins.of_points.energy());
  EXPECT_EQ(twins.contact.smallest_gap(), twins.of_points.smallest_gap());
  // Forces on the dynamic particles alone are the same.
  std::vector<Vec3> dynamic(sampled.scene().dynamic_particles, Vec3::Zero());
  twins.contact.add_forces(dynamic);
  std::vector<Vec3> all = twins.forces();
  all.resize(dynamic.size());
  expect_near(dynamic, all, 1e-15);
}

TEST(SampledContact, ForcesKeepTheirResultantAndTheirMoment) {
  const SampledScene sampled(two_sheets, {}, refined_surface);
  const Twins twins(sampled);
  const std::vector<Vec3> force = twins.forces(), of_points = twins.forces_on_points(),
                          points = sampled.on_points(twins.state.position);
  Vec3 sum = Vec3::Zero(), moment = sum, point_sum = sum, point_moment = sum;
  double size = 0;
  // Forces on the sheets alone: with those on the ball, all would sum to zero.
  for (int i = 0; i < sampled.scene().dynamic_particles; ++i) {
    sum += force[i];
    moment += twins.state.position[i].cross(force[i]);
  }
  for (int i = 0; i < sampled.scene().dynamic_points; ++i) {
    point_sum += of_points[i];
    point_moment += points[i].cross(of_points[i]);
    size += of_points[i].norm();
  }
  EXPECT_GT(point_sum.norm(), 1e-3 * size);
  EXPECT_LT((sum - point_sum).norm(), 1e-13 * size);
  EXPECT_LT((moment - point_moment).norm(), 1e-13 * size);
  // All of it comes from obstacles: two bodies give each other neither.
  std::vector<Wrench> wrenches(sampled.scene().bodies.size());
  twins.contact.add_wrenches(twins.state.position, wrenches);
  Wrench all;
  for (const Wrench& wrench : wrenches) {
    all.force += wrench.force;
    all.moment += wrench.moment;
  }
  EXPECT_LT((all.force - sum).norm(), 1e-13 * size);
  EXPECT_LT((all.moment - moment).norm(), 1e-13 * size);
  EXPECT_EQ(wrenches[0].force, Vec3::Zero());
}

TEST(SampledContact, PushesAndFrictionAreTheParts) {
  const SampledScene sampled(two_sheets, {}, refined_surface);
  const Twins twins(sampled);
  const std::vector<Vec3> force = twins.forces();
  std::vector<Vec3> normal(force.size(), Vec3::Zero()), friction = normal;
  twins.contact.add_forces(normal, friction);
  double pushes = 0, frictions = 0;
  for (std::size_t i = 0; i < force.size(); ++i) {
    EXPECT_LT((normal[i] + friction[i] - force[i]).norm(), 1e-12 * (1 + force[i].norm()));
    pushes += normal[i].norm();
    frictions += friction[i].norm();
  }
  EXPECT_GT(pushes, 0);
  EXPECT_GT(frictions, 0);
}

TEST(SampledContact, LoadedObstaclesAreNamedByTheirParticles) {
  const SampledScene sampled(two_sheets, {}, refined_surface);
  const Twins twins(sampled);
  std::vector<int> loaded, loaded_points, expected;
  twins.contact.find_loaded_obstacles(loaded);
  twins.of_points.find_loaded_obstacles(loaded_points);
  ASSERT_FALSE(loaded.empty());
  for (const int point : loaded_points) {
    for (const auto& share : sampled.scene().surface_map.shares(point))
      expected.push_back(share.particle);
  }
  std::ranges::sort(expected);
  expected.erase(std::unique(expected.begin(), expected.end()), expected.end());
  EXPECT_EQ(loaded, expected);
}

TEST(SampledContact, ProductsAreThoseOfThePoints) {
  const SampledScene sampled(two_sheets, {}, refined_surface);
  const Twins twins(sampled);
  const int count = sampled.scene().dynamic_particles;
  const std::vector<Vec3> in = random_vectors(count, 3);
  const auto product = [](const Contact& contact, std::span<const Vec3> x, std::span<Vec3> out) {
    contact.add_product(0.01, x, out);
  };
  const auto stiffness = [](const Contact& contact, std::span<const Vec3> x, std::span<Vec3> out) {
    contact.subtract_stiffness(0.5, x, out);
  };
  std::vector<Vec3> out(count, Vec3::Zero());
  product(twins.contact, in, out);
  expect_near(out, twins.expected_product(in, product), 1e-13);
  std::ranges::fill(out, Vec3::Zero());
  stiffness(twins.contact, in, out);
  expect_near(out, twins.expected_product(in, stiffness), 1e-13);
}

// The matrix of contact, column by column from products, in blocks by (row,
// column).
std::vector<Mat3> dense_matrix(const Contact& contact, int count, double gamma) {
  std::vector<Mat3> matrix(static_cast<std::size_t>(count) * count, Mat3::Zero());
  for (int column = 0; column < count; ++column) {
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<Vec3> unit(count, Vec3::Zero()), product = unit;
      unit[column][axis] = 1;
      contact.add_product(gamma, unit, product);
      for (int row = 0; row < count; ++row) matrix[row * count + column].col(axis) = product[row];
    }
  }
  return matrix;
}

void expect_same_blocks(const std::vector<Mat3>& a, const std::vector<Mat3>& b) {
  double size = 0, difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    size = std::max(size, b[i].norm());
    difference = std::max(difference, (a[i] - b[i]).norm());
  }
  EXPECT_GT(size, 0);
  EXPECT_LT(difference, 1e-12 * size);
}

TEST(SampledContact, BlocksAndTheDiagonalAreThoseOfProductsWithUnitVectors) {
  const SampledScene sampled(two_sheets, {}, refined_surface);
  const Twins twins(sampled);
  const int count = sampled.scene().dynamic_particles;
  const double gamma = 0.01;
  const std::vector<Mat3> expected = dense_matrix(twins.contact, count, gamma);
  std::vector<Mat3> blocks(expected.size(), Mat3::Zero());
  twins.contact.visit_blocks(gamma, [&](int row, int column, const Mat3& block) {
    blocks[row * count + column] += block;
  });
  expect_same_blocks(blocks, expected);
  std::vector<Mat3> diagonal(count, Mat3::Zero()), expected_diagonal = diagonal;
  const std::vector<int> touched = twins.contact.add_diagonal(gamma, diagonal);
  for (int i = 0; i < count; ++i) expected_diagonal[i] = expected[i * count + i];
  expect_same_blocks(diagonal, expected_diagonal);
  for (int i = 0; i < count; ++i)
    EXPECT_EQ(diagonal[i].isZero(0), std::ranges::find(touched, i) == touched.end()) << i;
}

// Without friction and negative parts, the couplings add up to the matrix itself.
TEST(SampledContact, CouplingsAreTheDefiniteMatrix) {
  const SampledScene sampled(two_sheets, without_friction, refined_surface);
  Twins twins(sampled);
  twins.contact.keep_matrix_definite();
  twins.evaluate(twins.state);
  const int count = sampled.scene().dynamic_particles;
  const double gamma = 0.01;
  std::vector<Mat3> joined(static_cast<std::size_t>(count) * count, Mat3::Zero());
  std::size_t couplings = 0;
  twins.contact.visit_definite_couplings(gamma, [&](const Contact::Coupling& coupling) {
    ++couplings;
    ASSERT_EQ(coupling.particles.size(), coupling.weights.size());
    for (std::size_t i = 0; i < coupling.particles.size(); ++i) {
      EXPECT_EQ(std::ranges::count(coupling.particles, coupling.particles[i]), 1);
      for (std::size_t j = 0; j < coupling.particles.size(); ++j) {
        const int row = coupling.particles[i], column = coupling.particles[j];
        if (row < count && column < count)
          joined[row * count + column] +=
              coupling.weights[i] * coupling.weights[j] * coupling.block;
      }
    }
  });
  EXPECT_EQ(couplings, twins.contact.pairs_in_reach());
  expect_same_blocks(joined, dense_matrix(twins.contact, count, gamma));
}

TEST(SampledContact, DampingIsTheSlopeOfTheForcesInTheVelocities) {
  const SampledScene sampled(two_sheets, {}, refined_surface);
  const int count = sampled.scene().dynamic_particles;
  const std::vector<Vec3> direction = random_vectors(count, 4);
  Twins twins(sampled, 2);
  const State state = twins.state;
  const double step = 1e-6, gamma = 1e-9;  // so small that the product is gamma D
  std::vector<Vec3> product(count, Vec3::Zero());
  twins.contact.add_product(gamma, direction, product);
  for (Vec3& p : product) p /= gamma;
  const auto forces_at = [&](double factor) {
    State moved = state;
    for (int i = 0; i < count; ++i) moved.velocity[i] += factor * step * direction[i];
    twins.evaluate(moved);
    std::vector<Vec3> force = twins.forces();
    force.resize(count);
    return force;
  };
  std::vector<Vec3> slope = forces_at(-1);
  const std::vector<Vec3> above = forces_at(1);
  for (int i = 0; i < count; ++i) slope[i] = (slope[i] - above[i]) / (2 * step);
  expect_near(slope, product, 1e-4);
}

// A sheet so high over a plate that only its samples see the plate. The normal is always the same,
// so the matrix leaves out nothing.
constexpr const char* sheet_over_plate = R"(
[time]
duration = 1
[contact]
range = 0.02
stiffness = 1e4
search_slack = 0.01
[[body]]
name = "sheet"
position = [0, 0, 0.012]
thickness = 0.001
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [5, 6] }
[[obstacle]]
name = "plate"
thickness = 0.001
shape = { type = "rectangle", size = [2.1, 2.2], resolution = [3, 3] }
)";

TEST(SampledContact, StiffnessIsTheSlopeOfTheForcesInThePositions) {
  const SampledScene sampled(sheet_over_plate, {}, refined_surface);
  const int count = sampled.scene().dynamic_particles;
  const std::vector<Vec3> direction = random_vectors(count, 5);
  State state{sampled.scene().initial_position,
              std::vector<Vec3>(sampled.scene().particle_count, Vec3::Zero())};
  for (int i = 0; i < count; ++i) state.position[i].z() += 5e-4 * direction[count - 1 - i].x();
  Statistics statistics;
  Contact contact(sampled.scene(), statistics);
  const auto forces_at = [&](double step) {
    State moved = state;
    for (int i = 0; i < count; ++i) moved.position[i] += step * direction[i];
    EXPECT_FALSE(contact.evaluate(moved.position, moved.velocity, 1));
    std::vector<Vec3> force(count, Vec3::Zero());
    contact.add_forces(force);
    return force;
  };
  const double step = 1e-7;
  std::vector<Vec3> slope = forces_at(step);
  const std::vector<Vec3> below = forces_at(-step);
  for (int i = 0; i < count; ++i) slope[i] = (slope[i] - below[i]) / (2 * step);
  forces_at(0);
  ASSERT_EQ(static_cast<int>(contact.pairs_in_reach()), sampled.scene().dynamic_points);
  std::vector<Vec3> product(count, Vec3::Zero());
  contact.subtract_stiffness(1, direction, product);
  expect_near(slope, product, 1e-6);
}

// A point between a pinned particle and a free one is in contact; between
// pinned ones it is not.
TEST(SampledContact, PointsAreFreeWhereAParticleIs) {
  const SampledScene sampled(sheet_over_plate,
                             {"contact.friction=0", "body.sheet.pin=[{edges=[\"first_row\"]}]"},
                             refined_surface);
  const Scene& scene = sampled.scene();
  Statistics statistics;
  Contact contact(scene, statistics);
  const std::vector<Vec3> at_rest(scene.particle_count, Vec3::Zero());
  ASSERT_FALSE(contact.evaluate(scene.initial_position, at_rest, 1));
  EXPECT_EQ(contact.pairs_in_reach(), 8U * 11U);  // all but the first row of 9
}

TEST(SampledContact, AnExplicitMapOfSingleParticlesGivesTheSameBits) {
  const SampledScene sampled(two_sheets, {}, own_surface);
  Statistics statistics;
  Contact explicit_map(sampled.scene(), statistics), identity(sampled.plain(), statistics);
  const State state = random_state(sampled.plain(), 6);
  ASSERT_FALSE(sampled.scene().surface_map.is_identity());
  ASSERT_FALSE(explicit_map.evaluate(state.position, state.velocity, 1));
  ASSERT_FALSE(identity.evaluate(state.position, state.velocity, 1));
  ASSERT_GT(identity.pairs_in_reach(), 30U);
  const int count = sampled.plain().dynamic_particles;
  const std::vector<Vec3> in = random_vectors(count, 7);
  const auto results = [&](const Contact& contact) {
    std::vector<Vec3> force = random_vectors(sampled.plain().particle_count, 8), out = in;
    contact.add_forces(force);
    contact.add_product(0.01, in, out);
    contact.subtract_stiffness(0.3, in, out);
    std::vector<Mat3> diagonal(count, Mat3::Identity());
    contact.add_diagonal(0.01, diagonal);
    contact.visit_blocks(0.01, [&](int row, int column, const Mat3& block) {
      diagonal[row] += block * (column + 1);
    });
    contact.visit_definite_couplings(0.01, [&](const Contact::Coupling& coupling) {
      for (std::size_t i = 0; i < coupling.particles.size(); ++i) {
        if (coupling.particles[i] < count)
          diagonal[coupling.particles[i]] += coupling.weights[i] * coupling.block;
      }
    });
    return std::tuple(force, out, diagonal);
  };
  EXPECT_EQ(results(explicit_map), results(identity));
}

// One quad whose diagonal stays high while two corners sink. The middle of its triangles' common
// edge does not move, but the average of the four corners does.
constexpr const char* quad_over_speck = R"(
[time]
duration = 1
[contact]
range = 0.004
[[body]]
name = "quad"
position = [0, 0, 0.1]
thickness = 0.001
shape = { type = "rectangle", size = [1, 1], resolution = [2, 2] }
[[obstacle]]
name = "speck"
position = [0.01, 0.013, 0.05]
thickness = 0.001
shape = { type = "rectangle", size = [0.01, 0.01], resolution = [2, 2] }
)";

TEST(SampledContact, APointThatWouldPassIsRefusedThoughItsParticlesDoNot) {
  const SampledScene sampled(quad_over_speck, {}, refined_surface,
                             [](const SceneBody& body) { return body.dynamic; });
  Statistics statistics;
  Contact refined(sampled.scene(), statistics), plain(sampled.plain(), statistics);
  const std::vector<Vec3> start = sampled.plain().initial_position;
  std::vector<Vec3> end = start;
  for (const int corner : {0, 3}) end[corner].z() -= 0.15;  // the average is 0.025 above zero
  EXPECT_FALSE(plain.check_path(start, end));
  const auto fault = refined.check_path(start, end);
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->kind, ContactFault::Kind::crossing);
  const std::string text = fault->describe(sampled.scene());
  EXPECT_NE(text.find("column 1 of its surface"), std::string::npos) << text;
  EXPECT_NE(text.find("obstacle \"speck\", row"), std::string::npos) << text;
  EXPECT_EQ(fault->particle(sampled.scene()),
            4);  // of the speck, which is named first
  // Up to the speck, the way is free.
  for (const int corner : {0, 3}) end[corner].z() += 0.06;
  EXPECT_FALSE(refined.check_path(start, end));
  const std::span<const Vec3> from = start, to = end;
  EXPECT_FALSE(refined.check_crossing(from, to));
}

TEST(SampledContact, PointsStrayAsFarAsTheirParticles) {
  const SampledScene sampled(sheet_over_plate, {}, refined_surface);
  const Scene& scene = sampled.scene();
  Statistics statistics;
  Contact contact(scene, statistics);
  const std::vector<Vec3>& place = scene.initial_position;
  // The last row of particles strays. Half of the thickness must be kept.
  const auto is_free = [&](double stray) {
    std::vector<double> of_body{stray, 0}, of_particle(scene.dynamic_particles, 0.0);
    std::fill(of_particle.end() - 6, of_particle.end(), stray);
    return !contact.check_path(place, place, {of_body, of_particle});
  };
  EXPECT_TRUE(is_free(0.0114));
  EXPECT_FALSE(is_free(0.0116));
}

TEST(SampledContact, AParticleThatIsNotFiniteIsNamed) {
  const SampledScene sampled(two_sheets, {}, refined_surface);
  Statistics statistics;
  Contact contact(sampled.scene(), statistics);
  State state = random_state(sampled.scene(), 9);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), 1e16}) {
    state.position[7 + 3].y() = bad;
    const auto fault = contact.evaluate(state.position, state.velocity, 1);
    ASSERT_TRUE(fault);
    EXPECT_EQ(fault->kind, ContactFault::Kind::not_finite);
    EXPECT_EQ(fault->describe(sampled.scene()),
              "the position of body \"lower\", row 1, column 3 is not finite, or more than 1e15 m "
              "from the origin");
    EXPECT_EQ(fault->particle(sampled.scene()), 7 + 3);
  }
}

TEST(SampledContact, TheInitialStateIsCheckedByItsPoints) {
  const SampledScene sampled(quad_over_speck, {"obstacle.speck.position=[0.01, 0.013, 0.1]"},
                             refined_surface, [](const SceneBody& body) { return body.dynamic; });
  try {
    check_initial_state(sampled.scene());
    FAIL();
  } catch (const std::exception& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find(" of its surface  with  obstacle \"speck\""), std::string::npos) << text;
  }
}

// Poses of moving obstacles may replace the positions of their particles.
TEST(SampledContact, PosesStandForTheParticlesOfObstacles) {
  const SampledScene sampled(std::string(two_sheets) +
                                 "motion = { angular_velocity_deg = [0, 0, "
                                 "90], velocity = [0, 0, 0.05] }\n",
                             {}, refined_surface);
  const Scene& scene = sampled.scene();
  Statistics statistics;
  Contact by_pose(scene, statistics), by_position(scene, statistics);
  ASSERT_EQ(by_pose.obstacles().all().size(), 1U);
  const RigidObstacle& ball = by_pose.obstacles().all()[0];
  State state = random_state(scene, 10);
  for (const double time : {0.0, 0.05, 0.1}) {
    std::vector<RigidPose> poses;
    by_pose.obstacles().find_poses(time, false, poses);
    for (const int particle : ball.held->particles)
      poses[0].place(ball.held->start[particle - ball.first_particle], state.position[particle],
                     state.velocity[particle]);
    State room = state;
    for (const int particle : ball.held->particles) {
      room.position[particle].setConstant(1e3);
      room.velocity[particle].setConstant(1e3);
    }
    ASSERT_FALSE(by_position.evaluate(state.position, state.velocity, 1));
    ASSERT_FALSE(by_pose.evaluate({room.position, room.velocity, poses}, room.velocity, 1));
    std::vector<Vec3> force(scene.particle_count, Vec3::Zero()), expected = force;
    by_pose.add_forces(force);
    by_position.add_forces(expected);
    expect_near(force, expected, 1e-11);
    EXPECT_GT(largest_norm({expected.begin() + scene.dynamic_particles, expected.end()}), 0);
  }
}

}  // namespace
}  // namespace weft::sim::sampled_contact_test
