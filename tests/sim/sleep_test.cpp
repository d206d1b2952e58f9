// Bodies that sleep: they cost nothing, wake before anything acts on them, and lose no momentum.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "sim/integrator/integrator.h"
#include "sim/run/make_simulation.h"
#include "sim/run/recorded_run.h"
#include "sim/scene/awake_scene.h"
#include "sim/simulation/moving_boxes.h"
#include "sim/simulation/rest_watch.h"
#include "sim/trajectory/trajectory.h"
#include "sim/view/scene_description.h"
#include "tests/sim/joint_cases.h"
#include "tests/sim/simulated_case.h"
#include "tests/temporary_folder.h"

namespace weft::sim::sleep_test {
namespace {

// A sheet that flies towards another one, which is at rest, and meets it after 0.9 s.
constexpr const char* thrown_sheet = R"(
[time]
duration = 2
frames_per_second = 200
[world]
gravity = [0, 0, 0]
[contact]
range = 0.004
[material.cloth]
density = 0.2
membrane_stiffness = 200
bending_stiffness = 1e-4
stiffness_damping = 1e-3
[[body]]
name = "resting"
position = [0, 0, 0]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [5, 5] }
[[body]]
name = "flying"
position = [0.05, 0.03, -0.275]
velocity = [0, 0, 0.3]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [5, 5] }
)";

// Two sheets lie on each other and on a plate, strongly damped, and a third one swings.
constexpr const char* stack = R"(
[time]
duration = 4
[contact]
range = 0.004
friction = 0.5
[material.cloth]
density = 0.2
membrane_stiffness = 200
bending_stiffness = 1e-4
stiffness_damping = 1e-3
mass_damping = 6
[material.free]
density = 0.2
membrane_stiffness = 200
bending_stiffness = 1e-4
stiffness_damping = 1e-3
[[body]]
name = "upper"
position = [0.01, 0, 0.0136]
material = "cloth"
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [5, 5] }
[[body]]
name = "swinging"
position = [1, 0, 0]
material = "free"
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [5, 5] }
[[body.pin]]
edges = ["last_row"]
[[body]]
name = "lower"
position = [0, 0, 0.0068]
material = "cloth"
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [6, 6] }
[[obstacle]]
name = "plate"
position = [0, 0, 0]
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [4, 4] }
)";

class Listener final : public StepObserver {
 public:
  void after_step(const Simulation&) override { ++steps; }
  void after_decision(const std::string& text) override { decisions.push_back(text); }
  std::int64_t steps = 0;
  std::vector<std::string> decisions;
};

Simulation simulation_of(const std::string& text, const Overrides& overrides = {}) {
  return make_simulation(parse_case(text, "test.toml", overrides));
}

Overrides without_sleep(Overrides more) {
  more.emplace_back("time.sleep=false");
  return more;
}

int sleeping_bodies(const Simulation& simulation) {
  return simulation.summary_of(simulation.time(), simulation.state()).sleeping_bodies;
}

double largest_distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

Vec3 momentum(const Simulation& simulation) {
  const Scene& scene = simulation.scene();
  const std::span<const Vec3> velocity = StateView::of(simulation.state()).velocity;
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < scene.dynamic_particles; ++i) sum += scene.mass[i] * velocity[i];
  return sum;
}

// Without these limits, steps in free flight are so long that the first one after the half second
// of rest already meets the other sheet.
const Overrides short_steps{"time.maximum_step=0.01", "time.position_tolerance=1e-6",
                            "time.relative_tolerance=1e-5"};
const std::vector<Overrides> all_methods{
    method("cvode", short_steps), method("arkode", short_steps), method("euler", short_steps),
    method("euler", {"time.step=0.002"})};

