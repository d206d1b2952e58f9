// Obstacles that move as rigid bodies: their pyramids stay in their own frames, and their vertices
// are put in place only where they are in reach. Nothing else may change.
#include "sim/contact/rigid_obstacles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "sim/contact/contact.h"
#include "tests/sim/contact_oracle.h"
#include "tests/sim/simulated_case.h"

namespace weft::sim::rigid_obstacles_test {
namespace {

using Positions = std::vector<Vec3>;
using Poses = std::vector<RigidPose>;

constexpr std::array bounds{"sphere", "box", "sphere_then_box"};

// A torus that turns and comes from below, and in its hole a plate that pins hold as a whole and
// carry.
constexpr const char* met_by_two = R"(
[time]
duration = 1
[compute]
backend = "cpu"
[contact]
range = 0.02
friction = 0.3
[material.cloth]
density = 0.2
membrane_stiffness = 500
bending_stiffness = 1e-4
stiffness_damping = 1e-3
[[body]]
name = "sheet"
position = [0, 0, 0.31]
shape = { type = "rectangle", size = [1, 1], resolution = [9, 9] }
[[body]]
name = "plate"
position = [0, 0, 0.22]
shape = { type = "rectangle", size = [0.2, 0.15], resolution = [5, 4] }
[[body.pin]]
rows = [0, -1]
motion = { velocity = [0, 0, 0.5], angular_velocity_deg = [0, 30, 90] }
[[obstacle]]
name = "torus"
shape = { type = "torus", major_radius = 0.4, minor_radius = 0.25, resolution = [32, 16] }
motion = { centre = [0.2, 0, 0], velocity = [0, 0, 0.2], angular_velocity_deg = [20, 0, 60] }
)";

std::unique_ptr<const Scene> scene_of(const std::string& text, const Overrides& overrides = {}) {
  return build_scene(parse_case(text, "test.toml", overrides));
}

// A search that rebuilds the pyramids of obstacles whenever they have moved.
class Rebuilding : public PairSearch {
 public:
  explicit Rebuilding(const Scene& scene) : search_(make_cpu_search(scene)) {}
  int rebuild(std::span<const BodyPath> paths) override { return search_->rebuild(paths); }
  void find(std::span<const PairQuery> queries, std::vector<std::vector<bsi::LeafPair>>& found,
            bsi::TraversalCounters& counters) override {
    search_->find(queries, found, counters);
  }

