// Rigid particles that collide by impulses: closed forms of bounces and slides, and invariants.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "bsi/proximity.h"
#include "sim/motion/dynamics.h"
#include "sim/simulation/simulation.h"
#include "tests/sim/ball_on_floor.h"
#include "tests/sim/simulated_case.h"

namespace weft::sim::particles_test {
namespace {

constexpr double gravity = 9.81;

Simulation simulate(const std::string& text, const Overrides& overrides) {
  return Simulation(build_scene(parse_case(text, "test.toml", overrides)));
}

// Returns the heights of the first bounces above the place where the ball rests.
std::vector<double> bounce_heights(const Overrides& overrides, std::size_t count) {
  Simulation simulation = simulate(ball_on_floor, overrides);
  const double rest = 0.02 + 0.5e-3;
  std::vector<double> heights;
  double highest = 0, last_speed = -1;
  while (heights.size() < count && simulation.time() < 10) {
    if (const auto failure = simulation.step()) {
      ADD_FAILURE() << failure->text;
      break;
    }
    const double height = simulation.position("ball")[0].z() - rest;
    const double speed = simulation.velocity("ball")[0].z();
    // The apex lies between two steps: height + v^2 / 2 g is constant in free flight.
    highest = height + speed * speed / (2 * gravity);
    if (last_speed > 0 && speed <= 0) heights.push_back(highest);
    last_speed = speed;
  }
  return heights;
}

TEST(Particles, BounceToTheHeightsOfNewtonsLaw) {
  const double start = 0.5 - 0.0205;
  for (const double e : {0.2, 0.5, 0.8}) {
    for (const std::string step : {"1e-4", "1e-3", "3.7e-3", "8e-3"}) {
      for (const std::string mesh : {"2, 2", "5, 5", "70, 90"}) {
        const std::size_t bounces = e > 0.3 ? 3 : 1;
        const std::vector<double> heights =
            bounce_heights({"time.step=" + step, "particles.0.restitution=" + std::to_string(e),
                            "obstacle.0.shape.resolution=[" + mesh + "]"},
                           bounces);
        ASSERT_EQ(heights.size(), bounces);
        for (std::size_t n = 0; n < bounces; ++n) {
          const double exact = std::pow(e, 2 * static_cast<double>(n + 1)) * start;
          EXPECT_NEAR(heights[n] / exact, 1, 0.01)
              << "e " << e << ", step " << step << ", mesh " << mesh << ", bounce " << n;
        }
      }
    }
  }
}

// Looks between the ends of the step with the first impact, after which the ball still slides.
TEST(Particles, HaveTheVelocitiesOfTheirTimeBetweenSteps) {
  const double e = 0.6, friction = 0.1, across = 2;
  const Overrides overrides{"time.step=8e-3", "particles.0.restitution=0.6",
                            "particles.0.velocity=[2, 0, 0]", "particles.0.friction=0.1"};
  Simulation simulation = simulate(ball_on_floor, overrides);
  const double impact = std::sqrt(2 * (0.5 - 0.02052) / gravity), speed = gravity * impact;
  const double slowed = friction * (1 + e) * speed;
  double before = 0;
  while (simulation.time() < impact) {
    before = simulation.time();
    ASSERT_FALSE(simulation.step());
  }
  Simulation restored = simulate(ball_on_floor, overrides);
  restored.restore(simulation.save());
  std::vector<double> y(simulation.state().size()), again(y.size());
  for (double time = before; time < simulation.time(); time += 0.4e-3) {
    ASSERT_FALSE(simulation.state_at(time, y));
    ASSERT_FALSE(restored.state_at(time, again));
    EXPECT_EQ(y, again);
    const bool is_after = time > impact;
    const Vec3 velocity = StateView::of(y).velocity[0],
               exact(across - (is_after ? slowed : 0), 0,
                     -gravity * time + (is_after ? (1 + e) * speed : 0));
    EXPECT_LT((velocity - exact).norm(), 1e-4) << "at " << time << " s";
    const Vec3 spin(0, is_after ? 2.5 * slowed / 0.02 : 0, 0);
    EXPECT_LT((simulation.integrator().spins_at(time)[0] - spin).norm(), 1e-2)
        << "at " << time << " s";
  }
}

// A plane inclined by `degrees`, with a ball that touches it.
std::string slope(double degrees, double friction, bool spin) {
  const double angle = degrees * std::acos(-1.0) / 180, distance = 0.02 + 0.5e-3 + 2e-5;
  std::ostringstream text;
  text << "[time]\nmethod = \"impulses\"\nduration = 2\n[[particles]]\nname = \"ball\"\n"
       << "radius = 0.02\nspin = " << (spin ? "true" : "false") << "\nfriction = " << friction
       << "\npositions = { type = \"grid\", count = [1, 1, 1], centre = ["
       << distance * std::sin(angle) << ", 0, " << distance * std::cos(angle)
       << "] }\n[[obstacle]]\nname = \"slope\"\n"
       << "rotation_deg = [0, " << degrees
       << ", 0]\nshape = { type = \"rectangle\", size = [40, 2], resolution = [9, 41] }\n";
  return text.str();
}

// Returns the acceleration down the slope, from the speed after a second.
double acceleration_on(const std::string& text, const std::string& step) {
  Simulation simulation = simulate(text, {"time.step=" + step});
  if (const auto failure = simulation.advance(0.2)) ADD_FAILURE() << failure->text;
  const double before = simulation.velocity("ball")[0].norm(), start = simulation.time();
  if (const auto failure = simulation.advance(1)) ADD_FAILURE() << failure->text;
  return (simulation.velocity("ball")[0].norm() - before) / (simulation.time() - start);
}

TEST(Particles, SlideDownSlopesBeyondTheThreshold) {
  const double angle = 30 * std::acos(-1.0) / 180;
  for (const std::string step : {"5e-4", "3e-3"}) {
    for (const double friction : {0.0, 0.1, 0.3, 0.5}) {
      const double exact = gravity * (std::sin(angle) - friction * std::cos(angle));
      EXPECT_NEAR(acceleration_on(slope(30, friction, false), step) / exact, 1, 0.01)
          << "friction " << friction << ", step " << step;
    }
    const double threshold = std::tan(angle);
    EXPECT_LT(acceleration_on(slope(30, 1.01 * threshold, false), step), 1e-6);
    EXPECT_GT(acceleration_on(slope(30, 0.99 * threshold, false), step), 0.03);
  }
}

TEST(Particles, RollDownASlope) {
  const double angle = 20 * std::acos(-1.0) / 180;
  for (const std::string step : {"5e-4", "3e-3"}) {
    const double exact = 5.0 / 7 * gravity * std::sin(angle);
    EXPECT_NEAR(acceleration_on(slope(20, 0.8, true), step) / exact, 1, 0.01) << step;
  }
}

TEST(Particles, StopAfterTheDistanceOfFriction) {
  for (const std::string step : {"5e-4", "3e-3"}) {
    Simulation simulation = simulate(
        ball_on_floor,
        {"time.step=" + step, "particles.0.positions.centre=[-1, 0.01, 0.0206]",
         "particles.0.velocity=[2, 0, 0]", "particles.0.spin=false", "particles.0.friction=0.25"});
    if (const auto failure = simulation.advance(2)) ADD_FAILURE() << failure->text;
    const double exact = 2 * 2 / (2 * 0.25 * gravity);
    EXPECT_NEAR((simulation.position("ball")[0].x() + 1) / exact, 1, 0.01) << step;
    EXPECT_LT(simulation.velocity("ball")[0].norm(), 1e-9);
  }
}

TEST(Particles, FallWithTheDragOfAir) {
  Simulation simulation =
      simulate(ball_on_floor, {"particles.0.drag_coefficient=0.47", "particles.0.density=20",
                               "particles.0.positions.centre=[0, 0, 30]", "time.step=2e-3"});
  if (const auto failure = simulation.advance(1.5)) ADD_FAILURE() << failure->text;
  // v = w tanh(g t / w), with the terminal speed w at which the drag equals the weight.
  const double area = std::acos(-1.0) * 0.02 * 0.02, mass = 20 * 4.0 / 3 * area * 0.02;
  const double terminal = std::sqrt(2 * mass * gravity / (1.2 * 0.47 * area));
  const double exact = terminal * std::tanh(gravity * 1.5 / terminal);
  EXPECT_NEAR(-simulation.velocity("ball")[0].z() / exact, 1, 1e-4);
}

// Balls that fly about in empty space and collide with each other alone.
const std::string cloud = R"(
[time]
method = "impulses"
duration = 0.5
step = 2e-3
[world]
gravity = [0, 0, 0]
[[particles]]
name = "large"
radius = 0.02
restitution = 0.7
friction = 0.3
velocity = [0.5, 0, 0]
positions = { type = "random", number = 60, region_min = [-0.2, -0.1, -0.1], region_max = [0, 0.1, 0.1] }
[[particles]]
name = "small"
radius = 0.01
density = 3000
velocity = [-1, 0.1, 0]
restitution = 0.4
positions = { type = "random", number = 120, region_min = [0.05, -0.1, -0.1], region_max = [0.25, 0.1, 0.1], seed = 4 }
)";

struct Momenta {
  Vec3 linear{0, 0, 0}, orbital{0, 0, 0};
};

Momenta momenta(const Simulation& simulation) {
  const StateView state = StateView::of(simulation.state());
  Momenta result;
  for (std::size_t i = 0; i < state.position.size(); ++i) {
    const double mass = simulation.scene().mass[i];
    result.linear += mass * state.velocity[i];
    result.orbital += mass * state.position[i].cross(state.velocity[i]);
  }
  return result;
}

// Returns the least gap of all pairs of spheres, by brute force.
double least_gap(const Simulation& simulation) {
  const StateView state = StateView::of(simulation.state());
  std::vector<double> radius;
  for (int b = 0; b < simulation.scene().dynamic_bodies; ++b) {
    const SceneBody& body = simulation.scene().bodies[b];
    radius.insert(radius.end(), body.particle_count(), body.spheres->radius);
  }
  double least = 1;
  for (std::size_t a = 0; a < radius.size(); ++a) {
    for (std::size_t b = a + 1; b < radius.size(); ++b) {
      const double distance = (state.position[a] - state.position[b]).norm();
      least = std::min(least, distance - radius[a] - radius[b]);
    }
  }
  return least;
}

TEST(Particles, KeepTheirMomentumAndLoseEnergyAmongThemselves) {
  for (const std::string spin : {"true", "false"}) {
    Simulation simulation =
        simulate(cloud, {"particles.0.spin=" + spin, "particles.1.spin=" + spin});
    const Momenta start = momenta(simulation);
    double energy = simulation.energies().total();
    const double first = energy;
    while (simulation.time() < 0.5) {
      const auto failure = simulation.step();
      ASSERT_FALSE(failure) << failure->text;
      const double now = simulation.energies().total();
      EXPECT_LE(now, energy + 1e-9 * first) << "at " << simulation.time() << " s";
      energy = now;
      EXPECT_GE(least_gap(simulation), 0) << "at " << simulation.time() << " s";
    }
    EXPECT_LT(energy, 0.9 * first);
    EXPECT_GT(energy, 0.01 * first);
    const Momenta end = momenta(simulation);
    EXPECT_LT((end.linear - start.linear).norm(), 1e-10 * start.linear.norm() + 1e-12);
  }
}

TEST(Particles, CollideHeadOnWithNewtonsLaw) {
  const std::string text = R"(
[time]
method = "impulses"
duration = 1
[world]
gravity = [0, 0, 0]
[[particles]]
name = "one"
radius = 0.02
restitution = 0.6
velocity = [1, 0, 0]
positions = { type = "grid", count = [1, 1, 1], centre = [-0.2, 0, 0] }
[[particles]]
name = "other"
radius = 0.03
density = 2000
restitution = 0.1
velocity = [-0.5, 0, 0]
positions = { type = "grid", count = [1, 1, 1], centre = [0.2, 0, 0] }
)";
  for (const double e : {0.0, 0.6, 1.0}) {
    Overrides pair{"time.step=1.7e-3"};
    std::string whole = text;
    if (e != 0.6)
      whole +=
          "[[contact.pair]]\nbetween = [\"other\", \"one\"]\nrestitution = " + std::to_string(e) +
          "\n";
    Simulation simulation = simulate(whole, pair);
    const double m = simulation.scene().mass[0], n = simulation.scene().mass[1];
    const double mean = (m * 1 - n * 0.5) / (m + n);
    std::vector<double> y(simulation.state().size());
    for (double time = 0.9e-3; time < 0.5; time += 1.7e-3) {
      while (simulation.time() < time) ASSERT_FALSE(simulation.step());
      ASSERT_FALSE(simulation.state_at(time, y));
      const std::span<const Vec3> velocity = StateView::of(y).velocity;
      EXPECT_NEAR(m * velocity[0].x() + n * velocity[1].x(), (m + n) * mean, 1e-12);
    }
    if (const auto failure = simulation.advance(0.6 - simulation.time()))
      ADD_FAILURE() << failure->text;
    EXPECT_NEAR(simulation.velocity("one")[0].x(), mean - e * 1.5 * n / (m + n), 1e-9) << e;
    EXPECT_NEAR(simulation.velocity("other")[0].x(), mean + e * 1.5 * m / (m + n), 1e-9) << e;
    // The places follow from the time of the impact, at a gap of a thousandth of the radius.
    const double impact = (0.4 - 0.05 - 2e-5) / 1.5;
    EXPECT_NEAR(simulation.position("one")[0].x(),
                -0.2 + impact + (0.6 - impact) * (mean - e * 1.5 * n / (m + n)), 1e-6)
        << e;
  }
}