TEST(Sleep, WakesBeforeAnythingActs) {
  for (const Overrides& overrides : all_methods) {
    SCOPED_TRACE(overrides.front());
    Simulation sleepy = simulation_of(thrown_sheet, overrides),
               awake = simulation_of(thrown_sheet, without_sleep(overrides));
    Listener listener;
    sleepy.add_observer(listener);
    const Vec3 before = momentum(sleepy);
    advance_to(sleepy, 0.8);
    EXPECT_EQ(sleeping_bodies(sleepy), 1);
    EXPECT_EQ(largest_distance(sleepy.velocity("resting"), std::vector<Vec3>(25, Vec3::Zero())), 0);
    for (const double time : {0.88, 0.92, 0.96, 1.1}) {
      advance_to(sleepy, time);
      advance_to(awake, time);
      // If the resting sheet were an obstacle for a step, it would take up momentum.
      EXPECT_LT((momentum(sleepy) - before).norm(), 1e-3 * before.norm()) << time;
      const double tolerance = overrides.front() == method("euler").front() ? 3e-3 : 1e-3;
      for (const std::string body : {"resting", "flying"}) {
        EXPECT_LT(largest_distance(sleepy.position(body), awake.position(body)), tolerance)
            << body << " at " << time;
      }
    }
    EXPECT_EQ(sleeping_bodies(sleepy), 0);
    EXPECT_EQ(sleepy.counts().steps, listener.steps);
    EXPECT_GT(sleepy.velocity("resting")[12].z(), 0.05);
    ASSERT_EQ(listener.decisions.size(), 2U);
    EXPECT_EQ(listener.decisions[0].rfind("body \"resting\" sleeps at t = 0.5", 0), 0U)
        << listener.decisions[0];
    EXPECT_EQ(listener.decisions[1].rfind("body \"resting\" wakes at t = 0.", 0), 0U)
        << listener.decisions[1];
  }
}

// The small sheet meets the middle of a triangle of the flying one, far from its vertices. If it
// were still an obstacle, no sample would feel it; its own edges and vertices would push only over
// a quarter of the range.
TEST(Sleep, EndsWithinTheWholeRange) {
  Simulation simulation = simulation_of(
      thrown_sheet,
      method("euler", {"time.step=0.002", "body.resting.shape.size=[0.1, 0.1]",
                       "body.flying.shape.size=[1, 1]", "body.flying.shape.resolution=[3, 3]",
                       "body.flying.position=[0.35, 0.35, -0.275]"}));
  Listener listener;
  simulation.add_observer(listener);
  // The gap reaches the range after (0.275 - 0.001 - 0.004) m / (0.3 m/s) = 0.9 s.
  advance_to(simulation, 0.904);
  ASSERT_EQ(listener.decisions.size(), 2U);
  EXPECT_EQ(listener.decisions[1].rfind("body \"resting\" wakes at t = 0.9 s", 0), 0U)
      << listener.decisions[1];
}

// Until the bodies come near each other, the sleeping one adds no candidates of contact.
TEST(Sleep, CostsNothing) {
  const Overrides steps = method("euler", {"time.step=0.01"});
  Simulation sleepy = simulation_of(thrown_sheet, steps);
  advance_to(sleepy, 0.6);
  ASSERT_EQ(sleeping_bodies(sleepy), 1);
  EXPECT_EQ(sleepy.energies().elastic.size(), 2U);
  const auto candidates = sleepy.statistics().counters.narrow_phase_calls;
  advance_to(sleepy, 0.7);
  EXPECT_EQ(sleepy.statistics().counters.narrow_phase_calls, candidates);
}

