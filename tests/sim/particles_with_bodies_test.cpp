// Particles under error control, with cloth, obstacles and each other: closed forms and invariants.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "bsi/proximity.h"
#include "sim/contact/contact.h"
#include "sim/simulation/simulation.h"
#include "tests/sim/simulated_case.h"

namespace weft::sim::particles_with_bodies_test {
namespace {

constexpr double gravity = 9.81;

// One ball above a floor. Tests override its place and its laws.
const std::string ball = R"(
[time]
duration = 2
[[particles]]
name = "ball"
radius = 0.02
restitution = 0.5
friction = 0
positions = { type = "grid", count = [1, 1, 1], centre = [0.003, 0.001, 0.5] }
[[obstacle]]
name = "floor"
shape = { type = "rectangle", size = [4, 4], resolution = [5, 5] }
)";

Simulation simulate(const std::string& text, const Overrides& overrides = {}) {
  return Simulation(build_scene(parse_case(text, "test.toml", overrides)));
}

// Returns the heights of the first bounces above the place where the ball turns, which is at about
// a third of the range.
std::vector<double> bounce_heights(const Overrides& overrides, std::size_t count) {
  Simulation simulation = simulate(ball, overrides);
  const double turn = 0.02 + 0.5e-3 + 2e-3 / 3;
  std::vector<double> heights;
  double highest = 0, last_speed = -1;
  while (heights.size() < count && simulation.time() < 10) {
    if (const auto failure = simulation.step()) {
      ADD_FAILURE() << failure->text;
      break;
    }
    const double height = simulation.position("ball")[0].z() - turn;
    const double speed = simulation.velocity("ball")[0].z();
    highest = height + speed * speed / (2 * gravity);
    if (last_speed > 0 && speed <= 0) heights.push_back(highest);
    last_speed = speed;
  }
  return heights;
}

TEST(ParticlesWithBodies, BounceToTheHeightsOfNewtonsLaw) {
  const double start = 0.5 - 0.0205 - 2e-3 / 3;
  for (const double e : {0.2, 0.5, 0.8}) {
    for (const std::string mesh : {"2, 2", "70, 90"}) {
      const std::size_t bounces = e > 0.3 ? 2 : 1;
      const std::vector<double> heights =
          bounce_heights({"particles.0.restitution=" + std::to_string(e),
                          "obstacle.0.shape.resolution=[" + mesh + "]"},
                         bounces);
      ASSERT_EQ(heights.size(), bounces);
      double before = start;
      for (const double height : heights) {
        EXPECT_NEAR(height / (e * e * before), 1, 0.02) << "e " << e << ", mesh " << mesh;
        before = height;
      }
    }
  }
}

TEST(ParticlesWithBodies, BounceAfterFallsOfAHundredMetres) {
  for (const std::string method : {"cvode", "arkode"}) {
    for (const double height : {10.0, 100.0}) {
      Simulation simulation =
          simulate(ball, {"time.method=\"" + method + "\"", "time.duration=10",
                          "particles.0.positions.centre.2=" + std::to_string(height)});
      const double time = std::sqrt(2 * (height - 0.0205) / gravity);
      if (const auto failure = simulation.advance(time + 0.01)) ADD_FAILURE() << failure->text;
      const double speed = simulation.velocity("ball")[0].z() + 0.01 * gravity;
      EXPECT_NEAR(speed / (gravity * time), 0.5, 0.01) << method << ' ' << height;
    }
  }
}

// The light ball lies between a floor and one that falls on it from above, slightly aside.
TEST(ParticlesWithBodies, ALightBallCarriesTheImpactOfAHeavyOne) {
  const std::string heavy = R"(
[[particles]]
name = "heavy"
radius = 0.1
positions = { type = "grid", count = [1, 1, 1], centre = [0.0035, 0.001, 1.2] }
)";
  for (const std::string method : {"cvode", "arkode"}) {
    for (const double density : {1e3, 4e3, 2e4}) {  // 125, 500 and 2500 times as heavy
      Simulation simulation = simulate(
          ball + heavy, {"time.method=\"" + method + "\"", "particles.0.positions.centre.2=0.024",
                         "particles.1.density=" + std::to_string(density)});
      while (simulation.time() < 0.6) {
        const auto failure = simulation.step();
        ASSERT_FALSE(failure) << method << ' ' << density << ": " << failure->text;
        const Vec3 light = simulation.position("ball")[0], above = simulation.position("heavy")[0];
        ASSERT_GT(light.z(), 0.0205) << method << ' ' << density;
        ASSERT_GT((above - light).norm(), 0.12) << method << ' ' << density;
      }
    }
  }
}

