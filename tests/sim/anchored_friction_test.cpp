// Contacts that stick to anchors: no creep, Coulomb's law where they slide, and histories that
// survive checkpoints.
#include <cmath>
#include <numbers>
#include <random>

#include "materials/contact.h"
#include "sim/contact/anchors.h"
#include "sim/contact/contact.h"
#include "sim/run/make_simulation.h"
#include "sim/simulation/simulation.h"
#include "tests/sim/simulated_case.h"

namespace weft::sim::anchored_friction_test {
namespace {

constexpr double g = 9.81;
constexpr double distance = 1e-4;  // m, contact.sticking_distance

// Returns the height (m) of a sheet at rest on a floor, both of the thickness 1e-3 m, under its
// weight times `part`.
double height_at_rest(double part) {
  constexpr double range = 2e-3, stiffness = 1e6, density = 0.2;
  double low = 1e-9 * range, high = range;
  for (int i = 0; i < 100; ++i) {
    const double gap = 0.5 * (low + high);
    (-materials::barrier(gap, range, stiffness).first > part * density * g ? low : high) = gap;
  }
  return 1e-3 + low;
}

std::string text_of(double number) {
  std::ostringstream text;
  text.precision(17);
  text << number;
  return text.str();
}

// A sheet on a floor. Gravity is inclined by `angle`, so that the floor is a slope down along x.
std::string sheet_on_floor(double angle, double friction, double speed = 0) {
  return "[time]\nduration = 10\nposition_tolerance = 1e-6\n[world]\ngravity = [" +
         text_of(g * std::sin(angle)) + ", 0, " + text_of(-g * std::cos(angle)) +
         "]\n[contact]\nfriction_speed = 2e-3\nsticking_distance = " + text_of(distance) +
         "\nfriction = " + text_of(friction) +
         "\n[material.cloth]\nstiffness_damping = 1e-3\n[[body]]\nname = \"sheet\"\n"
         "position = [-1, 0, " +
         text_of(height_at_rest(std::cos(angle))) + "]\nvelocity = [" + text_of(speed) +
         ", 0, 0]\nshape = { type = \"rectangle\", size = [0.2, 0.2], resolution = [4, 4] }\n"
         "[[obstacle]]\nname = \"floor\"\n"
         "shape = { type = \"rectangle\", size = [3, 0.8], resolution = [7, 5] }\n";
}

double mean_x(const SimulatedCase& sim, const std::vector<Vec3>& values, int body = 0) {
  const SceneBody& of = sim.scene().bodies[body];
  double sum = 0;
  for (int i = 0; i < of.particle_count(); ++i) sum += values[of.first_particle + i].x();
  return sum / of.particle_count();
}

double mean_speed(SimulatedCase& sim, double time) {
  std::vector<Vec3> position, velocity;
  sim.dynamics().expand_all(time, sim.advance_to(time), position, velocity);
  return mean_x(sim, velocity);
}

constexpr double slope_angle = 20 * std::numbers::pi / 180;

// The force of a spring that has given way by r times the distance is mu P (2 r - r^2).
TEST(AnchoredFriction, SheetsRestOnASlopeWithoutCreep) {
  const double slope = std::tan(slope_angle);
  for (const double friction : {1.1 * slope, 2 * slope}) {
    SimulatedCase sim(sheet_on_floor(slope_angle, friction));
    const double start = mean_x(sim, sim.positions_at(0)), early = mean_x(sim, sim.positions_at(1));
    const double late = mean_x(sim, sim.positions_at(3));
    EXPECT_LT(std::abs(late - early), 1e-3 * distance) << friction;
    EXPECT_LT(late - start, 3 * distance) << friction;
  }
}

// A sheet at rest is pulled along a floor by less than its friction: its springs give way as their
// law says, and spring back.
TEST(AnchoredFriction, SpringsGiveWayByTheLawAndSpringBack) {
  constexpr double friction = 0.5, pull = 0.3;  // parts of the weight
  SimulatedCase sim(
      sheet_on_floor(0, friction),
      {"world.gravity={ times = [0, 0.5, 0.8, 1.5, 1.8], between = \"linear\", "
       "values = [[0, 0, -9.81], [0, 0, -9.81], [" +
       text_of(pull * g) + ", 0, -9.81], [" + text_of(pull * g) + ", 0, -9.81], [0, 0, -9.81]] }"});
  const double rest = mean_x(sim, sim.positions_at(0.5));
  const double pulled = mean_x(sim, sim.positions_at(1.5));
  const double back = mean_x(sim, sim.positions_at(2.5));
  EXPECT_NEAR((pulled - rest) / distance, 1 - std::sqrt(1 - pull / friction), 0.01);
  EXPECT_NEAR(back, rest, 2e-3 * distance);
}

TEST(AnchoredFriction, SheetsSlideByCoulombsLaw) {
  for (const double part : {0.5, 0.98}) {
    const double friction = part * std::tan(slope_angle);
    SimulatedCase sim(sheet_on_floor(slope_angle, friction));
    const double early = mean_speed(sim, 0.1), late = mean_speed(sim, 0.3);
    const double exact = g * (std::sin(slope_angle) - friction * std::cos(slope_angle));
    EXPECT_NEAR((late - early) / 0.2 / exact, 1, 0.01) << part;
  }
  constexpr double speed = 0.6, friction = 0.4;
  SimulatedCase sim(sheet_on_floor(0, friction, speed));
  const double start = mean_x(sim, sim.positions_at(0)), end = mean_x(sim, sim.positions_at(0.4));
  EXPECT_NEAR((end - start) / (speed * speed / (2 * friction * g)), 1, 0.01);
  EXPECT_NEAR(mean_x(sim, sim.positions_at(0.8)), end, 1e-2 * distance);
}

Overrides preview_by(const std::string& step) {
  return {"time.method=\"euler\"", "time.newton=1", "time.step=" + step,
          "contact.friction_speed=0.01"};
}

// The anchor of a sheet that slides is dragged along at the end of each step. A single correction
// must not count on the spring that would grow within the step: it made friction half as large
// again here.
TEST(AnchoredFriction, PreviewsSlideByCoulombsLaw) {
  const double friction = 0.5 * std::tan(slope_angle);
  SimulatedCase sim(sheet_on_floor(slope_angle, friction), preview_by("5e-3"));
  const double early = mean_speed(sim, 0.1), late = mean_speed(sim, 0.3);
  const double exact = g * (std::sin(slope_angle) - friction * std::cos(slope_angle));
  EXPECT_NEAR((late - early) / 0.2 / exact, 1, 0.03);
}

// A floor, or a sheet that two pins hold, that moves at once with the speed v = 0.5 m/s carries a
// sheet along. It slides back by v^2 / (2 mu g) until it sticks, and never outruns the floor.
TEST(AnchoredFriction, PreviewsSlideBackUntilTheyStickToWhatMoves) {
  const std::string motion = "motion = { velocity = [0.5, 0, 0] }";
  const std::string belt =
      std::string("[[body]]\nname = \"belt\"\n") +
      "shape = { type = \"rectangle\", size = [3, 0.8], resolution = [7, 5] }\n" +
      "pin = [{ rows = [0, 2], " + motion + " }, { rows = [3, 4], " + motion + " }]\n";
  const std::string on_floor = sheet_on_floor(0, 0.5);
  const std::string on_belt = on_floor.substr(0, on_floor.find("[[obstacle]]")) + belt;
  const double back = 0.5 * 0.5 / (2 * 0.5 * g);
  for (const std::string& text : {on_floor + motion + "\n", on_belt}) {
    for (const char* step : {"5e-3", "0.016"}) {
      SimulatedCase sim(text, preview_by(step));
      const double start = mean_x(sim, sim.positions_at(0));
      const auto lag = [&](double time) {
        return 0.5 * time - (mean_x(sim, sim.positions_at(time)) - start);
      };
      const double early = lag(0.4), late = lag(0.8);
      EXPECT_NEAR(late, back, (text == on_belt ? 0.3 : 0.1) * back) << step;
      EXPECT_NEAR(late, early, 1e-3) << step;
    }
  }
}

// A floor that accelerates by less than mu g carries a sheet along. Its friction is that of a
// secant, so that it lags by some millimetres of a metre.
TEST(AnchoredFriction, PreviewsFollowAFloorThatStartsGently) {
  for (const char* step : {"5e-3", "0.016"}) {
    SimulatedCase sim(sheet_on_floor(0, 0.8) +
                          "motion = { keyframes = [{ time = 0, translation = [0, 0, 0] },"
                          "{ time = 1, translation = [1, 0, 0] }] }\n",
                      preview_by(step));
    const double start = mean_x(sim, sim.positions_at(0));
    for (const double t : {0.25, 0.5, 0.75, 1.0}) {
      const double way = t * t * t * (10 - 15 * t + 6 * t * t);
      EXPECT_NEAR(mean_x(sim, sim.positions_at(t)) - start, way, 0.01) << step << " s, t = " << t;
    }
  }
}

// A sheet that rides on another one, which slides without friction, stays where it lies.
TEST(AnchoredFriction, PreviewsRideOnBodiesWithoutSliding) {
  SimulatedCase sim(
      sheet_on_floor(0, 0, 0.5) +
          "[[contact.pair]]\nbetween = [\"sheet\", \"rider\"]\nfriction = 0.5\n"
          "[[body]]\nname = \"rider\"\nvelocity = [0.5, 0, 0]\nposition = [-1, 0, " +
          text_of(2 * height_at_rest(1)) +
          "]\nshape = { type = \"rectangle\", size = [0.1, 0.1], resolution = [4, 4] }\n",
      preview_by("5e-3"));
  const auto ahead = [&](double time) {
    const std::vector<Vec3> position = sim.positions_at(time);
    return mean_x(sim, position, 1) - mean_x(sim, position, 0);
  };
  const double start = ahead(0);
  EXPECT_NEAR(ahead(0.5), start, 0.1 * distance);
}

// A plate that turns carries a sheet along, with its anchors: after one turn the sheet lies where
// it lay on the plate.
TEST(AnchoredFriction, AnchorsMoveWithTheirSurface) {
  const std::string plate =
      sheet_on_floor(0, 0.8) +
      "motion = { angular_velocity_deg = [0, 0, 180], centre = [-0.9, 0, 0] }\n";
  for (const Overrides& overrides : {Overrides{}, preview_by("5e-3")}) {
    SimulatedCase sim(plate, overrides);
    const std::vector<Vec3> early = sim.positions_at(1), late = sim.positions_at(3);
    for (int i = 0; i < sim.scene().dynamic_particles; ++i)
      EXPECT_LT((late[i] - early[i]).norm(), 0.05 * distance) << i << ", " << overrides.size();
  }
}

// Particles that do not turn have a friction of their own, and stick by the same anchors.
TEST(AnchoredFriction, ParticlesRestOnASlope) {
  Case source = parse_case(
      "[time]\nduration = 2\n[world]\ngravity = [" + text_of(g * std::sin(slope_angle)) + ", 0, " +
          text_of(-g * std::cos(slope_angle)) +
          "]\n[contact]\nsticking_distance = " + text_of(distance) +
          "\n[[particles]]\nname = \"ball\"\nradius = 0.02\nfriction = 0.6\nrestitution = 0\nspin "
          "= false\n"
          "positions = { type = \"grid\", count = [1, 1, 1], centre = [0, 0, 0.0225] }\n"
          "[[obstacle]]\nname = \"floor\"\nshape = { type = \"plane\", size = [3, 3] }\n",
      "test.toml");
  Simulation simulation = make_simulation(source);
  ASSERT_FALSE(simulation.advance(1));
  const double early = simulation.position("ball")[0].x();
  ASSERT_FALSE(simulation.advance(1));
  EXPECT_LT(std::abs(simulation.position("ball")[0].x() - early), 0.01 * distance);
}

// Contact of a sheet and a floor, with all samples in reach and anchors off their feet by up to the
// distance.
struct AnchoredContact {
  AnchoredContact()
      : scene(build_scene(parse_case(sheet_on_floor(0, 0.5), "test.toml"))),
        contact(*scene, statistics),
        position(scene->initial_position),
        velocity(scene->particle_count, Vec3::Zero()) {
    for (int i = 0; i < scene->dynamic_particles; ++i) position[i].z() = 1.8e-3;
    contact.use_anchors(history);
    EXPECT_FALSE(contact.evaluate(position, velocity, 1));
    contact.advance_anchors(history.at_end());
    for (int i = 0; i < scene->dynamic_particles; ++i) {
      position[i] += 0.5 * distance * Vec3(std::sin(i), std::cos(3 * i), 0.1 * std::sin(2 * i));
      velocity[i] = 1e-3 * Vec3(std::cos(2 * i), std::sin(i), 0);
    }
  }
  std::vector<Vec3> forces(std::span<const Vec3> at) {
    EXPECT_FALSE(contact.evaluate(at, velocity, 1));
    std::vector<Vec3> force(scene->dynamic_particles, Vec3::Zero());
    contact.add_forces(force);
    return force;
  }