// Balls that are poured into a box without a lid, whose floor is a torus on a plane.
const std::string heap = R"(
[time]
method = "impulses"
duration = 1.2
frames_per_second = 30
[contact]
friction = 0.4
[[particles]]
name = "balls"
radius = 0.02
restitution = 0.3
positions = { type = "grid", count = [7, 7, 10], centre = [0, 0, 0.5], jitter = 0.001 }
[[obstacle]]
name = "torus"
position = [0, 0, 0.05]
shape = { type = "torus", major_radius = 0.15, minor_radius = 0.05, resolution = [48, 24] }
[[obstacle]]
name = "floor"
shape = { type = "rectangle", size = [4, 4], resolution = [9, 9] }
)";

// Returns the least distance of a sphere's surface from those of the torus and the floor.
double least_surface_gap(const Simulation& simulation) {
  double least = 1;
  const Scene& scene = simulation.scene();
  for (const Vec3& x : simulation.position("balls")) {
    for (std::size_t b = 1; b < scene.bodies.size(); ++b) {
      const SceneBody& body = scene.bodies[b];
      for (const auto& [i, j, k] : body.mesh.triangles) {
        const Vec3* vertex = &scene.initial_position[body.first_particle];
        const double distance = std::sqrt(
            bsi::closest_vertex_triangle(x, vertex[i], vertex[j], vertex[k]).squared_distance);
        least = std::min(least, distance - 0.02 - 0.5 * body.thickness);
      }
    }
  }
  return least;
}

