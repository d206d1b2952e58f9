// Spheres that turn, under error control: closed forms, invariants and derivatives.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <regex>
#include <sstream>

#include "sim/contact/contact.h"
#include "sim/simulation/simulation.h"
#include "tests/sim/channel_run.h"
#include "tests/sim/simulated_case.h"

namespace weft::sim::spinning_spheres_test {
namespace {

constexpr double gravity = 9.81;
constexpr double radius = 0.05;
const double degree = std::acos(-1.0) / 180;

// A ball at the range of a plane, which is inclined by `degrees` about y. `plane` has its keys.
std::string on_plane(double degrees, double friction, const std::string& plane) {
  const double distance = radius + 0.5e-3 + 1.99e-3;
  std::ostringstream text;
  text << "[time]\nduration = 2\n[[particles]]\nname = \"ball\"\nradius = " << radius
       << "\nrestitution = 0\nfriction = " << friction
       << "\npositions = { type = \"grid\", count = [1, 1, 1], centre = ["
       << distance * std::sin(degrees * degree) << ", 0, " << distance * std::cos(degrees * degree)
       << "] }\n"
       << plane << "rotation_deg = [0, " << degrees << ", 0]\n";
  return text.str();
}

const std::string obstacle = R"([[obstacle]]
name = "plane"
shape = { type = "rectangle", size = [8, 2], resolution = [5, 9] }
)";

Simulation simulate(const std::string& text, const Overrides& overrides = {}) {
  return Simulation(build_scene(parse_case(text, "test.toml", overrides)));
}

void run_until(Simulation& simulation, double time) {
  if (const auto failure = simulation.advance(time - simulation.time()))
    ADD_FAILURE() << failure->text;
}

Vec3 velocity_of_ball(const Simulation& simulation) { return simulation.velocity("ball")[0]; }

// The velocity r omega that stands for the angular velocity omega.
Vec3 turning_of_ball(const Simulation& simulation) { return simulation.velocity("ball (spin)")[0]; }

struct Accelerations {
  double along = 0, turning = 0;  // m/s^2, down the slope, and of the spin about y
};
Accelerations accelerations_on(Simulation simulation, double from, double to) {
  run_until(simulation, from);
  const double start = simulation.time(), speed = velocity_of_ball(simulation).norm();
  const double turning = turning_of_ball(simulation).y();
  run_until(simulation, to);
  const double time = simulation.time() - start;
  return {(velocity_of_ball(simulation).norm() - speed) / time,
          (turning_of_ball(simulation).y() - turning) / time};
}

TEST(SpinningSpheres, RollDownASlopeByEveryMethod) {
  const double exact = 5.0 / 7 * gravity * std::sin(20 * degree);
  for (const std::string method : {"cvode", "arkode", "euler"}) {
    const auto [along, turning] = accelerations_on(
        simulate(on_plane(20, 0.8, obstacle), {"time.method=\"" + method + "\""}), 0.2, 0.6);
    EXPECT_NEAR(along / exact, 1, 0.01) << method;
    EXPECT_NEAR(turning / exact, 1, 0.01) << method;
  }
}

// With a shell, masses are coupled, and surface points are not the particles.
TEST(SpinningSpheres, RollBesideAShell) {
  const std::string tile = R"([material.plastic]
model = "shell"
youngs_modulus = 1e7
shell_thickness = 2e-3
volume_density = 1000
[[body]]
name = "tile"
material = "plastic"
position = [0, 3, 0]
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [5, 5] }
)";
  const double exact = 5.0 / 7 * gravity * std::sin(20 * degree);
  const auto [along, turning] =
      accelerations_on(simulate(on_plane(20, 0.8, tile + obstacle)), 0.2, 0.4);
  EXPECT_NEAR(along / exact, 1, 0.01);
  EXPECT_NEAR(turning / exact, 1, 0.01);
}

