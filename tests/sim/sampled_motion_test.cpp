// Bodies with sampled surfaces in motion: they land, keep their momentum, and are carried by pins.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "sim/motion/motion_limits.h"
#include "sim/motion/prescribed_paths.h"
#include "tests/sim/sampled_scene.h"

namespace weft::sim::sampled_motion_test {
namespace {

// A sampled scene with its integrator.
class SampledRun {
 public:
  explicit SampledRun(const Scene& scene)
      : scene_(scene),
        dynamics_(scene, statistics_),
        integrator_(make_integrator(scene, dynamics_)) {}

  // Returns the text of a failure, if there is one before `time`.
  std::string run_until(double time) {
    while (integrator_->time() < time) {
      if (const auto failure = integrator_->step()) return failure->text;
      smallest_gap = std::min(smallest_gap, dynamics_.contact()->smallest_gap().value_or(1));
    }
    return "";
  }
  double time() const { return integrator_->time(); }
  StateView state() const { return StateView::of(integrator_->state()); }
  std::vector<Vec3> positions() const {
    std::vector<Vec3> position, velocity;
    dynamics_.expand_all(integrator_->time(), integrator_->state(), position, velocity);
    return position;
  }
  std::vector<double> numbers() const {
    return {integrator_->state().begin(), integrator_->state().end()};
  }
  // Returns the number of pairs of triangles of the surfaces that pass through each other.
  int surface_crossings() const {
    std::vector<Vec3> room;
    const std::vector<Vec3> particles = positions();
    const auto points = scene_.surface_map.points_of(particles, scene_.point_count, room);
    std::vector<CrossingSurface> surfaces;
    for (const SceneBody& body : scene_.bodies) {
      surfaces.push_back({points.subspan(body.first_point, body.point_count()),
                          body.surface_mesh().triangles, body.dynamic});
    }
    return static_cast<int>(find_crossings(surfaces).size());
  }

  double smallest_gap = 1;  // m, after steps

 private:
  const Scene& scene_;
  Statistics statistics_;
  Dynamics dynamics_;
  std::unique_ptr<Integrator> integrator_;
};

constexpr const char* sheet_on_ball = R"(
[time]
duration = 1
[contact]
range = 0.01
friction = 0.2
[material.cloth]
bending_stiffness = 1e-4
stiffness_damping = 1e-3
[[body]]
name = "sheet"
position = [0.03, 0.02, 0.03]
thickness = 0.001
velocity = [0, 0, -0.3]
shape = { type = "rectangle", size = [0.8, 0.8], resolution = [7, 7] }
[[obstacle]]
name = "ball"
position = [0, 0, -0.3]
thickness = 0.001
shape = { type = "sphere", radius = 0.3, resolution = [7] }
)";

std::vector<Overrides> solvers() {
  return {method("cvode"), method("cvode", {"time.preconditioner=\"multigrid\""}),
          method("euler", {"time.preconditioner=\"multigrid\""}),
          method("euler", {"time.preconditioner=\"block_jacobi\""}), method("arkode")};
}

TEST(SampledMotion, ARefinedSheetLandsOnAnObstacle) {
  for (const Overrides& by : solvers()) {
    SCOPED_TRACE(by.front() + " " + by.back());
    const SampledScene sampled(sheet_on_ball, by, refined_surface);
    SampledRun run(sampled.scene());
    ASSERT_EQ(run.run_until(0.25), "");
    EXPECT_EQ(run.surface_crossings(), 0);
    EXPECT_GT(run.smallest_gap, 0);
    EXPECT_LT(run.smallest_gap, 0.008);
    // Its middle lies on the ball, while its corners hang down.
    EXPECT_GT(run.state().position[24].z(), 0);
    EXPECT_LT(run.state().position[0].z(), -0.1);
  }
}

constexpr const char* colliding_sheets = R"(
[time]
duration = 1
[world]
gravity = [0, 0, 0]
[contact]
range = 0.01
friction = 0.3
[material.cloth]
bending_stiffness = 1e-4
[[body]]
name = "first"
velocity = [0.1, 0, 0.4]
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [6, 7] }
[[body]]
name = "second"
position = [0.06, 0.05, 0.03]
rotation_deg = [4, 2, 30]
shape = { type = "rectangle", size = [0.4, 0.6], resolution = [5, 6] }
)";

struct Momentum {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
};

Momentum momentum(const Scene& scene, const StateView& state, int body) {
  Momentum sum;
  const SceneBody& of = scene.bodies[body];
  for (int i = of.first_particle; i < of.first_particle + of.particle_count(); ++i) {
    sum.linear += scene.mass[i] * state.velocity[i];
    sum.angular += scene.mass[i] * state.position[i].cross(state.velocity[i]);
  }
  return sum;
}

TEST(SampledMotion, RefinedSheetsThatCollideKeepTheirMomentum) {
  const std::string exact = "time.position_tolerance=1e-8";
  for (const Overrides& by :
       {method("cvode", {exact}), method("cvode", {exact, "time.preconditioner=\"multigrid\""}),
        method("euler", {"time.step=0.001"})}) {
    SCOPED_TRACE(by.front() + " " + by.back());
    // One sheet has a finer surface; the points of the other are its particles.
    const SampledScene sampled(colliding_sheets, by, refined_surface,
                               [](const SceneBody& body) { return body.name == "first"; });
    SampledRun run(sampled.scene());
    const auto of = [&](int body) { return momentum(sampled.scene(), run.state(), body); };
    const Momentum first = of(0), second = of(1);
    ASSERT_EQ(run.run_until(0.2), "");
    EXPECT_LT(run.smallest_gap, 0.01);
    EXPECT_EQ(run.surface_crossings(), 0);
    const double size = first.linear.norm();
    EXPECT_GT((of(1).linear - second.linear).norm(), 0.2 * size);
    // The tolerances leave some error.
    EXPECT_LT((of(0).linear + of(1).linear - first.linear - second.linear).norm(), 5e-4 * size);
    // Backward Euler does not keep angular momentum by itself.
    if (by.front() == method("cvode").front()) {
      EXPECT_LT((of(0).angular + of(1).angular - first.angular - second.angular).norm(),
                1e-3 * size);
    }
  }
}