// Both sheets of the stack fall asleep together. The swinging one stays awake and is not disturbed.
TEST(Sleep, HoldsForBodiesInContactTogether) {
  for (const Overrides& overrides : {method("cvode"), method("euler", {"time.step=0.004"})}) {
    SCOPED_TRACE(overrides.front());
    Simulation sleepy = simulation_of(stack, overrides),
               awake = simulation_of(stack, without_sleep(overrides));
    Listener listener;
    sleepy.add_observer(listener);
    advance_to(sleepy, 3.5);
    advance_to(awake, 3.5);
    EXPECT_EQ(sleeping_bodies(sleepy), 2);
    ASSERT_EQ(listener.decisions.size(), 1U);
    EXPECT_EQ(listener.decisions[0].rfind("2 bodies sleep (\"upper\", \"lower\") at t = ", 0), 0U)
        << listener.decisions[0];
    for (const std::string body : {"upper", "lower"}) {
      EXPECT_LT(largest_distance(sleepy.position(body), awake.position(body)), 1e-5) << body;
    }
    // Under error control the steps depend on the bodies that are awake; fixed steps do not.
    if (overrides.size() > 1) {
      EXPECT_LT(largest_distance(sleepy.position("swinging"), awake.position("swinging")), 1e-4);
    }
    const Energies with = sleepy.summary_of(sleepy.time(), sleepy.state()).energies,
                   without = awake.summary_of(awake.time(), awake.state()).energies;
    EXPECT_NEAR(with.contact, without.contact, 1e-3 * without.contact);
    const Energies whole = sleepy.dynamics().energies(sleepy.time(), sleepy.state());
    EXPECT_NEAR(with.total(), whole.total(), 1e-12);
    for (std::size_t i = 0; i < with.elastic.size(); ++i) {
      EXPECT_EQ(with.elastic[i].first, whole.elastic[i].first);
      EXPECT_NEAR(with.elastic[i].second, whole.elastic[i].second, 1e-14);
    }
    EXPECT_NEAR(with.gravitational, whole.gravitational, 1e-14);
    EXPECT_NEAR(with.contact, whole.contact, 1e-14);
    const auto gap = sleepy.summary_of(sleepy.time(), sleepy.state()).smallest_gap;
    ASSERT_TRUE(gap);
    EXPECT_NEAR(*gap, *awake.summary_of(awake.time(), awake.state()).smallest_gap, 1e-5);
  }
}

// Contact does not search between an obstacle that begins to move and a sleeping body, which is an
// obstacle, too.
TEST(Sleep, EndsWhenAnObstacleComes) {
  const std::string pushed = std::string(thrown_sheet) + R"(
[[obstacle]]
name = "pusher"
position = [0, 0, -0.2]
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [3, 3] }
motion = { velocity = [0, 0, 0.4], start_time = 0.7 }
)";
  for (const Overrides& each : all_methods) {
    SCOPED_TRACE(each.front());
    Overrides overrides = each;
    overrides.insert(overrides.end(),
                     {"body.flying.position=[3, 0, 0]", "body.flying.velocity=[0, 0, 0.2]"});
    Simulation sleepy = simulation_of(pushed, overrides),
               awake = simulation_of(pushed, without_sleep(overrides));
    advance_to(sleepy, 0.69);
    EXPECT_EQ(sleeping_bodies(sleepy), 1);
    for (const double time : {1.15, 1.25, 1.4}) {
      advance_to(sleepy, time);
      advance_to(awake, time);
      EXPECT_LT(largest_distance(sleepy.position("resting"), awake.position("resting")), 3e-3)
          << time;
    }
    EXPECT_EQ(sleeping_bodies(sleepy), 0);
    EXPECT_GT(sleepy.position("resting")[12].z(), 0.06);
  }
}

TEST(Sleep, IsNotForBodiesWithMovingPins) {
  const std::string carried = std::string(thrown_sheet) + R"(
[[body]]
name = "held"
position = [-2, 0, 0]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [5, 5] }
[[body.pin]]
edges = ["first_row"]
motion = { velocity = [0, 0, 0.1], start_time = 1.0 }
)";
  Simulation simulation = simulation_of(carried, method("euler", {"time.step=0.004"}));
  advance_to(simulation, 0.8);
  EXPECT_EQ(sleeping_bodies(simulation), 1);
  advance_to(simulation, 1.2);
  EXPECT_GT(simulation.velocity("held")[0].z(), 0.09);
}

TEST(Sleep, LeavesOneBodyAwake) {
  Simulation simulation = simulation_of(
      thrown_sheet, method("euler", {"time.step=0.01", "body.flying.velocity=[0, 0, 0]"}));
  advance_to(simulation, 1.5);
  EXPECT_EQ(sleeping_bodies(simulation), 1);
}