 private:
  std::unique_ptr<PairSearch> search_;
};

struct Ran {
  std::vector<double> state;
  Counters counters;
};

// The device is the one that the case names.
enum class Asked { cpu, cpu_rebuilding, device };

ChosenSearch search_of(const Scene& scene, Asked asked) {
  if (asked == Asked::device) return choose_search(scene);
  if (asked == Asked::cpu_rebuilding) return {std::make_unique<Rebuilding>(scene), {}};
  return {make_cpu_search(scene), {}};
}

Ran run(const Overrides& overrides, Asked asked) {
  const auto scene = scene_of(met_by_two, overrides);
  Statistics statistics;
  Dynamics dynamics(*scene, statistics, search_of(*scene, asked));
  const auto integrator = make_integrator(*scene, dynamics);
  std::vector<double> frame(dynamics.state_size());
  while (integrator->time() < 0.12) {
    if (const auto failure = integrator->step()) {
      ADD_FAILURE() << failure->text;
      break;
    }
    EXPECT_FALSE(integrator->state_at(integrator->time(), frame));
  }
  EXPECT_GT(dynamics.contact()->pairs_in_reach(), 0U);
  return {{integrator->state().begin(), integrator->state().end()}, statistics.counters};
}

TEST(RigidObstacles, MoveBodiesAsIfTheirPyramidsWereRebuilt) {
  for (const Overrides& overrides :
       {method("cvode"), method("arkode"), method("euler"), method("euler", {"time.step=1e-3"}),
        method("verlet", {"material.cloth.stiffness_damping=0", "time.duration=0.2"})}) {
    SCOPED_TRACE(overrides.front());
    Overrides all = overrides;
    all.emplace_back("contact.bound=box");
    const Ran expected = run(all, Asked::cpu_rebuilding);
    for (const char* bound : bounds) {
      all.back() = std::string("contact.bound=") + bound;
      const Ran found = run(all, Asked::cpu);
      EXPECT_TRUE(found.state == expected.state) << bound;
      EXPECT_EQ(found.counters.candidate_pairs, expected.counters.candidate_pairs);
      EXPECT_LT(found.counters.rebuilds, expected.counters.rebuilds);
    }
  }
}

TEST(RigidObstacles, MoveBodiesOnADeviceAsOnTheCpu) {
  for (const Overrides& overrides : {method("cvode"), method("euler")}) {
    SCOPED_TRACE(overrides.front());
    Overrides all = overrides;
    all.emplace_back("contact.bound=box");
    const Ran expected = run(all, Asked::cpu);
    all.emplace_back("compute.backend=osmesa");
    for (const char* bound : bounds) {
      all[1] = std::string("contact.bound=") + bound;
      const Ran found = run(all, Asked::device);
      EXPECT_TRUE(found.state == expected.state) << bound;
      EXPECT_EQ(found.counters.candidate_pairs, expected.counters.candidate_pairs);
    }
  }
}

TEST(RigidObstacles, AreBuiltOnce) {
  const auto scene = scene_of(met_by_two, {"body.sheet.self_contact=false"});
  Statistics statistics;
  Dynamics dynamics(*scene, statistics);
  const auto integrator = make_integrator(*scene, dynamics);
  while (integrator->time() < 0.12) ASSERT_FALSE(integrator->step());
  // The sheet has a list with each of the two obstacles; both lists are built together while both
  // obstacles are near.
  const Counters& counters = statistics.counters;
  EXPECT_GT(counters.pair_traversals, 8);
  EXPECT_LE(counters.rebuilds, counters.pair_traversals + 2);
}

// --- Against every pair of features ---

// Small bodies near each other, for the oracle.
constexpr const char* small_and_near = R"(
[time]
duration = 1
[contact]
range = 0.03
search_slack = 0.02
[[body]]
name = "sheet"
thickness = 0.004
shape = { type = "rectangle", size = [0.6, 0.6], resolution = [5, 5] }
[[obstacle]]
name = "torus"
thickness = 0.004
position = [0.1, 0.05, 0.1]
shape = { type = "torus", major_radius = 0.2, minor_radius = 0.1, resolution = [8, 6] }
motion = { velocity = [0, 0, 1] }
[[obstacle]]
name = "plate"
thickness = 0.004
position = [0, 0.1, -0.03]
rotation_deg = [0, 10, 10]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [4, 4] }
motion = { velocity = [0, 0, 1] }
)";

class Random {
 public:
  explicit Random(unsigned seed) : source_(seed) {}
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(source_);
  }
  Vec3 vector(double size) {
    return {between(-size, size), between(-size, size), between(-size, size)};
  }
  RigidPose pose(const Vec3& centre, double angle, double way) {
    RigidPose pose;
    const Vec3 axis = vector(1).normalized();
    pose.rotation = Eigen::AngleAxisd(between(-angle, angle), axis).toRotationMatrix();
    pose.centre = centre;
    pose.translation = vector(way);
    pose.velocity = vector(0.1);
    pose.angular_velocity = vector(0.1);
    return pose;
  }
  // As at the end of a step.
  RigidPose after(RigidPose pose, double angle, double way) {
    const RigidPose step = this->pose(pose.centre, angle, way);
    pose.rotation = step.rotation * pose.rotation;
    pose.translation += step.translation;
    return pose;
  }

 private:
  std::mt19937 source_;
};

// Positions and velocities at one time: `all` has everything, `room` no vertex of an obstacle but
// those that contact has put in place.
struct Moment {
  Positions all, velocity, room, room_velocity;
  Poses poses;