TEST(SpinningSpheres, SlipOnASlopeThatIsTooSteep) {
  const double friction = 0.1, angle = 30 * degree;  // a ball rolls up to tan(angle) = 3.5 friction
  const auto [along, turning] =
      accelerations_on(simulate(on_plane(30, friction, obstacle)), 0.2, 0.5);
  EXPECT_NEAR(along / (gravity * (std::sin(angle) - friction * std::cos(angle))), 1, 0.01);
  EXPECT_NEAR(turning / (2.5 * friction * gravity * std::cos(angle)), 1, 0.01);
}

TEST(SpinningSpheres, OnlySlideWithoutSpin) {
  Simulation simulation = simulate(on_plane(20, 0.2, obstacle), {"particles.0.spin=false"});
  EXPECT_EQ(simulation.scene().dynamic_particles, 1);
  run_until(simulation, 0.2);
  const double start = simulation.time(), speed = velocity_of_ball(simulation).norm();
  run_until(simulation, 0.6);
  const double exact = gravity * (std::sin(20 * degree) - 0.2 * std::cos(20 * degree));
  EXPECT_NEAR((velocity_of_ball(simulation).norm() - speed) / (simulation.time() - start) / exact,
              1, 0.01);
}

// Spheres have spins only where something turns them.
TEST(SpinningSpheres, HaveSpinsWhereTheyCanTurn) {
  const std::string smooth = on_plane(0, 0, obstacle);
  const std::string pair =
      "[[contact.pair]]\nbetween = [\"ball\", \"plane\"]\nfriction = 0.1\nrestitution = 0\n";
  const auto spins_of = [](const std::string& text, const Overrides& overrides) {
    const auto scene = build_scene(parse_case(text, "test.toml", overrides));
    return scene->dynamic_particles - scene->heavy_particles;
  };
  EXPECT_EQ(spins_of(smooth, {}), 0);
  EXPECT_EQ(spins_of(smooth, {"contact.friction=0.3"}), 0);  // that of the particles precedes it
  EXPECT_EQ(spins_of(smooth, {"particles.0.friction=0.3"}), 1);
  EXPECT_EQ(spins_of(smooth, {"particles.0.friction=0.3", "contact.enabled=false"}), 0);
  EXPECT_EQ(spins_of(smooth, {"particles.0.angular_velocity_deg=[0, 0, 1]"}), 1);
  EXPECT_EQ(spins_of(smooth + pair, {}), 1);
  EXPECT_EQ(spins_of(smooth + pair, {"particles.0.spin=false"}), 0);
  const std::string without = std::regex_replace(smooth, std::regex("friction = 0\n"), "");
  EXPECT_EQ(spins_of(without, {}), 0);
  EXPECT_EQ(spins_of(without, {"contact.friction=0.3"}), 1);
}

// A ball that slides without turning rolls after (2/7) v / (friction g), with 5/7 of its speed
// (Coriolis, Théorie mathématique des effets du jeu de billard, 1835).
TEST(SpinningSpheres, SlidingBecomesRolling) {
  const double friction = 0.2, speed = 2, rolls_at = 2.0 / 7 * speed / (friction * gravity);
  Simulation simulation =
      simulate(on_plane(0, friction, obstacle), {"particles.0.velocity=[2, 0, 0]"});
  run_until(simulation, 0.9 * rolls_at);
  EXPECT_GT(velocity_of_ball(simulation).x(), 1.05 * turning_of_ball(simulation).y());
  run_until(simulation, 1.2 * rolls_at);
  const double rolling = velocity_of_ball(simulation).x();
  EXPECT_NEAR(rolling / speed, 5.0 / 7, 0.01);
  EXPECT_NEAR(turning_of_ball(simulation).y() / rolling, 1, 0.01);
  run_until(simulation, 1.2);
  EXPECT_NEAR(velocity_of_ball(simulation).x() / rolling, 1, 1e-3);
}