  std::shared_ptr<const Scene> scene;
  Statistics statistics;
  Contact contact;
  AnchorHistory history;
  std::vector<Vec3> position, velocity;
};

TEST(AnchoredFriction, StiffnessIsTheSlopeOfTheForceAlongTheSurface) {
  AnchoredContact anchored;
  const int count = anchored.scene->dynamic_particles;
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::vector<Vec3> along(count);
  for (Vec3& d : along) d = Vec3(normal(random), normal(random), 0);
  constexpr double step = 1e-9;
  std::vector<Vec3> ahead = anchored.position, behind = anchored.position;
  for (int i = 0; i < count; ++i) {
    ahead[i] += step * along[i];
    behind[i] -= step * along[i];
  }
  const std::vector<Vec3> above = anchored.forces(ahead), below = anchored.forces(behind);
  ASSERT_FALSE(anchored.contact.evaluate(anchored.position, anchored.velocity, 1));
  std::vector<Vec3> stiffness(count, Vec3::Zero());
  anchored.contact.subtract_stiffness(-1, along, stiffness);
  double difference = 0, size = 0;
  for (int i = 0; i < count; ++i) {
    const Vec3 slope = -(above[i] - below[i]) / (2 * step);
    difference += (slope - stiffness[i]).head<2>().squaredNorm();
    size += slope.head<2>().squaredNorm();
  }
  ASSERT_GT(size, 0);
  EXPECT_LT(std::sqrt(difference / size), 1e-5);
}

TEST(AnchoredFriction, TheFormsOfTheMatrixAgree) {
  AnchoredContact anchored;
  const Contact& contact = anchored.contact;
  anchored.forces(anchored.position);
  const int count = anchored.scene->dynamic_particles;
  std::vector<Vec3> direction(count);
  for (int i = 0; i < count; ++i) direction[i] = Vec3(std::sin(i), std::cos(i), std::sin(3 * i));
  const auto product_at = [&](double gamma) {
    std::vector<Vec3> product(count, Vec3::Zero());
    contact.add_product(gamma, direction, product);
    return product;
  };
  const double gamma = 0.01;
  const std::vector<Vec3> product = product_at(gamma), whole = product_at(1);
  std::vector<Vec3> stiffness(count, Vec3::Zero()), by_blocks = stiffness;
  contact.subtract_stiffness(-1, direction, stiffness);
  std::vector<Mat3> diagonal(count, Mat3::Zero()), diagonal_blocks = diagonal, definite = diagonal;
  contact.add_diagonal(gamma, diagonal);
  contact.visit_blocks(gamma, [&](int row, int column, const Mat3& block) {
    by_blocks[row] += block * direction[column];
    if (row == column) diagonal_blocks[row] += block;
  });
  contact.visit_definite_couplings(gamma, [&](const Contact::Coupling& coupling) {
    for (std::size_t k = 0; k < coupling.particles.size(); ++k) {
      if (coupling.particles[k] < count)
        definite[coupling.particles[k]] +=
            coupling.weights[k] * coupling.weights[k] * coupling.block;
    }
  });
  double size = 0;
  for (const Vec3& each : product) size = std::max(size, each.norm());
  for (int i = 0; i < count; ++i) {
    const Vec3 damping = whole[i] - stiffness[i];
    EXPECT_LT((product[i] - gamma * (gamma * stiffness[i] + damping)).norm(), 1e-12 * size) << i;
    EXPECT_LT((product[i] - by_blocks[i]).norm(), 1e-12 * size) << i;
    EXPECT_LT((diagonal[i] - diagonal_blocks[i]).norm(), 1e-12 * diagonal[i].norm()) << i;
    EXPECT_LT((diagonal[i] - definite[i]).norm(), 1e-12 * diagonal[i].norm()) << i;
  }
}

// Two sheets that slide over each other exchange momentum and angular momentum alone.
TEST(AnchoredFriction, BetweenBodiesKeepsMomentumAndAngularMomentum) {
  SimulatedCase sim(R"(
[time]
duration = 1
velocity_tolerance = 1e-4
[world]
gravity = [0, 0, 0]
[contact]
friction = 0.6
sticking_distance = 2e-4
[material.cloth]
stiffness_damping = 1e-3
[[body]]
name = "one"
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [5, 5] }
velocity = [0, 0, 0.3]
[[body]]
name = "other"
position = [0.03, 0.01, 0.004]
rotation_deg = [0, 0, 20]
velocity = [0.2, 0, -0.3]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [6, 6] }
)");
  const auto momenta = [&](double time) {
    std::vector<Vec3> position, velocity;
    sim.dynamics().expand_all(time, sim.advance_to(time), position, velocity);
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
    for (std::size_t i = 0; i < position.size(); ++i) {
      linear += sim.scene().mass[i] * velocity[i];
      angular += sim.scene().mass[i] * position[i].cross(velocity[i]);
    }
    return std::pair(linear, angular);
  };
  const auto [linear, angular] = momenta(0);
  const auto [linear_end, angular_end] = momenta(0.1);
  const double mass = 2 * 0.2 * 0.2 * 0.2;  // kg
  EXPECT_LT((linear_end - linear).norm(), 1e-4 * mass);
  EXPECT_LT((angular_end - angular).norm(), 1e-4 * mass * 0.2);
}

