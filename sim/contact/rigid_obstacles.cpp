#include "sim/contact/rigid_obstacles.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace weft::sim {

namespace {

// Relative allowance that exceeds the rounding in float64.
constexpr double beyond_rounding = 1e-12;

}  // namespace

BodyTree::Box box_around(const Vec3& middle, const Vec3& half, const RigidPose& pose) {
  const Vec3 centre = pose.place(middle), reach = pose.rotation.cwiseAbs() * half;
  const double room = beyond_rounding * (middle.norm() + centre.norm() + reach.norm());
  const Vec3 extent = reach + Vec3::Constant(room);
  return {centre - extent, centre + extent};
}

std::vector<Vec3> RigidObstacle::own_positions() const {
  std::vector<Vec3> own;
  own.reserve(start().size());
  for (const Vec3& p : start()) own.emplace_back(p - middle);
  return own;
}

bsi::RigidFrame RigidObstacle::frame(const RigidPose& pose) const {
  return {pose.rotation, pose.place(middle)};
}

bsi::Sphere RigidObstacle::sphere(const RigidPose& start, const RigidPose& end) const {
  const Vec3 first = start.place(middle), last = end.place(middle);
  const Eigen::Vector3f centre = (0.5 * (first + last)).cast<float>();
  const double largest =
      radius + 0.5 * (last - first).norm() + 1e-6 * (first.norm() + last.norm() + radius);
  return {centre[0], centre[1], centre[2],
          std::nextafter(static_cast<float>(largest), std::numeric_limits<float>::infinity())};
}

RigidObstacles::RigidObstacles(const Scene& scene) : of_body_(scene.bodies.size(), -1) {
  for (const PrescribedMotion& held : scene.prescribed) {
    if (!held.moves || held.particles.empty()) continue;
    const int body = scene.body_index_of_particle(held.particles.front());
    if (scene.bodies[body].dynamic) continue;
    RigidObstacle obstacle;
    obstacle.number = static_cast<int>(all_.size());
    obstacle.body = body;
    obstacle.first_particle = scene.bodies[body].first_particle;
    obstacle.first_point = scene.bodies[body].first_point;
    obstacle.held = &held;
    if (const auto& sampled = scene.bodies[body].sampled)
      sampled->map.points_of(held.start, scene.bodies[body].point_count(), obstacle.sampled_start);
    BodyTree::Box box;
    for (const Vec3& p : obstacle.start()) box.extend(p);
    obstacle.middle = box.center();
    obstacle.half = 0.5 * box.sizes() * (1 + beyond_rounding);
    for (const Vec3& p : obstacle.start())
      obstacle.radius = std::max(obstacle.radius, (p - obstacle.middle).norm());
    of_body_[body] = obstacle.number;
    all_.push_back(obstacle);
  }
}

void RigidObstacles::find_poses(double time, bool before_jump,
                                std::vector<RigidPose>& poses) const {
  poses.clear();
  for (const RigidObstacle& obstacle : all_)
    poses.push_back(obstacle.held->motion.pose(time, before_jump));
}

void PlacedPoints::place_all(const RigidObstacle& obstacle) const {
  const int count = static_cast<int>(obstacle.start().size());
  for (int i = 0; i < count; ++i) place(obstacle, obstacle.first_point + i);
}

void PlacedMarks::begin(int count) {
  mark_.resize(count, now_);
  if (++now_ != 0) return;
  std::fill(mark_.begin(), mark_.end(), 0);
  now_ = 1;
}

}  // namespace weft::sim