TEST(SampledMotion, AnExplicitMapOfSingleParticlesGivesTheSameTrajectory) {
  for (const Overrides& by : solvers()) {
    SCOPED_TRACE(by.front() + " " + by.back());
    const SampledScene sampled(sheet_on_ball, by, own_surface);
    SampledRun by_map(sampled.scene()), by_identity(sampled.plain());
    ASSERT_EQ(by_map.run_until(0.15), "");
    ASSERT_EQ(by_identity.run_until(0.15), "");
    EXPECT_LT(by_identity.smallest_gap, 0.01);
    EXPECT_EQ(by_map.time(), by_identity.time());
    EXPECT_EQ(by_map.numbers(), by_identity.numbers());
  }
}

TEST(SampledMotion, AMovingObstacleMeetsARefinedSheet) {
  for (const Overrides& by : {method("cvode"), method("euler", {"time.step=0.05"})}) {
    SCOPED_TRACE(by.front());
    Overrides coarser = by;
    coarser.emplace_back("body.sheet.shape.resolution=[7, 7]");
    const SampledScene sampled(there_and_back, coarser, refined_surface);
    SampledRun run(sampled.scene());
    ASSERT_EQ(run.run_until(0.47), "");
    EXPECT_EQ(run.surface_crossings(), 0);
    EXPECT_LT(run.smallest_gap, sampled.scene().source.contact.range);
    double lowest = 0;
    for (const Vec3& x : run.state().position) lowest = std::min(lowest, x.z());
    EXPECT_LT(lowest, -0.05);  // the ball has taken the sheet along
  }
}

TEST(SampledMotion, PinsThatWouldPassThroughAnObstacleAreFound) {
  const SampledScene sampled(pins_against_a_plate, {}, refined_surface,
                             [](const SceneBody& body) { return body.dynamic; });
  PrescribedPaths paths(sampled.scene());
  EXPECT_FALSE(paths.find_crossing(0, 0.399));  // the leading corners are 0.4 m from the plate
  const auto fault = paths.find_crossing(0.3, 0.401);
  ASSERT_TRUE(fault);
  const std::string text = fault->describe(sampled.scene());
  EXPECT_NE(text.find("body \"sheet\", row 0, column 8 of its surface"), std::string::npos) << text;
  SampledRun run(sampled.scene());
  const std::string failure = run.run_until(1);
  EXPECT_TRUE(failure.starts_with("prescribed motions leave no room")) << failure;
  EXPECT_NEAR(run.time(), 0.4, 1e-3);
}

// Two rows are pinned: one rests and one moves up. The points between them move half as fast and
// pass through a plate later.
TEST(SampledMotion, PointsBetweenTwoMotionsAreFollowed) {
  const SampledScene sampled(R"(
[time]
duration = 1
[material.cloth]
[[body]]
name = "strip"
shape = { type = "rectangle", size = [0.2, 0.1], resolution = [2, 3] }
[[body.pin]]
edges = ["first_row"]
[[body.pin]]
edges = ["last_row"]
motion = { velocity = [0, 0, 1] }
[[obstacle]]
name = "plate"
position = [0.25, 0.25, 0.1]
shape = { type = "rectangle", size = [1, 1], resolution = [2, 2] }
)",
                             {}, refined_surface,
                             [](const SceneBody& body) { return body.dynamic; });
  PrescribedPaths paths(sampled.scene());
  EXPECT_TRUE(paths.find_crossing(0.09, 0.11));
  EXPECT_TRUE(paths.find_crossing(0.15, 0.25));
  EXPECT_FALSE(paths.find_crossing(0.12, 0.19));
  EXPECT_FALSE(paths.find_crossing(0.21, 0.3));
}

// A plate rises to a sloping sheet. The lowest row of its refined surface is the first one or the
// last one.
TEST(SampledMotion, StepsAreLimitedByTheDistanceOfPoints) {
  for (const char* slope : {"20", "-20"}) {
    const SampledScene sampled(R"(
[time]
duration = 1
[material.cloth]
[[body]]
name = "sheet"
position = [0, 0, 0.5]
velocity = [0, 0, -1]
shape = { type = "rectangle", size = [1, 1], resolution = [5, 5] }
[[obstacle]]
name = "plate"
shape = { type = "rectangle", size = [2, 2], resolution = [5, 5] }
motion = { velocity = [0, 0, 0.5] }
)",
                               {std::string("body.sheet.rotation_deg=[") + slope + ", 0, 0]"},
                               refined_surface);
    const auto latest_end = [](const Scene& scene) {
      Statistics statistics;
      Dynamics dynamics(scene, statistics);
      MotionLimits limits(scene, dynamics);
      return limits.latest_end(0, 5, dynamics.initial_state()).value_or(-1);
    };
    const double plain = latest_end(sampled.plain());
    EXPECT_GT(plain, 0);
    EXPECT_LT(plain, 0.3);
    EXPECT_NEAR(latest_end(sampled.scene()), plain, 1e-9);
  }
}

}  // namespace
}  // namespace weft::sim::sampled_motion_test