TEST(Sleep, EndsWithNewVelocities) {
  Simulation simulation = simulation_of(thrown_sheet, method("cvode", short_steps));
  advance_to(simulation, 0.7);
  ASSERT_EQ(sleeping_bodies(simulation), 1);
  simulation.set_velocity("resting", std::vector<Vec3>(25, Vec3(0.3, 0, 0)));
  EXPECT_EQ(sleeping_bodies(simulation), 0);
  advance_to(simulation, 0.75);
  EXPECT_NEAR(simulation.velocity("resting")[12].x(), 0.3, 1e-6);
  EXPECT_GT(simulation.counts().steps, 10);
}

TEST(Sleep, IsPartOfASavedState) {
  for (const Overrides& steps : {method("euler", {"time.step=0.004"}), method("euler", short_steps),
                                 method("implicit_midpoint", {"time.step=0.002"})}) {
    Simulation whole = simulation_of(thrown_sheet, steps),
               elsewhere = simulation_of(thrown_sheet, steps);
    advance_to(whole, 0.7);
    ASSERT_EQ(sleeping_bodies(whole), 1);
    elsewhere.restore(whole.save());
    EXPECT_EQ(sleeping_bodies(elsewhere), 1);
    EXPECT_EQ(elsewhere.energies().total(), whole.energies().total());
    for (const double time : {0.8, 1.0}) {
      advance_to(whole, time);
      advance_to(elsewhere, time);
      EXPECT_EQ(elsewhere.position("resting"), whole.position("resting"));
      EXPECT_EQ(elsewhere.velocity("flying"), whole.velocity("flying"));
      EXPECT_EQ(elsewhere.counts().steps, whole.counts().steps);
    }
    EXPECT_EQ(sleeping_bodies(elsewhere), 0);
  }
}

// The frames of a sleeping body repeat its positions, and the series sleeping_bodies counts it.
TEST(Sleep, IsRecorded) {
  const TemporaryFolder folder;
  RunOptions options;
  options.trajectory = folder.path("run.h5");
  const auto scene = build_scene(parse_case(
      thrown_sheet, "test.toml", method("euler", {"time.step=0.004", "time.duration=0.85"})));
  ASSERT_EQ(run_simulation(*scene, options).status, RunReport::Status::done);
  const TrajectoryReader recorded(options.trajectory);
  const std::vector<double> sleeping = recorded.series_values("sleeping_bodies");
  ASSERT_EQ(static_cast<int>(sleeping.size()), recorded.frames());
  EXPECT_EQ(sleeping.front(), 0);
  EXPECT_EQ(sleeping.back(), 1);
  const auto first = std::ranges::find(sleeping, 1.0) - sleeping.begin();
  EXPECT_EQ(recorded.positions(0, static_cast<int>(first)),
            recorded.positions(0, recorded.frames() - 1));
}

TEST(Sleep, IsNamedByTheDescription) {
  const auto text = [](const Overrides& overrides) {
    return describe_scene(*build_scene(parse_case(thrown_sheet, "test.toml", overrides)));
  };
  EXPECT_NE(text({}).find("sleep     bodies that come to rest are skipped until something"),
            std::string::npos);
  EXPECT_NE(text({"time.sleep=false"}).find("sleep     off: time.sleep is false"),
            std::string::npos);
}

