// The strength of contact is per area, independent of the meshes; parting surfaces do not pull.
#include <cmath>
#include <numbers>
#include <random>

#include "materials/contact.h"
#include "sim/contact/contact.h"
#include "simulated_case.h"

namespace weft::sim::contact_strength_test {
namespace {

constexpr double range = 2e-3, thickness = 1e-3, size = 0.3;  // m

double push_per_area(const Scene& scene, double gap) {
  return -materials::barrier(gap, range, scene.source.contact.stiffness).first;
}

std::string number(double value) { return std::to_string(value); }

// A sheet of 0.3 m and another one of 0.6 m, a body or an obstacle, both in the plane z = 0. Tests
// raise the first.
std::string above_a(const std::string& kind, int sheet, int other) {
  return R"(
[time]
duration = 1
[material.cloth]
[[body]]
name = "sheet"
self_contact = false
thickness = 1e-3
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [)" +
         std::to_string(sheet) + ", " + std::to_string(sheet) + "] }\n[[" + kind + R"(]]
name = "other"
thickness = 1e-3
position = [0.01, 0.02, 0]
shape = { type = "rectangle", size = [0.6, 0.6], resolution = [)" +
         std::to_string(other) + ", " + std::to_string(other) + "] }\n" +
         (kind == "body" ? "self_contact = false\n" : "");
}

struct Extremes {
  double least = 1e9, most = -1e9;
  void add(double value) {
    least = std::min(least, value);
    most = std::max(most, value);
  }
};

// Returns the extremes of the normal force on the sheet at this gap, relative to that of its area,
// over random places and rotations in the plane.
Extremes strength(const Scene& scene, double gap, int trials) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> shift(-0.05, 0.05), angle(0, 2 * std::numbers::pi);
  Statistics statistics;
  Contact contact(scene, statistics);
  const SceneBody& sheet = scene.bodies[0];
  Extremes extremes;
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<Vec3> x = scene.initial_position;
    const Eigen::AngleAxisd turn(trial == 0 ? 0 : angle(random), Vec3::UnitZ());
    const Vec3 offset(shift(random), shift(random), thickness + gap);
    for (int i = 0; i < sheet.particle_count(); ++i) x[i] = turn * sheet.rest[i] + offset;
    const std::vector<Vec3> rest(x.size(), Vec3::Zero());
    EXPECT_FALSE(contact.evaluate(x, rest, 1));
    std::vector<Vec3> force(scene.dynamic_particles, Vec3::Zero());
    contact.add_forces(force);
    double sum = 0;
    for (int i = 0; i < sheet.particle_count(); ++i) sum += force[i].z();
    extremes.add(sum / (push_per_area(scene, gap) * size * size));
  }
  return extremes;
}

TEST(ContactStrength, IsThatOfTheAreaAboveEveryPlane) {
  for (int sheet : {7, 17, 65}) {
    for (int other : {3, 13, 49, 97, 201}) {
      const auto scene = build_scene(parse_case(above_a("obstacle", sheet, other), "test.toml"));
      for (double part : {0.25, 0.5, 0.75, 0.9}) {
        const Extremes found = strength(*scene, part * range, sheet * other > 3000 ? 2 : 20);
        EXPECT_NEAR(found.least, 1, 1e-9) << sheet << " " << other << " " << part;
        EXPECT_NEAR(found.most, 1, 1e-9) << sheet << " " << other << " " << part;
      }
    }
  }
}

// Each of two sheets counts half. The number of the lower one's vertices under the upper one
// depends on its place.
TEST(ContactStrength, IsThatOfTheAreaBetweenTwoSheets) {
  for (const auto& [sheet, other] : {std::pair(7, 13), std::pair(17, 33), std::pair(65, 129)}) {
    const auto scene = build_scene(parse_case(above_a("body", sheet, other), "test.toml"));
    for (double part : {0.25, 0.5, 0.9}) {
      const Extremes found = strength(*scene, part * range, sheet == 65 ? 8 : 100);
      EXPECT_GT(found.least, 0.9) << sheet << " " << part;
      EXPECT_LT(found.most, 1.1) << sheet << " " << part;
    }
  }
}

// A sheet follows a sphere or a cylinder at a constant gap, with cells of a twentieth of the
// radius.
TEST(ContactStrength, IsThatOfTheAreaOnCurvedObstacles) {
  constexpr double radius = 0.1, gap = 1e-3;
  for (const std::string shape : {"{ type = \"sphere\", radius = 0.1, resolution = [33] }",
                                  "{ type = \"cylinder\", radius = 0.1, length = 0.6, "
                                  "resolution = [121, 126] }"}) {
    const bool is_sphere = shape.find("sphere") != std::string::npos;
    const auto scene = build_scene(
        parse_case(above_a("obstacle", 33, 3), "test.toml",
                   {"obstacle.other.shape=" + shape, "body.sheet.shape.size=[0.12, 0.12]"}));
    const SceneBody& sheet = scene->bodies[0];
    Statistics statistics;
    Contact contact(*scene, statistics);
    std::vector<Vec3> x = scene->initial_position, outwards(x.size());
    const Vec3 centre(0.01, 0.02, 0);
    for (int i = 0; i < sheet.particle_count(); ++i) {
      const double u = sheet.rest[i].x() / radius, v = sheet.rest[i].y() / radius;
      outwards[i] = is_sphere
                        ? Vec3(std::sin(u), std::cos(u) * std::sin(v), std::cos(u) * std::cos(v))
                        : Vec3(std::sin(u), std::cos(u), 0);
      x[i] = centre + (radius + thickness + gap) * outwards[i];
      if (!is_sphere) x[i].z() += sheet.rest[i].y();
    }
    ASSERT_FALSE(contact.evaluate(x, std::vector<Vec3>(x.size(), Vec3::Zero()), 1));
    std::vector<Vec3> force(scene->dynamic_particles, Vec3::Zero());
    contact.add_forces(force);
    double sum = 0, area = 0;
    for (int i = 0; i < sheet.particle_count(); ++i) {
      sum += force[i].dot(outwards[i]);
      area += scene->contact_area[i];
    }
    EXPECT_NEAR(sum / (push_per_area(*scene, gap) * area), 1, 0.1) << shape;
  }
}

std::string plate_that_leaves(double gap, double speed) {
  return R"(
[time]
duration = 0.1
frames_per_second = 100
[world]
gravity = [0, 0, 0]
[material.cloth]
[[body]]
name = "sheet"
position = [0, 0, )" +
         number(thickness + gap) + R"(]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [7, 7] }
[[obstacle]]
name = "plate"
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [13, 13] }
[obstacle.motion]
velocity = [0, 0, )" +
         number(-speed) + "]\n";
}