// A ball that turns backwards while it slides comes back.
TEST(SpinningSpheres, BackspinReturnsABall) {
  Simulation simulation = simulate(
      on_plane(0, 0.2, obstacle),
      {"particles.0.velocity=[0.6, 0, 0]", "particles.0.angular_velocity_deg=[0, -3000, 0]"});
  const double turning = -3000 * degree * radius;
  EXPECT_NEAR(turning_of_ball(simulation).y(), turning, 1e-12);
  run_until(simulation, 0.8);
  // The angular momentum about the line of contact is kept: 7/5 v = v_0 + 2/5 w_0.
  EXPECT_NEAR(velocity_of_ball(simulation).x() / ((0.6 + 0.4 * turning) / 1.4), 1, 0.02);
}

// On cloth a ball rolls on the middle surface, so that its arm is longer than its radius.
TEST(SpinningSpheres, RollDownStretchedCloth) {
  const std::string cloth = R"([material.cloth]
density = 0.2
membrane_stiffness = 4000
stiffness_damping = 0.01
mass_damping = 20
[[body]]
name = "plane"
stretch = [1.2, 1.2, 1]
shape = { type = "rectangle", size = [0.5, 0.3], resolution = [15, 25] }
pin = [{ edges = ["first_row", "last_row", "first_col", "last_col"] }]
)";
  const Overrides heavy{"particles.0.density=300"};
  Simulation rolling = simulate(on_plane(15, 0.8, cloth), heavy);
  Simulation sliding = simulate(on_plane(15, 0, cloth), heavy);
  const Vec3 start = rolling.position("ball")[0];
  run_until(rolling, 0.25);
  run_until(sliding, 0.25);
  const Vec3 down(std::cos(15 * degree), 0, -std::sin(15 * degree));
  const auto travel = [&](const Simulation& of) {
    return (of.position("ball")[0] - start).dot(down);
  };
  const Vec3 turned = rolling.position("ball (spin)")[0] - start;
  const double arm = travel(rolling) / turned.y();
  EXPECT_GT(arm, 1);
  // Half the thickness and the range make 1.06. A ball that bounces slips a little at each return.
  EXPECT_LT(arm, 1.1);
  const double ratio = travel(rolling) / travel(sliding);
  EXPECT_NEAR(ratio * (1 + 0.4 / (arm * arm)), 1, 0.02);
}

struct Momenta {
  Vec3 linear{0, 0, 0}, angular{0, 0, 0};
};
Momenta momenta_of(const Simulation& simulation) {
  Momenta sum;
  const Scene& scene = simulation.scene();
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const SceneBody& body = scene.bodies[b];
    const std::vector<Vec3> position = simulation.position(body.name),
                            velocity = simulation.velocity(body.name);
    for (int i = 0; i < body.particle_count(); ++i) {
      const double mass = scene.mass[body.first_particle + i];
      if (body.are_spins) {
        sum.angular += mass * body.spheres->radius * velocity[i];
        continue;
      }
      sum.linear += mass * velocity[i];
      sum.angular += mass * position[i].cross(velocity[i]);
    }
  }
  return sum;
}

void expect_the_same_momenta(Simulation& simulation, double until) {
  const Momenta before = momenta_of(simulation);
  const double energy = simulation.energies().total();
  bool has_turned = false;
  while (simulation.time() < until) {
    const auto failure = simulation.step();
    ASSERT_FALSE(failure) << failure->text;
    const Momenta now = momenta_of(simulation);
    const double size = std::max(before.linear.norm(), before.angular.norm() / 0.1);
    EXPECT_LT((now.linear - before.linear).norm(), 2e-3 * size) << simulation.time();
    EXPECT_LT((now.angular - before.angular).norm(), 2e-3 * 0.1 * size) << simulation.time();
    EXPECT_LT(simulation.energies().total(), 1.001 * energy) << simulation.time();
    for (const SceneBody& body : simulation.scene().bodies) {
      if (!body.are_spins) continue;
      for (const Vec3& w : simulation.velocity(body.name)) has_turned |= w.norm() > 0.1;
    }
  }
  EXPECT_TRUE(has_turned);
}