// Elastic balls in a box without a lid, eight unless more are asked for.
std::string box_of_elastic_balls() {
  std::string box = R"(
[time]
method = "impulses"
duration = 60
[[particles]]
name = "balls"
radius = 0.05
restitution = 1
velocity = [0.3, 0.2, 0]
positions = { type = "grid", count = [2, 2, 2], spacing = 0.15, centre = [0.01, 0.02, 0.25], jitter = 0.02 }
[[obstacle]]
name = "floor"
shape = { type = "plane", size = [2, 2] }
)";
  const std::array<const char*, 4> walls{"-0.25, 0, 0.5", "0.25, 0, 0.5", "0, -0.25, 0.5",
                                         "0, 0.25, 0.5"};
  for (std::size_t w = 0; w < walls.size(); ++w) {
    box += "[[obstacle]]\nname = \"wall" + std::to_string(w) + "\"\nposition = [" + walls[w] +
           "]\nrotation_deg = [" + (w < 2 ? "0, 90" : "90, 0") +
           ", 0]\nshape = { type = \"plane\", size = [2, 2] }\n";
  }
  return box;
}

// The energies of a run, as fractions of the first one.
struct EnergyGains {
  double sum = 0, largest = 0;  // of steps
  double last = 1;
};

EnergyGains energy_gains(double duration, const Overrides& overrides) {
  Simulation simulation = simulate(box_of_elastic_balls(), overrides);
  const double first = simulation.energies().total();
  EnergyGains gains;
  while (simulation.time() < duration) {
    const auto failure = simulation.step();
    EXPECT_FALSE(failure) << failure->text;
    if (failure) break;
    const double now = simulation.energies().total() / first;
    gains.sum += std::max(0.0, now - gains.last);
    gains.largest = std::max(gains.largest, now - gains.last);
    gains.last = now;
  }
  return gains;
}