TEST(AwakeScene, RenumbersBodiesAndParticles) {
  const auto whole = build_scene(parse_case(stack, "test.toml"));
  std::vector<Vec3> position(whole->initial_position.begin(),
                             whole->initial_position.begin() + whole->dynamic_particles);
  for (Vec3& p : position) p += Vec3(0, 0, 0.5);
  const std::vector<char> asleep{1, 0, 1};
  const AwakeScene awake(*whole, asleep, position);
  const Scene& scene = awake.scene();
  EXPECT_EQ(scene.dynamic_bodies, 1);
  EXPECT_EQ(scene.dynamic_particles, 25);
  EXPECT_EQ(scene.particle_count, whole->particle_count);
  for (std::size_t i = 0; i < whole->case_order.size(); ++i)
    EXPECT_EQ(scene.bodies[scene.case_order[i]].name, whole->bodies[whole->case_order[i]].name);
  for (int i = 0; i < scene.particle_count; ++i) {
    const int there = awake.whole_particle(i);
    EXPECT_EQ(scene.describe_particle(i), whole->describe_particle(there));
    EXPECT_EQ(scene.contact_area[i], whole->contact_area[there]);
    EXPECT_EQ(scene.initial_position[i],
              there < whole->dynamic_particles ? position[there] : whole->initial_position[there]);
    if (i >= scene.dynamic_particles) continue;
    EXPECT_EQ(scene.mass[i], whole->mass[there]);
    EXPECT_EQ(scene.pinned[i], whole->pinned[there]);
  }
  for (const SceneBody& body : scene.bodies)
    EXPECT_EQ(body.sleeps, body.name == "upper" || body.name == "lower");
  std::vector<double> state(6 * whole->dynamic_particles), part(6 * scene.dynamic_particles);
  std::iota(state.begin(), state.end(), 0.0);
  awake.gather(state, part);
  const StateView from = StateView::of(state), to = StateView::of(part);
  for (int i = 0; i < scene.dynamic_particles; ++i) {
    EXPECT_EQ(to.position[i], from.position[awake.whole_particle(i)]);
    EXPECT_EQ(to.velocity[i], from.velocity[awake.whole_particle(i)]);
  }
  std::vector<double> back(state.size(), -1.0);
  awake.scatter(part, back);
  int copied = 0;
  for (std::size_t i = 0; i < state.size(); ++i) {
    EXPECT_TRUE(back[i] == state[i] || back[i] == -1);
    copied += back[i] == state[i] ? 1 : 0;
  }
  EXPECT_EQ(copied, 150);
}

TEST(RestWatch, AsksForAWholeWindow) {
  const auto scene = build_scene(parse_case(thrown_sheet, "test.toml", {"time.duration=10.5"}));
  const Statistics unused;
  std::vector<double> y(6 * scene->dynamic_particles, 0.0);
  const std::vector<char> asleep(2, 0);
  RestWatch watch(*scene, 0, y);
  // At 0.5 s, 10 s are left. A window of 0.5 s, a twentieth of that, may use a twentieth of the
  // tolerance.
  const double allowed = 1e-5 * 0.5 / 10;
  const auto look = [&](double time, double place) {
    y[0] = place;
    watch.look(time, y, asleep);
  };
  look(0.3, 0.9 * allowed);
  EXPECT_FALSE(watch.is_at_rest(0));
  look(0.5, 0.9 * allowed);
  EXPECT_TRUE(watch.is_at_rest(0));
  EXPECT_TRUE(watch.is_at_rest(1));
  look(0.51, 1.2 * allowed);
  EXPECT_FALSE(watch.is_at_rest(0));
  EXPECT_TRUE(watch.is_at_rest(1));
  look(1.0, 1.2 * allowed);
  EXPECT_FALSE(watch.is_at_rest(0));
  look(1.01, 1.2 * allowed);
  EXPECT_TRUE(watch.is_at_rest(0));
  // A vertex at its place, but fast: half way through a swing.
  y[y.size() / 2 + 1] = 1.1e-3;
  watch.look(1.02, y, asleep);
  EXPECT_FALSE(watch.is_at_rest(0));
  EXPECT_FALSE(watch.is_due(1.03));
  EXPECT_TRUE(watch.is_due(1.06));
}

// No obstacle that is in reach at any of many times may be missed, and far ones must not be named.
TEST(MovingBoxes, ContainTheObstacleAtAllTimes) {
  const std::string turning = std::string(thrown_sheet) + R"(
[[obstacle]]
name = "blade"
position = [0.5, 0, 0]
rotation_deg = [10, 20, 30]
shape = { type = "rectangle", size = [0.4, 0.1], resolution = [5, 3] }
motion = { centre = [0, 0, 0.1], angular_velocity_deg = [40, 80, 10], velocity = [0.1, 0, 0.3] }
)";
  const auto scene = build_scene(parse_case(turning, "test.toml"));
  const MovingBoxes boxes(*scene);
  const PrescribedMotion& held = scene->prescribed.back();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-0.5, 0.5), size(0.01, 0.3);
  std::vector<Vec3> position(held.start.size()), velocity(held.start.size());
  for (const auto& [from, to] : {std::pair(0.3, 0.5), std::pair(1.0, 1.001)}) {
    int near = 0, named = 0;
    for (int trial = 0; trial < 1000; ++trial) {
      const Vec3 corner(place(random), place(random), place(random));
      const Eigen::AlignedBox3d box(corner,
                                    corner + Vec3(size(random), size(random), size(random)));
      bool reaches = false;
      for (int i = 0; i <= 20; ++i) {
        held.motion.apply(from + (to - from) * i / 20, held.start, position, velocity);
        for (const Vec3& p : position) reaches |= box.exteriorDistance(p) < 0.004 + 0.001;
      }
      const bool is_named = boxes.may_reach(box, 0.001, from, to);
      EXPECT_TRUE(is_named || !reaches);
      near += reaches ? 1 : 0;
      named += is_named ? 1 : 0;
    }
    EXPECT_GT(near, 10);
    EXPECT_LT(named, 700);
  }
}