TEST(SpinningSpheres, KeepTheMomentaOfAnObliqueCollision) {
  Simulation simulation = simulate(R"(
[time]
duration = 1
[world]
gravity = [0, 0, 0]
[[particles]]
name = "heavy"
radius = 0.03
friction = 0.4
velocity = [1, 0, 0]
angular_velocity_deg = [0, 500, 4000]
positions = { type = "grid", count = [1, 1, 1], centre = [-0.1, 0, 0] }
[[particles]]
name = "light"
radius = 0.02
friction = 0.3
velocity = [-2, 0, 0]
positions = { type = "grid", count = [1, 1, 1], centre = [0.1, 0.02, 0.01] }
)");
  expect_the_same_momenta(simulation, 0.1);
}

TEST(SpinningSpheres, KeepTheMomentaOfAFreeSheet) {
  Simulation simulation = simulate(R"(
[time]
duration = 1
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
friction = 0.4
velocity = [1.5, 0, -3]
positions = { type = "grid", count = [2, 1, 2], centre = [0.0, 0.03, 0.12], spacing = 0.066 }
)");
  expect_the_same_momenta(simulation, 0.1);
}

TEST(SpinningSpheres, GoOnFromACheckpointWithTheSameBits) {
  const std::string text = on_plane(20, 0.8, obstacle);
  Simulation whole = simulate(text);
  run_until(whole, 0.1);
  const std::string saved = whole.renew();
  Simulation later = simulate(text);
  later.restore(saved);
  run_until(whole, 0.2);
  run_until(later, 0.2);
  EXPECT_GT(turning_of_ball(whole).norm(), 0.2);
  EXPECT_EQ(turning_of_ball(later), turning_of_ball(whole));
  EXPECT_EQ(velocity_of_ball(later), velocity_of_ball(whole));
}

// The energy of a body that is recorded has the rotation, too.
TEST(SpinningSpheres, RecordedEnergiesHaveTheRotation) {
  ChannelRun run(on_plane(20, 0.8, obstacle) + "[output]\nchannels = [\"body_energy\"]\n");
  run.advance_to(0.2);
  ASSERT_EQ(run.scene().dynamic_particles, 2);
  const double motion = 0.5 * run.scene().mass[0] * run.velocity()[0].squaredNorm();
  const double rotation = 0.5 * run.scene().mass[1] * run.velocity()[1].squaredNorm();
  EXPECT_NEAR(rotation / motion, 0.4, 0.02);  // it rolls
  EXPECT_NEAR(run.record("body_energy/ball/kinetic")[0] / (motion + rotation), 1, 1e-12);
}

// By every method, a ball that rolls turns with its speed over its radius.
TEST(SpinningSpheres, RecordTheirAngularVelocity) {
  for (const std::string method : {"cvode", "euler", "impulses"}) {
    ChannelRun run(on_plane(20, 0.8, obstacle) + "[output]\nchannels = [\"angular_velocity\"]\n",
                   {"time.method=\"" + method + "\""});
    run.advance_to(0.2);
    const std::vector<Vec3> turning = run.vectors("ball", "angular_velocity");
    ASSERT_EQ(turning.size(), 1);
    const double speed = run.velocity()[0].norm();
    EXPECT_GT(speed, 0.3) << method;
    EXPECT_NEAR(turning[0].y() * radius / speed, 1, 0.02) << method;
    EXPECT_LT(std::hypot(turning[0].x(), turning[0].z()), 1e-6 * turning[0].y()) << method;
  }
}