// The balls meet walls, floor and each other in the same steps. Without friction they keep their
// energy; with friction their spins have a part of it. Steps usually gain 1e-6 of it at the most,
// but a sphere may be lifted while it is too slow to pay.
TEST(Particles, GainNoEnergyByManyElasticImpacts) {
  const EnergyGains smooth = energy_gains(60, {});
  EXPECT_LT(smooth.sum, 1e-2);
  EXPECT_GT(smooth.last, 0.998);
  EXPECT_LT(energy_gains(60, {"particles.balls.friction=0.3"}).sum, 1e-2);
}

// A heavy ball falls on a light one at rest, which pushes the floor in the same step.
const std::string heavy_on_light = ball_on_floor + R"(
[[particles]]
name = "heavy"
radius = 0.02
density = 20000
positions = { type = "grid", count = [1, 1, 1], centre = [0.003, 0.001, 0.2] }
)";

// Several impulses of one ball in a step do not act in the order of their times.
TEST(Particles, HaveNoEnergyTooMuchBetweenSteps) {
  const std::string at_rest = "particles.0.positions.centre=[0.003, 0.001, 0.02052]";
  for (const auto& [text, overrides] :
       {std::pair{box_of_elastic_balls(), Overrides{}},
        std::pair{heavy_on_light, Overrides{at_rest, "particles.heavy.restitution=0"}}}) {
    Simulation simulation = simulate(text, overrides);
    const double first = simulation.energies().total();
    std::vector<double> y(simulation.state().size());
    double before = 0;
    while (simulation.time() < 10) {
      const auto failure = simulation.step();
      ASSERT_FALSE(failure) << failure->text;
      const double middle = 0.5 * (before + simulation.time());
      ASSERT_FALSE(simulation.state_at(middle, y));
      EXPECT_LT(simulation.summary_of(middle, y).energies.total(), 1.01 * first) << middle << " s";
      before = simulation.time();
    }
  }
}

