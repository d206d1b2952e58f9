// Collisions of bodies that nothing holds keep their momentum, by steps of given length.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/sim/simulated_case.h"

namespace weft::sim::collision_momentum_test {
namespace {

// A ball that flies onto a sheet of a third of its mass, which nothing holds.
const std::string hit_sheet = R"(
[time]
duration = 0.1
[world]
gravity = [0, 0, 0]
[material.silk]
density = 0.2
membrane_stiffness = 500
stiffness_damping = 1e-3
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [9, 9] }
[[particles]]
name = "ball"
radius = 0.03
density = 500
velocity = [0, 0, -1]
positions = { type = "grid", count = [1, 1, 1], centre = [0.02, 0.03, 0.05] }
)";

// A ball that flies onto eight others.
const std::string hit_balls = R"(
[time]
duration = 0.1
[world]
gravity = [0, 0, 0]
[[particles]]
name = "one"
radius = 0.03
velocity = [0, 0, -1]
positions = { type = "grid", count = [1, 1, 1], centre = [0.01, 0.005, 0.1] }
[[particles]]
name = "eight"
radius = 0.03
density = 3000
positions = { type = "grid", count = [2, 2, 2], spacing = 0.065 }
)";

// The momentum (kg m/s) of sheets and spheres, without spins.
Vec3 momentum_of(const Scene& scene, std::span<const double> y) {
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < scene.heavy_particles; ++i)
    sum += scene.mass[i] * StateView::of(y).velocity[i];
  return sum;
}

// Returns the largest change of the momentum in a run by `euler`, as a part of that at the start.
// Runs whose corrections converge must not gain energy, not even in a barrier.
double lost_momentum(const std::string& text, const Overrides& more) {
  SimulatedCase sim(text, method("euler", more));
  Integrator& integrator = sim.integrator();
  const Vec3 before = momentum_of(sim.scene(), integrator.state());
  const Energies first = sim.dynamics().energies(0, integrator.state());
  double largest = 0;
  while (integrator.time() < 0.1) {
    if (const auto failure = integrator.step()) {
      ADD_FAILURE() << failure->text;
      break;
    }
    const Vec3 now = momentum_of(sim.scene(), integrator.state());
    largest = std::max(largest, (now - before).norm() / before.norm());
    if (sim.scene().source.time.newton > 0) continue;
    const Energies energies = sim.dynamics().energies(integrator.time(), integrator.state());
    EXPECT_LT(energies.total(), 1.001 * first.total()) << integrator.time();
  }
  // The collision was not missed.
  EXPECT_LT(sim.dynamics().energies(integrator.time(), integrator.state()).kinetic,
            0.9 * first.kinetic);
  return largest;
}

// Iterations go on where the last correction was small, but large beside a gap.
TEST(CollisionMomentum, IsKeptByStepsOfGivenLength) {
  for (const double step : {1e-3, 4e-3}) {
    for (const char* friction : {"contact.friction=0", "contact.friction=0.3"})
      EXPECT_LT(lost_momentum(hit_sheet, {key("step", step), friction}), 2e-3) << step << friction;
  }
  EXPECT_LT(lost_momentum(hit_balls, {key("step", 1e-2)}), 2e-3);
}

// Bodies in contact are moved together, so that a single correction takes what is left of their
// momentum.
TEST(CollisionMomentum, IsKeptBySingleCorrections) {
  for (const double step : {1e-3, 2e-3, 5e-3}) {
    for (const char* friction : {"contact.friction=0", "contact.friction=0.3"}) {
      const Overrides options{key("step", step), friction, "time.newton=1"};
      EXPECT_LT(lost_momentum(hit_sheet, options), 1e-9) << step << friction;
      EXPECT_LT(lost_momentum(hit_balls, options), 1e-9) << step << friction;
    }
  }
}

}  // namespace
}  // namespace weft::sim::collision_momentum_test