TEST(ParticlesWithBodies, RestOnAFloor) {
  Simulation simulation = simulate(ball, {"particles.0.restitution=0.2"});
  if (const auto failure = simulation.advance(2)) ADD_FAILURE() << failure->text;
  EXPECT_LT(simulation.velocity("ball")[0].norm(), 1e-3);
  const double gap = simulation.position("ball")[0].z() - 0.0205;
  EXPECT_GT(gap, 0);
  EXPECT_LT(gap, 2e-3);
}

TEST(ParticlesWithBodies, StopAfterTheDistanceOfFriction) {
  Simulation simulation = simulate(
      ball, {"particles.0.positions.centre=[-1, 0.01, 0.0224]", "particles.0.velocity=[2, 0, 0]",
             "particles.0.friction=0.25", "particles.0.restitution=0.2", "particles.0.spin=false"});
  if (const auto failure = simulation.advance(2)) ADD_FAILURE() << failure->text;
  const double exact = 2 * 2 / (2 * 0.25 * gravity);
  EXPECT_NEAR((simulation.position("ball")[0].x() + 1) / exact, 1, 0.02);
}

TEST(ParticlesWithBodies, FallWithTheDragOfAir) {
  Simulation simulation = simulate(
      ball, {"particles.0.drag_coefficient=0.47", "particles.0.positions.centre=[0, 0, 90]",
             "particles.0.density=20", "world.wind=[1, 0, 0]"});
  if (const auto failure = simulation.advance(4)) ADD_FAILURE() << failure->text;
  const double radius = 0.02, density = 20;
  const double limit = std::sqrt(8 * density * radius * gravity / (3 * 0.47 * 1.2));
  EXPECT_NEAR(simulation.velocity("ball")[0].z() / -limit, 1, 0.01);
  EXPECT_NEAR(simulation.velocity("ball")[0].x(), 1, 0.02);
}

// Two balls of different masses that fly towards each other.
const std::string two_balls = R"(
[time]
duration = 1
[world]
gravity = [0, 0, 0]
[[particles]]
name = "heavy"
radius = 0.03
restitution = 0.3
friction = 0
spin = false
velocity = [1, 0, 0]
positions = { type = "grid", count = [1, 1, 1], centre = [-0.2, 0, 0] }
[[particles]]
name = "light"
radius = 0.02
restitution = 0.7
friction = 0
spin = false
velocity = [-2, 0, 0]
positions = { type = "grid", count = [1, 1, 1], centre = [0.2, 0, 0] }
)";

TEST(ParticlesWithBodies, CollideHeadOnWithNewtonsLaw) {
  Simulation simulation = simulate(two_balls);
  const std::vector<double>& mass = simulation.scene().mass;
  if (const auto failure = simulation.advance(0.4)) ADD_FAILURE() << failure->text;
  const Vec3 heavy = simulation.velocity("heavy")[0], light = simulation.velocity("light")[0];
  EXPECT_NEAR(light.x() - heavy.x(), 0.7 * 3, 0.7 * 3 * 0.02);
  const double momentum = mass[0] * 1 - mass[1] * 2;
  EXPECT_NEAR(mass[0] * heavy.x() + mass[1] * light.x(), momentum, 1e-4 * momentum);
}

// A sheet that nothing holds, and balls that hit it off its centre.
const std::string free_sheet = R"(
[time]
duration = 0.5
[world]
gravity = [0, 0, 0]
[material.cloth]
membrane_stiffness = 500
bending_stiffness = 1e-4
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.4, 0.4], resolution = [11, 11] }
[[particles]]
name = "balls"
radius = 0.03
density = 300
friction = 0
spin = false
velocity = [0.3, 0, -3]
positions = { type = "grid", count = [2, 1, 3], centre = [0.04, 0.03, 0.2], spacing = 0.066 }
)";

struct Momenta {
  Vec3 linear{0, 0, 0}, angular{0, 0, 0};
};
Momenta momenta_of(const SimulatedCase& sim, std::span<const double> y) {
  const StateView state = StateView::of(y);
  Momenta sum;
  for (std::size_t i = 0; i < state.position.size(); ++i) {
    sum.linear += sim.scene().mass[i] * state.velocity[i];
    sum.angular += sim.scene().mass[i] * state.position[i].cross(state.velocity[i]);
  }
  return sum;
}