// Runs that go on from what another has saved, and runs by two threads, have the same bits.
TEST(AnchoredFriction, SavedRunsGoOnWithTheSameBits) {
  const std::string text = sheet_on_floor(slope_angle, 0.38);
  for (const Overrides& overrides :
       {Overrides{}, Overrides{"time.method=\"euler\"", "time.step=0.002"}}) {
    const auto simulation = [&](Overrides more) {
      more.insert(more.end(), overrides.begin(), overrides.end());
      return make_simulation(parse_case(text, "test.toml", more));
    };
    const auto take = [](Simulation& sim, int steps) {
      for (int i = 0; i < steps; ++i) ASSERT_FALSE(sim.step());
    };
    Simulation whole = simulation({}), restored = simulation({}),
               threads = simulation({"compute.threads=2"});
    for (Simulation* sim : {&whole, &threads}) take(*sim, 12);
    // A run by CVODE begins anew where it is saved.
    for (Simulation* sim : {&threads, &whole})
      restored.restore(overrides.empty() ? sim->renew() : sim->save());
    for (Simulation* sim : {&whole, &threads, &restored}) take(*sim, 40);
    EXPECT_EQ(restored.position("sheet"), whole.position("sheet"));
    EXPECT_EQ(threads.position("sheet"), whole.position("sheet"));
  }
}