  Moment(const Scene& scene, const RigidObstacles& obstacles, const Positions& sheet, Poses at)
      : all(scene.initial_position), velocity(all.size(), Vec3::Zero()), poses(std::move(at)) {
    std::copy(sheet.begin(), sheet.end(), all.begin());
    room = all;
    room_velocity = velocity;
    for (const RigidObstacle& obstacle : obstacles.all()) {
      for (std::size_t i = 0; i < obstacle.held->start.size(); ++i) {
        const int particle = obstacle.held->particles[i];
        poses[obstacle.number].place(obstacle.held->start[i], all[particle], velocity[particle]);
        room[particle].setConstant(std::numeric_limits<double>::quiet_NaN());
        room_velocity[particle] = room[particle];
      }
    }
  }
  PlacedPoints placed() { return {room, room_velocity, poses}; }
  PlacedParticles placed_particles() { return {room, room_velocity, poses}; }
};

// A walk of the sheet and of both obstacles, in small steps and, now and then, a leap.
class Walk {
 public:
  // The obstacles are turned by up to `angle` (rad) and put `apart` (m) from the sheet.
  Walk(const Scene& scene, const RigidObstacles& obstacles, unsigned seed, double angle = 3,
       double apart = 0)
      : scene_(scene), obstacles_(obstacles), random_(seed) {
    for (const RigidObstacle& obstacle : obstacles.all()) {
      poses_.push_back(random_.pose(obstacle.middle + random_.vector(0.1), angle, 0.03));
      poses_.back().translation.z() = obstacle.middle.z() > 0 ? apart : -apart;
    }
    sheet_.assign(scene.initial_position.begin(),
                  scene.initial_position.begin() + scene.dynamic_particles);
    for (Vec3& x : sheet_) x += random_.vector(0.005);
  }
  Moment now() const { return {scene_, obstacles_, sheet_, poses_}; }
  void step(bool leaps) {
    for (RigidPose& pose : poses_)
      pose = leaps ? random_.pose(pose.centre, 3, 0.03) : random_.after(pose, 0.05, 0.004);
    for (Vec3& x : sheet_) x += random_.vector(0.001);
  }
  // Moves the obstacles alone.
  void move_obstacles() {
    for (RigidPose& pose : poses_) pose = random_.after(pose, 0.05, 0.01);
  }

 private:
  const Scene& scene_;
  const RigidObstacles& obstacles_;
  Random random_;
  Poses poses_;
  Positions sheet_;
};

TEST(RigidObstacles, ListsAreCompleteWhereverTheyMove) {
  for (const char* bound : bounds) {
    const auto scene = scene_of(small_and_near, {std::string("contact.bound=") + bound});
    const ContactOracle oracle(*scene);
    const RigidObstacles obstacles(*scene);
    ASSERT_EQ(obstacles.all().size(), 2U);
    std::size_t in_reach = 0;
    for (unsigned seed = 0; seed < 6; ++seed) {
      Statistics statistics;
      ContactSearch search(*scene, statistics, {make_cpu_search(*scene), {}});
      Walk walk(*scene, obstacles, seed);
      for (int k = 0; k < 40; ++k) {
        SCOPED_TRACE(std::string(bound) + ", " + std::to_string(k));
        Moment now = walk.now();
        // Once in a while all positions are given instead of poses. Lists built from poses must
        // then serve or be renewed.
        ASSERT_FALSE(k % 7 == 6 ? search.update(now.all) : search.update(now.placed()));
        ASSERT_EQ(oracle.missing(search.lists(), now.all), "");
        in_reach += oracle.in_reach(now.all).size();
        walk.step(k % 10 == 9);
      }
      EXPECT_LT(statistics.counters.pair_traversals, 80);
    }
    EXPECT_GT(in_reach, 1000U);
  }
}