// Returns the least gap (m) of any sphere to anything else, by comparing all with all.
double least_gap(const Scene& scene, std::span<const Vec3> x) {
  double least = 1;
  for (const SceneBody& spheres : scene.bodies) {
    if (spheres.spheres == nullptr || spheres.are_spins) continue;
    const double radius = spheres.spheres->radius;
    for (int i = 0; i < spheres.particle_count(); ++i) {
      const int sphere = spheres.first_particle + i;
      for (const SceneBody& body : scene.bodies) {
        if (body.are_spins) continue;
        for (int k = 0; body.spheres != nullptr && k < body.particle_count(); ++k) {
          const int other = body.first_particle + k;
          if (other != sphere)
            least = std::min(least, (x[sphere] - x[other]).norm() - radius - body.spheres->radius);
        }
        for (const auto& [a, b, c] : body.mesh.triangles) {
          const Vec3* const corner = x.data() + body.first_particle;
          const auto closest =
              bsi::closest_vertex_triangle(x[sphere], corner[a], corner[b], corner[c]);
          least =
              std::min(least, std::sqrt(closest.squared_distance) - radius - 0.5 * body.thickness);
        }
      }
    }
  }
  return least;
}

TEST(ParticlesWithBodies, KeepTheMomentaOfAFreeSheetAndGainNoEnergy) {
  SimulatedCase sim(free_sheet);
  const std::vector<double> start(sim.integrator().state().begin(), sim.integrator().state().end());
  const Momenta before = momenta_of(sim, start);
  double energy = sim.energy(0, start);
  const double size = before.linear.norm(), first = energy;
  while (sim.integrator().time() < 0.5) {
    const auto failure = sim.integrator().step();
    ASSERT_FALSE(failure) << failure->text;
    const double time = sim.integrator().time();
    const std::vector<double> y(sim.integrator().state().begin(), sim.integrator().state().end());
    EXPECT_GT(least_gap(sim.scene(), sim.positions(time, y)), 0) << time;
    const double now = sim.energy(time, y);
    EXPECT_LT(now, energy + 2e-4 * first) << time;
    energy = std::min(energy, now);
    const Momenta after = momenta_of(sim, y);
    EXPECT_LT((after.linear - before.linear).norm(), 2e-4 * size);
    EXPECT_LT((after.angular - before.angular).norm(), 1e-3 * 0.1 * size) << time;
  }
  EXPECT_LT(energy, 0.97 * first);
  // The sheet has been hit, and no ball has passed it.
  double sheet = 0;
  for (int i = 0; i < 121; ++i)
    sheet += StateView::of(sim.integrator().state()).velocity[i].z() / 121;
  EXPECT_LT(sheet, -0.5);
}

// A sheet that is stretched and held at its border, with a heavy ball on it.
const std::string trampoline = R"(
[time]
duration = 3
[material.net]
density = 0.3
membrane_stiffness = 3000
stiffness_damping = 0.2
mass_damping = 20
[[body]]
name = "net"
stretch = [1.05, 1.05, 1]
shape = { type = "rectangle", size = [1, 1], resolution = [21, 21] }
[[body.pin]]
edges = ["first_row", "last_row", "first_col", "last_col"]
[[particles]]
name = "ball"
radius = 0.08
density = 2000
positions = { type = "grid", count = [1, 1, 1], centre = [0.01, 0.02, 0.12] }
)";

TEST(ParticlesWithBodies, AHeavyBallHangsOnItsTrampoline) {
  constexpr double rested = 5;  // s, when the ball does not swing any more
  SimulatedCase sim(trampoline);
  const std::vector<double> y = sim.advance_to(rested);
  ForceParts parts;
  sim.dynamics().find_force_parts(rested, y, parts);
  Vec3 held = Vec3::Zero();
  for (const Vec3& force : parts.support) held += force;
  double weight = 0;
  const int ball_at = sim.scene().heavy_particles - 1;
  for (int i = 0; i <= ball_at; ++i) weight += gravity * sim.scene().mass[i];
  ASSERT_GT(weight, 40);
  EXPECT_NEAR(held.z() / weight, 1, 1e-3);
  const StateView state = StateView::of(y);
  EXPECT_LT(state.velocity[ball_at].norm(), 2e-3);
  EXPECT_LT(state.position[ball_at].z(), 0.03);  // sunk in by more than half its radius
  EXPECT_NEAR(parts.contact[ball_at].z() / (gravity * sim.scene().mass[ball_at]), 1, 1e-3);
  EXPECT_GT(least_gap(sim.scene(), sim.positions(rested, y)), 0);
}

// Balls beside each other in cloth, on a floor and in another group, all of them in reach.
std::string touching(double friction) {
  return R"(
[time]
duration = 1
[contact]
range = 0.01
[material.cloth]
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [31, 31] }
[[particles]]
name = "small"
radius = 0.03
friction = )" +
         std::to_string(friction) + R"(