// The forces at a time within the last step follow from the anchors at its start.
TEST(AnchoredFriction, ForcesWithinAStepFollowFromTheAnchorsAtItsStart) {
  SimulatedCase sim(sheet_on_floor(0, 0.4, 0.1));
  sim.advance_to(0.01);
  const double time = sim.integrator().time();
  // At rest, friction depends on the anchors alone.
  std::vector<double> y(sim.integrator().state().begin(), sim.integrator().state().end());
  std::fill(y.begin() + static_cast<std::ptrdiff_t>(y.size() / 2), y.end(), 0.0);
  const auto rate_at = [&](double when) {
    std::vector<double> rate(y.size());
    EXPECT_FALSE(sim.dynamics().rate(when, y, rate));
    return rate;
  };
  const std::vector<double> before = rate_at(time);
  ASSERT_FALSE(sim.integrator().step());
  EXPECT_EQ(rate_at(time), before);
  EXPECT_NE(rate_at(sim.integrator().time()), before);
}

// A foot in the triangle (0,0), (1,0), (0,1) of the plane z = 0, at (0.2, 0.3).
Footing foot() {
  return {.corners = {4, 5, 6},
          .weights = {0.5, 0.2, 0.3},
          .x = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)},
          .normal = Vec3::UnitZ()};
}