// Two heavy sheets, one of which swings for ever; the other hangs at rest.
constexpr const char* hanging_pair = R"(
[time]
duration = 4
[contact]
enabled = false
[material.cloth]
density = 0.2
membrane_stiffness = 2000
stiffness_damping = 1e-3
mass_damping = 30
normal_drag = 1.2
[material.free]
density = 0.2
membrane_stiffness = 200
[[body]]
name = "resting"
material = "cloth"
rotation_deg = [90, 0, 0]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [5, 5] }
[[body.pin]]
edges = ["last_row"]
[[body]]
name = "swinging"
material = "free"
position = [2, 0, 0]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [5, 5] }
[[body.pin]]
edges = ["last_row"]
)";

TEST(SleepBesideCurves, ABodyWakesWhereWindGravityOrDragChanges) {
  for (const char* curve :
       {"world.wind={ times = [0, 2.5], values = [[0, 0, 0], [0, 3, 0]], between = \"step\" }",
        "world.wind={ times = [2.5, 3], values = [[0, 0, 0], [0, 3, 0]] }",
        "world.gravity={ times = [2.5, 3], values = [[0, 0, -9.81], [0, 2, -9.81]], between = "
        "\"smooth\" }"}) {
    for (const char* name : {"cvode", "verlet"}) {
      const Overrides options = method(name, {curve});
      SCOPED_TRACE(std::string(name) + ", " + curve);
      Simulation sim = simulation_of(hanging_pair, options);
      Listener listener;
      sim.add_observer(listener);
      advance_to(sim, 2.45);
      EXPECT_EQ(sleeping_bodies(sim), 1);
      const std::vector<Vec3> asleep = sim.position("resting");
      advance_to(sim, 3.2);
      ASSERT_EQ(listener.decisions.size(), 2U);
      EXPECT_EQ(listener.decisions[1], "body \"resting\" wakes at t = 2.5 s");
      EXPECT_EQ(sleeping_bodies(sim), 0);
      Simulation awake = simulation_of(hanging_pair, without_sleep(options));
      advance_to(awake, 3.2);
      EXPECT_LT(largest_distance(sim.position("resting"), awake.position("resting")), 1e-3);
      EXPECT_GT(largest_distance(sim.position("resting"), asleep), 5e-3);
    }
  }
}

TEST(SleepBesideCurves, ABodyInAGustStaysAwakeAndOneWithoutDragSleeps) {
  const std::string gust = "world.wind={ mean = [0, 1e-9, 0], intensity = 0.1, time_scale = 1 }";
  Simulation driven = simulation_of(hanging_pair, {gust});
  advance_to(driven, 3);
  EXPECT_EQ(sleeping_bodies(driven), 0);
  Simulation without_drag = simulation_of(
      hanging_pair, {gust, "material.cloth.normal_drag=0", "material.free.normal_drag=1e-9"});
  advance_to(without_drag, 3);
  EXPECT_EQ(sleeping_bodies(without_drag), 1);
  // Damping does not move what rests.
  Simulation damped = simulation_of(
      hanging_pair, {"material.cloth.mass_damping={ times = [0, 4], values = [30, 40] }"});
  advance_to(damped, 3);
  EXPECT_EQ(sleeping_bodies(damped), 1);
}

}  // namespace
}  // namespace weft::sim::sleep_test