// Six layers of sixteen balls fill the box, so that impulses pass through all of them.
TEST(Particles, GainHardlyAnyEnergyInADenseBox) {
  const Overrides dense{
      "particles.balls.positions.count=[4, 4, 6]", "particles.balls.positions.spacing=0.105",
      "particles.balls.positions.jitter=0.002", "particles.balls.positions.centre=[0, 0, 0.4]"};
  const EnergyGains elastic = energy_gains(30, dense);
  EXPECT_LT(elastic.largest, 2e-3);
  EXPECT_LT(elastic.last, 1.02);
  EXPECT_GT(elastic.last, 0.99);
  Overrides settling = dense;
  settling.emplace_back("particles.balls.restitution=0.97");
  EXPECT_LT(energy_gains(30, settling).largest, 2e-3);
}

TEST(Particles, ComeToRestInAHeapWithoutOverlap) {
  Simulation simulation = simulate(heap, {});
  double energy = simulation.energies().total();
  const double first = energy;
  double next = 0;
  while (simulation.time() < 1.2) {
    const auto failure = simulation.step();
    ASSERT_FALSE(failure) << failure->text;
    const double now = simulation.energies().total();
    EXPECT_LE(now, energy + 2e-5 * first) << "at " << simulation.time() << " s";
    energy = now;
    if (simulation.time() < next) continue;
    next += 1.0 / 30;
    EXPECT_GE(least_gap(simulation), 0) << "at " << simulation.time() << " s";
    EXPECT_GE(least_surface_gap(simulation), -1e-12) << "at " << simulation.time() << " s";
  }
  int in_the_hole = 0;
  for (const Vec3& x : simulation.position("balls")) {
    EXPECT_GT(x.z(), 0.02);
    in_the_hole += std::hypot(x.x(), x.y()) < 0.1 && x.z() < 0.12 ? 1 : 0;
  }
  EXPECT_GT(in_the_hole, 15);
}