TEST(Anchors, StayUntilTheyAreDraggedAlong) {
  const AnchorKey key{0, 3, 1};
  const Anchor fresh = advanced_anchor(key, nullptr, Vec3(9, 9, 9), foot(), 0.1);
  EXPECT_EQ(fresh.corners, foot().corners);
  EXPECT_EQ(fresh.weights, foot().weights);
  const Anchor old{key, {7, 8, 9}, {1, 0, 0}};
  // The part of the offset along the normal does not count.
  const Anchor kept = advanced_anchor(key, &old, Vec3(0.06, 0.07, 5), foot(), 0.1);
  EXPECT_EQ(kept.corners, old.corners);
  EXPECT_EQ(kept.weights, old.weights);
  // The sample is over the foot, the anchor behind it by the distance.
  const Anchor dragged = advanced_anchor(key, &old, Vec3(0.3, -0.4, 5), foot(), 0.1);
  EXPECT_EQ(dragged.corners, foot().corners);
  EXPECT_NEAR(dragged.weights[1], 0.2 - 0.06, 1e-15);
  EXPECT_NEAR(dragged.weights[2], 0.3 + 0.08, 1e-15);
  EXPECT_NEAR(dragged.weights[0] + dragged.weights[1] + dragged.weights[2], 1, 1e-15);
}

TEST(Anchors, OfAnotherSceneAreRefused) {
  const auto scene = build_scene(parse_case(sheet_on_floor(0, 0.5), "test.toml"));
  const auto read = [&](Anchors anchors) {
    StateArchive written;
    transfer(written, anchors, *scene);
    const std::string bytes = written.bytes();
    StateArchive archive(bytes);
    Anchors result;
    transfer(archive, result, *scene);
    return result.size();
  };
  const Anchor good{{0, 15, 1}, {0, 7, 8}, {0.5, 0.25, 0.25}};
  EXPECT_EQ(read({good}), 1U);
  Anchor point = good, corner = good, body = good;
  point.key.point = 16;
  corner.corners[2] = 35;
  body.key.surface = 2;
  for (const Anchor& bad : {point, corner, body}) EXPECT_THROW(read({bad}), std::invalid_argument);
  EXPECT_THROW(read({good, good, point}), std::invalid_argument);
  Anchor earlier = good;
  earlier.key.point = 3;
  EXPECT_THROW(read({good, earlier}), std::invalid_argument);
}

}  // namespace
}  // namespace weft::sim::anchored_friction_test