positions = { type = "grid", count = [4, 4, 1], centre = [0.01, 0, 0.032], spacing = 0.065 }
[[particles]]
name = "large"
radius = 0.06
friction = )" +
         std::to_string(friction) + R"(
positions = { type = "grid", count = [3, 1, 1], centre = [0, 0.01, 0.13], spacing = 0.125 }
[[obstacle]]
name = "lid"
position = [0, 0, 0.1945]
rotation_deg = [0.3, 0, 0]
shape = { type = "rectangle", size = [2, 2], resolution = [4, 4] }
)";
}

struct RandomState {
  std::vector<Vec3> position, velocity;
};
RandomState random_state(const Scene& scene, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  RandomState state{scene.initial_position, std::vector<Vec3>(scene.particle_count, Vec3::Zero())};
  for (int i = 0; i < scene.dynamic_particles; ++i) {
    state.position[i] += 5e-4 * Vec3(number(random), number(random), number(random));
    state.velocity[i] = 0.02 * Vec3(number(random), number(random), number(random));
  }
  return state;
}
std::vector<Vec3> forces_at(Contact& contact, const Scene& scene, const RandomState& state) {
  std::vector<Vec3> force(scene.dynamic_particles, Vec3::Zero());
  const auto fault = contact.evaluate(state.position, state.velocity, 1);
  EXPECT_FALSE(fault) << fault->describe(scene);
  contact.add_forces(force);
  return force;
}

TEST(ParticlesWithBodies, ForcesAreMinusTheSlopeOfTheEnergy) {
  const auto scene = build_scene(parse_case(touching(0), "test.toml"));
  Statistics statistics;
  Contact contact(*scene, statistics);
  RandomState state = random_state(*scene, 1);
  for (Vec3& v : state.velocity) v.setZero();
  const std::vector<Vec3> force = forces_at(contact, *scene, state);
  std::array<int, 3> kinds{};
  for (const ContactPair& pair : contact.pairs()) {
    const auto of_sphere = [&](int node) { return node >= 961 && node < scene->dynamic_particles; };
    ++kinds[of_sphere(pair.nodes[0]) && of_sphere(pair.nodes[3]) ? 0
            : of_sphere(pair.nodes[0])                           ? 1
                                                                 : 2];
  }
  EXPECT_GE(kinds[0], 16);  // spheres with spheres
  EXPECT_GE(kinds[1], 5);   // spheres with the sheet or the lid
  EXPECT_GE(kinds[2], 5);   // vertices of the sheet with spheres
  double largest = 0;
  for (const Vec3& f : force) largest = std::max(largest, f.norm());
  ASSERT_GT(largest, 0);
  const double step = 1e-8;
  const auto energy_at = [&](const RandomState& at) {
    EXPECT_FALSE(contact.evaluate(at.position, at.velocity, 1));
    return contact.energy();
  };
  for (int i = 0; i < scene->dynamic_particles; i += i < 961 ? 17 : 1) {
    for (int axis = 0; axis < 3; ++axis) {
      RandomState moved = state;
      moved.position[i][axis] += step;
      const double above = energy_at(moved);
      moved.position[i][axis] -= 2 * step;
      EXPECT_NEAR(force[i][axis], -(above - energy_at(moved)) / (2 * step), 1e-5 * largest)
          << scene->describe_particle(i);
    }
  }
}

// Without friction, the forces of particles and sheet have neither a resultant nor a torque.
TEST(ParticlesWithBodies, ForcesBalance) {
  const auto scene =
      build_scene(parse_case(touching(0), "test.toml", {"obstacle.0.position=[0, 0, 1]"}));
  Statistics statistics;
  Contact contact(*scene, statistics);
  const RandomState state = random_state(*scene, 4);
  const std::vector<Vec3> force = forces_at(contact, *scene, state);
  Vec3 sum = Vec3::Zero(), torque = Vec3::Zero();
  double size = 0;
  for (int i = 0; i < scene->dynamic_particles; ++i) {
    sum += force[i];
    torque += state.position[i].cross(force[i]);
    size += force[i].norm();
  }
  ASSERT_GT(size, 0);
  EXPECT_LT(sum.norm(), 1e-12 * size);
  EXPECT_LT(torque.norm(), 1e-12 * size);
}