// A sphere in flight turns on. With spin = false it does not turn at all.
TEST(SpinningSpheres, RecordsAreThoseOfTheCase) {
  for (const std::string method : {"arkode", "impulses"}) {
    ChannelRun run(R"(
[time]
duration = 1
[output]
channels = ["angular_velocity"]
[[particles]]
name = "still"
radius = 0.1
spin = false
positions = { type = "grid", count = [1, 1, 1] }
[[particles]]
name = "turning"
radius = 0.2
angular_velocity_deg = [0, 90, 0]
positions = { type = "grid", count = [2, 1, 1], centre = [0, 0, 2] }
)",
                   {"time.method=\"" + method + "\""});
    run.advance_to(0.1);
    EXPECT_EQ(run.vectors("still", "angular_velocity"), std::vector<Vec3>{Vec3::Zero()});
    const std::vector<Vec3> turning = run.vectors("turning", "angular_velocity");
    ASSERT_EQ(turning.size(), 2);
    for (const Vec3& each : turning)
      EXPECT_LT((each - Vec3(0, std::acos(-1.0) / 2, 0)).norm(), 1e-12) << method;
  }
}

// Balls that touch each other, cloth and an obstacle, and turn.
const std::string touching = R"(
[time]
duration = 1
[contact]
range = 0.01
[material.cloth]
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [11, 11] }
[[particles]]
name = "small"
radius = 0.03
friction = 0.5
positions = { type = "grid", count = [3, 2, 1], centre = [0.01, 0, 0.034], spacing = 0.064 }
[[particles]]
name = "still"
radius = 0.02
friction = 0.2
spin = false
positions = { type = "grid", count = [1, 1, 1], centre = [0.01, 0.0, 0.084] }
[[obstacle]]
name = "lid"
position = [0, 0, 0.069]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [4, 4] }
)";

// Damping blocks, products, diagonals and the definite couplings of preconditioners belong to one
// matrix, which is the slope of the forces in the velocities.
TEST(SpinningSpheres, MatricesAreTheSlopeOfTheForceInVelocity) {
  const auto scene =
      build_scene(parse_case(touching, "test.toml", {"obstacle.0.position=[0, 0.14, 0.069]"}));
  const int count = scene->dynamic_particles;
  ASSERT_EQ(count, 121 + 6 + 1 + 6);
  ASSERT_EQ(scene->heavy_particles, 121 + 6 + 1);
  Statistics statistics;
  Contact contact(*scene, statistics);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1, 1);
  std::vector<Vec3> velocity(scene->particle_count, Vec3::Zero()), direction(count);
  // Only spins change, since the matrix neglects how friction follows the push, and with it the
  // rate of the gap.
  for (int i = 0; i < count; ++i) {
    velocity[i] = 0.02 * Vec3(number(random), number(random), number(random));
    direction[i] = Vec3(number(random), number(random), number(random));
    if (i < scene->heavy_particles) direction[i].setZero();
  }
  const auto forces = [&](double step) {
    std::vector<Vec3> moved = velocity, force(count, Vec3::Zero());
    for (int i = 0; i < count; ++i) moved[i] += step * direction[i];
    const auto fault = contact.evaluate(scene->initial_position, moved, 1);
    EXPECT_FALSE(fault) << fault->describe(*scene);
    contact.add_forces(force);
    return force;
  };
  const double step = 1e-6, gamma = 1e-9;
  const std::vector<Vec3> above = forces(step), below = forces(-step);
  const std::vector<Vec3> force = forces(0);
  std::vector<Vec3> product(count, Vec3::Zero()), by_blocks = product;
  std::vector<Mat3> diagonal(count, Mat3::Zero()), diagonal_by_blocks = diagonal;
  contact.add_product(gamma, direction, product);
  contact.add_diagonal(gamma, diagonal);
  contact.visit_blocks(gamma, [&](int row, int column, const Mat3& block) {
    by_blocks[row] += block * direction[column];
    if (row == column) diagonal_by_blocks[row] += block;
  });
  double size = 0, spins = 0;
  for (int i = 0; i < count; ++i) size = std::max(size, product[i].norm());
  for (int i = 0; i < count; ++i) {
    EXPECT_LT((-gamma / (2 * step) * (above[i] - below[i]) - product[i]).norm(), 1e-6 * size) << i;
    EXPECT_LT((by_blocks[i] - product[i]).norm(), 1e-12 * size) << i;
    EXPECT_LT((diagonal_by_blocks[i] - diagonal[i]).norm(), 1e-12 * (size + diagonal[i].norm()));
    if (i >= scene->heavy_particles) spins += force[i].norm() > 0 ? 1 : 0;
  }
  EXPECT_EQ(spins, 6);
  std::vector<Mat3> definite(count, Mat3::Zero());
  contact.visit_definite_couplings(gamma, [&](const Contact::Coupling& coupling) {
    for (std::size_t i = 0; i < coupling.particles.size(); ++i) {
      const int particle = coupling.particles[i];
      if (particle >= scene->heavy_particles && particle < count)
        definite[particle] += coupling.weights[i] * coupling.weights[i] * coupling.block;
    }
  });
  for (int i = scene->heavy_particles; i < count; ++i)
    EXPECT_LT((definite[i] - diagonal[i]).norm(), 1e-9 * diagonal[i].norm()) << i;
}