TEST(Particles, TakeShorterStepsWhileMostAreFast) {
  // A fifth of the balls may move by more than 0.17 of the radius in a step, and none by more than
  // three quarters.
  Simulation simulation = simulate(heap, {});
  double longest = 0;
  while (simulation.time() < 0.6) {
    const double before = simulation.time();
    const auto failure = simulation.step();
    ASSERT_FALSE(failure) << failure->text;
    const double length = simulation.time() - before;
    longest = std::max(longest, length);
    int fast = 0;
    for (const Vec3& velocity : simulation.velocity("balls")) {
      const double move = length * velocity.norm() / 0.02;
      EXPECT_LT(move, 0.76);
      fast += move > 0.18 ? 1 : 0;
    }
    EXPECT_LE(fast, 0.21 * 490) << "at " << before << " s";
  }
  EXPECT_GT(longest, 4e-3);
}

TEST(Particles, HaveTheSameBitsOnAnyNumberOfThreads) {
  Simulation one = simulate(heap, {"compute.threads=1"}),
             two = simulate(heap, {"compute.threads=2"});
  for (int step = 0; step < 150; ++step) {
    ASSERT_FALSE(one.step());
    ASSERT_FALSE(two.step());
  }
  EXPECT_TRUE(std::ranges::equal(one.state(), two.state()));
}

TEST(Particles, GoOnFromASavedStateWithTheSameBits) {
  Simulation whole = simulate(heap, {});
  for (int step = 0; step < 120; ++step) ASSERT_FALSE(whole.step());
  const std::string saved = whole.save();
  Simulation restored = simulate(heap, {});
  restored.restore(saved);
  for (int step = 0; step < 60; ++step) {
    ASSERT_FALSE(whole.step());
    ASSERT_FALSE(restored.step());
  }
  EXPECT_TRUE(std::ranges::equal(whole.state(), restored.state()));
}

TEST(Particles, RideOnMovingObstacles) {
  // A tray moves sideways and carries a ball that sticks to it. A piston lifts another one.
  const std::string text = R"(
[time]
method = "impulses"
duration = 1
step = 2e-3
[[particles]]
name = "ball"
radius = 0.02
spin = false
friction = 2
restitution = 0
positions = { type = "grid", count = [1, 1, 1], centre = [0, 0, 0.0206] }
[[obstacle]]
name = "tray"
shape = { type = "rectangle", size = [1, 1], resolution = [6, 6] }
motion = { velocity = [0.4, 0, 0.3], start_time = 0.1 }
)";
  Simulation simulation = simulate(text, {});
  if (const auto failure = simulation.advance(1)) ADD_FAILURE() << failure->text;
  const Vec3 place = simulation.position("ball")[0];
  EXPECT_NEAR(place.x(), 0.36, 2e-3);
  EXPECT_NEAR(place.z(), 0.0206 + 0.27, 2e-3);
  EXPECT_NEAR(simulation.velocity("ball")[0].x(), 0.4, 1e-6);
}

TEST(Particles, StopTheRunWhereThereIsNoRoom) {
  const std::string text = R"(
[time]
method = "impulses"
duration = 1
[[particles]]
name = "ball"
radius = 0.02
positions = { type = "grid", count = [1, 1, 1], centre = [0, 0, 0.03] }
[[obstacle]]
name = "floor"
shape = { type = "rectangle", size = [1, 1], resolution = [6, 6] }
[[obstacle]]
name = "press"
position = [0, 0, 0.2]
shape = { type = "rectangle", size = [1, 1], resolution = [6, 6] }
motion = { velocity = [0, 0, -0.5] }
)";
  Simulation simulation = simulate(text, {});
  const auto failure = simulation.advance(1);
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->kind, Failure::Kind::surfaces);
  EXPECT_NE(failure->text.find("particles \"ball\", number 0"), std::string::npos) << failure->text;
  EXPECT_NEAR(failure->time, (0.2 - 0.041) / 0.5, 0.01);
}

}  // namespace
}  // namespace weft::sim::particles_test