// Two spheres slide past each other: friction has Coulomb's share of the push.
TEST(ParticlesWithBodies, FrictionFollowsCoulomb) {
  const auto scene = build_scene(parse_case(
      two_balls, "test.toml",
      {"particles.0.positions.centre=[0, 0, 0]", "particles.1.positions.centre=[0.051, 0, 0]",
       "particles.0.friction=0.2", "particles.1.friction=0.45"}));
  Statistics statistics;
  Contact contact(*scene, statistics);
  const RandomState state{scene->initial_position, {Vec3(0, 1, 0), Vec3(0, -2, 0)}};
  const std::vector<Vec3> force = forces_at(contact, *scene, state);
  ASSERT_LT(force[0].x(), 0);
  EXPECT_NEAR(force[0].y() / force[0].x(), 0.3, 1e-9);  // the geometric mean
  EXPECT_LT((force[0] + force[1]).norm(), 1e-12 * force[0].norm());
}

TEST(ParticlesWithBodies, DampingBlocksAreTheSlopeOfTheForceInVelocity) {
  for (const double friction : {0.0, 0.4}) {
    const auto scene = build_scene(parse_case(touching(friction), "test.toml"));
    Statistics statistics;
    Contact contact(*scene, statistics);
    const RandomState state = random_state(*scene, 2);
    const std::vector<Vec3> direction = random_state(*scene, 3).velocity;
    const double step = 1e-5;
    RandomState ahead = state, behind = state;
    const int count = scene->dynamic_particles;
    for (int i = 0; i < count; ++i) {
      ahead.velocity[i] += step * direction[i];
      behind.velocity[i] -= step * direction[i];
    }
    const std::vector<Vec3> above = forces_at(contact, *scene, ahead),
                            below = forces_at(contact, *scene, behind);
    forces_at(contact, *scene, state);
    const double gamma = 1e-9;
    std::vector<Vec3> product(count, Vec3::Zero()), by_blocks = product;
    contact.add_product(gamma, std::span(direction).first(count), product);
    contact.visit_blocks(gamma, [&](int row, int column, const Mat3& block) {
      by_blocks[row] += block * direction[column];
    });
    double difference = 0, size = 0, forms = 0;
    for (int i = 0; i < count; ++i) {
      const Vec3 slope = -(above[i] - below[i]) / (2 * step);
      difference += (slope - product[i] / gamma).squaredNorm();
      forms += (by_blocks[i] - product[i]).squaredNorm() / (gamma * gamma);
      size += slope.squaredNorm();
    }
    // With friction, the slope of its limit by the normal rate is neglected.
    if (friction == 0) {
      EXPECT_LT(std::sqrt(difference / size), 1e-4);
    }
    EXPECT_LT(std::sqrt(forms / size), 1e-10) << friction;
  }
}

TEST(ParticlesWithBodies, HaveTheSameBitsOnAnyNumberOfThreads) {
  Simulation one = simulate(free_sheet, {"compute.threads=1"}),
             two = simulate(free_sheet, {"compute.threads=2"});
  for (int step = 0; step < 300; ++step) {
    ASSERT_FALSE(one.step());
    ASSERT_FALSE(two.step());
  }
  EXPECT_TRUE(std::ranges::equal(one.state(), two.state()));
}

TEST(ParticlesWithBodies, GoOnFromASavedStateWithTheSameBits) {
  const Overrides euler{"time.method=\"euler\""};
  Simulation whole = simulate(free_sheet, euler);
  for (int step = 0; step < 100; ++step) ASSERT_FALSE(whole.step());
  const std::string saved = whole.save();
  Simulation restored = simulate(free_sheet, euler);
  restored.restore(saved);
  for (int step = 0; step < 60; ++step) {
    ASSERT_FALSE(whole.step());
    ASSERT_FALSE(restored.step());
  }
  EXPECT_TRUE(std::ranges::equal(whole.state(), restored.state()));
}

// A ball as fast as a bullet, and smaller than a cell of the mesh.
TEST(ParticlesWithBodies, DoNotPassThroughCloth) {
  for (const std::string method : {"cvode", "arkode", "euler"}) {
    Simulation simulation =
        simulate(trampoline, {"time.method=\"" + method + "\"", "particles.0.radius=0.01",
                              "particles.0.velocity=[0, 0, -30]", "particles.0.density=200"});
    if (const auto failure = simulation.advance(0.05)) ADD_FAILURE() << method << failure->text;
    const double height = simulation.position("ball")[0].z();
    double lowest = 1;
    for (const Vec3& x : simulation.position("net")) lowest = std::min(lowest, x.z());
    EXPECT_GT(height, lowest) << method;
  }
}

}  // namespace
}  // namespace weft::sim::particles_with_bodies_test