// The barrier pushes the sheet away from a departing plate; nothing pulls it after the plate.
TEST(ContactStrength, APlateThatLeavesDoesNotDragASheetAlong) {
  for (double speed : {0.1, 0.5, 1.0, 2.0}) {
    for (double gap : {0.2e-3, 0.8e-3, 1.4e-3, 1.8e-3}) {
      SimulatedCase sim(plate_that_leaves(gap, speed));
      const std::vector<double> y = sim.advance_to(0.1);
      const StateView state = StateView::of(y);
      for (int i = 0; i < 49; ++i) {
        ASSERT_GT(state.velocity[i].z(), -1e-3) << speed << " " << gap;
        ASSERT_GT(state.position[i].z(), thickness + gap - 1e-4) << speed << " " << gap;
      }
    }
  }
}

// Two rotating sheets are pushed apart by the barrier from half the range. Momentum and angular
// momentum stay within the tolerances.
TEST(ContactStrength, FrictionKeepsAngularMomentum) {
  SimulatedCase sim(R"(
[time]
duration = 0.1
position_tolerance = 1e-7
relative_tolerance = 1e-6
[world]
gravity = [0, 0, 0]
[contact]
friction = 0.5
[material.cloth]
bending_stiffness = 1e-4
[[body]]
name = "lower"
angular_velocity_deg = [0, 0, 360]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [7, 7] }
[[body]]
name = "upper"
position = [0.02, 0.01, 0.002]
angular_velocity_deg = [0, 0, 90]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [9, 9] }
)");
  const auto momenta = [&](const std::vector<double>& y) {
    const StateView state = StateView::of(y);
    std::pair<Vec3, Vec3> sum{Vec3::Zero(), Vec3::Zero()};
    for (int i = 0; i < sim.scene().dynamic_particles; ++i) {
      sum.first += sim.scene().mass[i] * state.velocity[i];
      sum.second += sim.scene().mass[i] * state.position[i].cross(state.velocity[i]);
    }
    return sum;
  };
  const auto before = momenta(sim.advance_to(0));
  const auto after = momenta(sim.advance_to(0.1));
  EXPECT_GT(sim.statistics().counters.friction_terms, 0);
  EXPECT_LT((after.first - before.first).norm(), 5e-5 * 0.036);
  EXPECT_LT((after.second - before.second).norm(), 1e-4 * before.second.norm());
}

}  // namespace
}  // namespace weft::sim::contact_strength_test