TEST(RigidObstacles, ListsOfPathsAreComplete) {
  const auto scene = scene_of(small_and_near);
  const ContactOracle oracle(*scene);
  const RigidObstacles obstacles(*scene);
  std::size_t in_reach = 0;
  for (unsigned seed = 0; seed < 8; ++seed) {
    Statistics statistics;
    ContactSearch search(*scene, statistics, {make_cpu_search(*scene), {}});
    Walk walk(*scene, obstacles, seed);
    for (int k = 0; k < 24; ++k) {
      SCOPED_TRACE(k);
      Moment start = walk.now();
      walk.step(k % 8 == 7);
      Moment end = walk.now();
      Walk other_walk = walk;
      ASSERT_FALSE(search.update_path(start.placed(), end.placed()));
      for (const double t : {0.0, 0.3, 0.5, 0.8, 1.0}) {
        Positions between = start.all;
        for (std::size_t i = 0; i < between.size(); ++i)
          between[i] += t * (end.all[i] - start.all[i]);
        ASSERT_EQ(oracle.missing(search.lists(), between), "") << t;
        in_reach += oracle.in_reach(between).size();
      }
      // Paths to the same end from other starts.
      for (int i = 0; i < 3; ++i) {
        other_walk.move_obstacles();
        Moment other = other_walk.now();
        ASSERT_FALSE(search.update_path(other.placed(), end.placed()));
        ASSERT_EQ(oracle.missing(search.lists(), other.all), "");
        in_reach += oracle.in_reach(other.all).size();
      }
      if (k % 5 != 4) continue;
      ASSERT_FALSE(search.update(end.placed()));
    }
  }
  EXPECT_GT(in_reach, 1000U);
}

void expect_same_lists(std::span<const CandidateList> found,
                       std::span<const CandidateList> expected) {
  const auto same = [](const std::vector<FeaturePair>& a, const std::vector<FeaturePair>& b) {
    return std::ranges::equal(a, b, [](const FeaturePair& p, const FeaturePair& q) {
      return p.a == q.a && p.b == q.b && p.distance == q.distance;
    });
  };
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].body_a, expected[i].body_a);
    EXPECT_EQ(found[i].body_b, expected[i].body_b);
    EXPECT_EQ(found[i].drift, expected[i].drift);
    EXPECT_TRUE(same(found[i].vertex_triangle, expected[i].vertex_triangle));
    EXPECT_TRUE(same(found[i].triangle_vertex, expected[i].triangle_vertex));
    EXPECT_TRUE(same(found[i].edge_edge, expected[i].edge_edge));
  }
}

// Beside a device, too, obstacles that move keep their pyramids and are given by their poses.
TEST(RigidObstacles, ListsOnADeviceAreThoseOfTheCpu) {
  for (const char* bound : bounds) {
    const auto scene =
        scene_of(small_and_near, {std::string("contact.bound=") + bound, "compute.backend=osmesa"});
    const RigidObstacles obstacles(*scene);
    Statistics of_cpu, of_device;
    ContactSearch on_cpu(*scene, of_cpu, {make_cpu_search(*scene), {}});
    ContactSearch on_device(*scene, of_device, choose_search(*scene));
    Walk walk(*scene, obstacles, 3);
    std::size_t pairs = 0;
    for (int k = 0; k < 40; ++k) {
      SCOPED_TRACE(std::string(bound) + ", " + std::to_string(k));
      Moment start = walk.now(), start_too = walk.now();
      walk.step(k % 10 == 9);
      Moment end = walk.now(), end_too = walk.now();
      if (k % 2 == 0) {
        ASSERT_FALSE(on_cpu.update(start.placed()));
        ASSERT_FALSE(on_device.update(start_too.placed()));
      } else {
        ASSERT_FALSE(on_cpu.update_path(start.placed(), end.placed()));
        ASSERT_FALSE(on_device.update_path(start_too.placed(), end_too.placed()));
      }
      expect_same_lists(on_device.lists(), on_cpu.lists());
      for (const CandidateList& list : on_cpu.lists()) pairs += list.edge_edge.size();
    }
    EXPECT_NE(on_device.compute().backend, ComputeBackend::cpu) << on_device.compute().text();
    EXPECT_EQ(of_device.counters.rebuilds, of_cpu.counters.rebuilds);
    EXPECT_GT(pairs, 1000U);
  }
}