// The forces on balls, spins and cloth have neither a resultant nor a torque.
TEST(SpinningSpheres, FrictionBalances) {
  const auto scene = build_scene(parse_case(
      touching, "test.toml", {"obstacle.0.position=[0, 0, 1]", "particles.1.spin=true"}));
  Statistics statistics;
  Contact contact(*scene, statistics);
  std::mt19937 random(6);
  std::uniform_real_distribution<double> number(-1, 1);
  std::vector<Vec3> velocity(scene->particle_count, Vec3::Zero());
  for (int i = 0; i < scene->dynamic_particles; ++i)
    velocity[i] = Vec3(number(random), number(random), number(random));
  ASSERT_FALSE(contact.evaluate(scene->initial_position, velocity, 1));
  std::vector<Vec3> normal(scene->dynamic_particles, Vec3::Zero()), friction = normal;
  contact.add_forces(normal, friction);
  Vec3 sum = Vec3::Zero(), torque = Vec3::Zero();
  double size = 0;
  for (int i = 0; i < scene->dynamic_particles; ++i) {
    const SceneBody& body = scene->body_of_particle(i);
    size += friction[i].norm();
    if (body.are_spins) {
      torque += body.spheres->radius * friction[i];
      continue;
    }
    sum += friction[i];
    torque += scene->initial_position[i].cross(friction[i]);
  }
  ASSERT_GT(size, 0);
  EXPECT_LT(sum.norm(), 1e-12 * size);
  EXPECT_LT(torque.norm(), 1e-12 * size);
}

// A floor carries a ball's weight and feels its friction: the moment is that of the force at the
// place where they touch.
TEST(SpinningSpheres, ReactionsActWhereTheyTouch) {
  SimulatedCase sim(on_plane(0, 0.3, obstacle), {"particles.0.velocity=[1, 0, 0]"});
  const std::vector<double> y = sim.advance_to(0.05);
  std::vector<Vec3> position, velocity;
  sim.dynamics().expand_all(0.05, y, position, velocity);
  Contact& contact = *sim.dynamics().contact();
  ASSERT_FALSE(contact.evaluate(position, velocity, 1));
  std::vector<Wrench> wrench(sim.scene().bodies.size());
  contact.add_wrenches(position, wrench);
  const Wrench& floor = wrench.back();
  const Vec3 contact_point = position[0] - radius * Vec3::UnitZ();
  ASSERT_LT(floor.force.x(), 0);
  EXPECT_LT((floor.moment - contact_point.cross(floor.force)).norm(), 1e-9 * floor.force.norm());
}

}  // namespace
}  // namespace weft::sim::spinning_spheres_test
