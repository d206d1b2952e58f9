// Free bodies that collide keep their momentum and their angular momentum.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/case/case_reader.h"
#include "sim/motion/dynamics.h"
#include "sim/run/make_simulation.h"
#include "sim/scene/scene.h"
#include "tests/robustness/varied_case.h"

namespace weft::robustness::free_collision_test {
namespace {

using sim::Vec3;

// Two sheets without gravity and air meet edge on and flat on, spinning, with friction.
const char* const two_sheets = R"(
[time]
duration = 0.06
velocity_tolerance = 1e-3
[world]
gravity = [0, 0, 0]
[contact]
range = 4e-3
friction = 0.3
[material.cloth]
density = 0.2
membrane_stiffness = 500
bending_stiffness = 1e-4
stiffness_damping = 1e-3
bending_damping = 1e-3
[[body]]
name = "one"
velocity = [0, 0, 1]
angular_velocity_deg = [0, 100, 40]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [9, 9] }
[[body]]
name = "other"
position = [0.05, 0.03, 0.03]
rotation_deg = [10, 8, 30]
velocity = [0.2, 0, -1]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [8, 8] }
)";

constexpr double velocity_tolerance = 1e-3;  // m/s, as in the case

struct Momenta {
  Vec3 linear{0, 0, 0}, angular{0, 0, 0};  // kg m/s, kg m^2/s about the origin
  double mass = 0;                         // kg
  double moment = 0;  // kg m, sum of the masses times distances from the origin
};

Momenta momenta(const sim::Simulation& simulation) {
  const sim::StateView view = sim::StateView::of(simulation.state());
  Momenta sum;
  for (std::size_t i = 0; i < view.position.size(); ++i) {
    const Vec3 p = simulation.scene().mass[i] * view.velocity[i];
    sum.linear += p;
    sum.angular += view.position[i].cross(p);
    sum.mass += simulation.scene().mass[i];
    sum.moment += simulation.scene().mass[i] * view.position[i].norm();
  }
  return sum;
}

TEST(FreeCollision, KeepsMomentumAndAngularMomentum) {
  const sim::Case source = sim::parse_case(two_sheets, "two_sheets.toml");
  for (std::uint32_t seed = 0; seed < 10; ++seed) {
    sim::Simulation simulation = sim::make_simulation(varied(source, seed));
    const Momenta start = momenta(simulation);
    std::size_t most_contacts = 0;
    while (simulation.time() < source.time.duration) {
      const auto failure = simulation.step();
      ASSERT_FALSE(failure) << failure->text;
      most_contacts = std::max(most_contacts, simulation.contact_pairs());
      const Momenta now = momenta(simulation);
      // The errors if every velocity errs by its tolerance in the same direction.
      ASSERT_LT((now.linear - start.linear).norm(), velocity_tolerance * now.mass) << seed;
      ASSERT_LT((now.angular - start.angular).norm(), velocity_tolerance * now.moment) << seed;
    }
    EXPECT_GT(most_contacts, 10U) << seed;
  }
}

}  // namespace
}  // namespace weft::robustness::free_collision_test