// Forces and answers to paths are those of a contact that is given every vertex, to the bit. Half
// of the walks are anchored, also to triangles that are out of reach.
TEST(RigidObstacles, ForcesAndPathsAreThoseOfVerticesThatAreGiven) {
  const auto scene =
      scene_of(small_and_near, {"contact.friction=0.2", "contact.sticking_distance=0.05"});
  const RigidObstacles obstacles(*scene);
  int with_force = 0, refused = 0, accepted = 0;
  std::size_t anchored = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    Statistics statistics;
    Contact posed(*scene, statistics), given(*scene, statistics);
    AnchorHistory of_posed, of_given;
    const bool is_anchored = seed % 2 == 1;
    if (is_anchored) {
      posed.use_anchors(of_posed);
      given.use_anchors(of_given);
    }
    Walk walk(*scene, obstacles, seed, 0.02, 0.012 + 0.0005 * seed);
    for (int k = 0; k < 12; ++k) {
      Moment now = walk.now();
      const auto fault = posed.evaluate(now.placed_particles(), now.room_velocity, 1);
      const auto expected_fault = given.evaluate(now.all, now.velocity, 1);
      ASSERT_EQ(fault.has_value(), expected_fault.has_value());
      Positions force(now.all.size(), Vec3::Zero()), expected = force;
      posed.add_forces(force);
      given.add_forces(expected);
      ASSERT_TRUE(force == expected);
      ASSERT_EQ(posed.energy(), given.energy());
      with_force += posed.pairs_in_reach() > 0 ? 1 : 0;
      if (is_anchored && !fault) {
        anchored += of_posed.selected().size();
        posed.advance_anchors(of_posed.at_end());
        given.advance_anchors(of_given.at_end());
      }
      std::vector<int> loaded;
      posed.find_loaded_obstacles(loaded);
      for (int i = scene->dynamic_particles; i < scene->particle_count; ++i) {
        ASSERT_TRUE(force[i].isZero(0) || std::ranges::binary_search(loaded, i));
      }
      walk.step(false);
      Moment end = walk.now();
      const auto crossing = posed.check_path(now.placed_particles(), end.placed_particles());
      const auto expected_crossing = given.check_path(now.all, end.all);
      ASSERT_EQ(crossing.has_value(), expected_crossing.has_value());
      if (crossing) {
        EXPECT_EQ(crossing->nodes, expected_crossing->nodes);
        EXPECT_EQ(crossing->gap, expected_crossing->gap);
      }
      ++(crossing ? refused : accepted);
    }
  }
  EXPECT_GT(with_force, 50);
  EXPECT_GT(anchored, 500U);
  EXPECT_GT(refused, 10);
  EXPECT_GT(accepted, 10);
}

// --- Bounds ---

TEST(RigidObstacles, BoxesAndSpheresHoldEveryVertex) {
  const auto scene = scene_of(small_and_near);
  const RigidObstacles obstacles(*scene);
  Random random(5);
  for (const RigidObstacle& obstacle : obstacles.all()) {
    for (int k = 0; k < 200; ++k) {
      const double size = k % 2 == 0 ? 0.1 : 1e4;
      const RigidPose start = random.pose(random.vector(size), 3, size);
      const RigidPose end = random.after(start, 1, 0.1);
      const bsi::Sphere sphere = obstacle.sphere(start, end);
      const Vec3 centre = Eigen::Vector3f(sphere.x, sphere.y, sphere.z).cast<double>();
      for (const Vec3& p : obstacle.held->start) {
        ASSERT_TRUE(obstacle.box(start).contains(start.place(p)));
        for (const RigidPose* pose : {&start, &end})
          ASSERT_LE((pose->place(p) - centre).norm(), static_cast<double>(sphere.radius));
      }
    }
  }
}

TEST(RigidObstacles, AreBodiesThatOneMotionCarries) {
  const auto scene = scene_of(met_by_two);
  const RigidObstacles obstacles(*scene);
  ASSERT_EQ(obstacles.all().size(), 2U);
  for (const RigidObstacle& obstacle : obstacles.all()) {
    EXPECT_FALSE(scene->bodies[obstacle.body].dynamic);
    EXPECT_EQ(obstacles.of_body(obstacle.body), obstacle.number);
    for (std::size_t i = 0; i < obstacle.held->particles.size(); ++i)
      ASSERT_EQ(obstacle.held->particles[i], obstacle.first_particle + static_cast<int>(i));
  }
  EXPECT_EQ(obstacles.of_body(0), -1);
}

}  // namespace
}  // namespace weft::sim::rigid_obstacles_test
