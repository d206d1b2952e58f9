// A force that no case has: its own interface is all that the rest of sim/ needs to know.
#include <gtest/gtest.h>

#include "sim/integrator/integrator.h"
#include "sim/motion/energy_watch.h"
#include "sim/motion/external_work.h"
#include "sim/motion/work.h"
#include "tests/sim/simulated_case.h"

namespace weft::sim::made_up_force_test {
namespace {

// A bath that moves with the velocity w: F = -c (v - w) on every particle.
class Bath final : public Force {
 public:
  Bath(int particles, double coefficient, const Vec3& velocity)
      : particles_(particles), coefficient_(coefficient), velocity_(velocity) {}

  std::string_view name() const override { return "bath"; }
  bool has_damping() const override { return true; }
  bool is_external() const override { return true; }
  double evaluation_work() const override { return 7; }
  double energy(const Kinematics&, int) override { return 0; }
  void add_forces(const Kinematics& state, std::span<Vec3> force, int) override {
    for (int i = 0; i < particles_; ++i) force[i] -= coefficient_ * (state.velocity[i] - velocity_);
  }
  void add_couplings(std::vector<std::vector<int>>&) const override {}
  void attach(const BlockPattern& pattern) override { pattern_ = &pattern; }
  void add_derivatives(const Kinematics&, const Derivatives& into, Definiteness, int) override {
    BlockMatrix& matrix = into.is_joined() ? into.stiffness : *into.damping;
    const double scale = into.is_joined() ? into.inverse_gamma : 1;
    for (int i = 0; i < particles_; ++i) {
      matrix.upper_block(pattern_->upper_diagonal(i)).diagonal().array() += scale * coefficient_;
      if (into.is_joined()) into.product[i] += coefficient_ * into.along[i];
    }
  }

 private:
  int particles_;
  double coefficient_;
  Vec3 velocity_;
  const BlockPattern* pattern_ = nullptr;
};

constexpr const char* weightless = R"(
[time]
duration = 1
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[[body]]
name = "sheet"
velocity = [0, 0, 1]
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3] }
)";

struct InABath {
  InABath(const Overrides& overrides, double coefficient, const Vec3& velocity)
      : scene(build_scene(parse_case(weightless, "test.toml", overrides))),
        dynamics(*scene, statistics, forces_of(*scene, coefficient, velocity)) {}
  static std::vector<std::unique_ptr<Force>> forces_of(const Scene& scene, double coefficient,
                                                       const Vec3& velocity) {
    std::vector<std::unique_ptr<Force>> forces;
    forces.push_back(std::make_unique<Bath>(scene.dynamic_particles, coefficient, velocity));
    return forces;
  }
  std::unique_ptr<const Scene> scene;
  Statistics statistics;
  Dynamics dynamics;
};

// The velocity decays as exp(-c t / m) with every method that supports it; only the force knows
// that there is damping.
TEST(MadeUpForce, DampsByEveryMethod) {
  const double coefficient = 0.05;
  const std::vector<Overrides> methods{method("cvode", {"time.position_tolerance=1e-8"}),
                                       method("arkode", {"time.position_tolerance=1e-8"}),
                                       method("euler", {"time.step=1e-4"}),
                                       method("euler", {"time.step=1e-4", "time.newton=1"}),
                                       method("implicit_midpoint", {"time.step=0.01"}),
                                       method("verlet", {"time.step=1e-3"})};
  for (const Overrides& overrides : methods) {
    SCOPED_TRACE(overrides[0]);
    InABath bath(overrides, coefficient, Vec3::Zero());
    EXPECT_TRUE(bath.dynamics.has_damping());
    const auto integrator = make_integrator(*bath.scene, bath.dynamics);
    while (integrator->time() < 0.5) ASSERT_FALSE(integrator->step());
    std::vector<double> y(integrator->state().size());
    ASSERT_FALSE(integrator->state_at(0.5, y));
    const StateView state = StateView::of(y);
    for (int i = 0; i < bath.scene->dynamic_particles; ++i) {
      const double rate = coefficient / bath.scene->mass[i];
      EXPECT_NEAR(state.velocity[i].z(), std::exp(-0.5 * rate), 2e-3) << i;
      EXPECT_NEAR(state.position[i].z(), (1 - std::exp(-0.5 * rate)) / rate, 2e-3) << i;
    }
  }
}

// A moving bath drives the sheet; the watch counts its work and reports nothing.
TEST(MadeUpForce, DoesWorkThatTheWatchCounts) {
  InABath bath({"world.wind=[5,0,0]", "time.method=cvode"}, 0.05, Vec3(5, 0, 0));
  EXPECT_TRUE(bath.dynamics.has_external_forces());
  EXPECT_EQ(bath.dynamics.evaluation_work(), 7);
  const auto integrator = make_integrator(*bath.scene, bath.dynamics);
  EnergyWatch watch(bath.dynamics, integrator->state());
  while (integrator->time() < 0.5) {
    ASSERT_FALSE(integrator->step());
    const double now = integrator->time();
    const Energies energies = bath.dynamics.energies(now, integrator->state());
    const auto failure = watch.check(now, integrator->state(), energies);
    ASSERT_FALSE(failure) << failure->text;
  }
  double gained = 0;
  const StateView state = StateView::of(integrator->state());
  for (int i = 0; i < bath.scene->dynamic_particles; ++i)
    gained += 0.5 * bath.scene->mass[i] * (state.velocity[i].squaredNorm() - 1);
  EXPECT_NEAR(watch.external().work(), gained, 0.01 * gained);
}

}  // namespace
}  // namespace weft::sim::made_up_force_test
