#include "sim/scene/motion.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <numbers>

namespace weft::sim {

namespace {

constexpr double radians_per_degree = std::numbers::pi / 180.0;

Eigen::AngleAxisd angle_axis(const Vec3& rotation_vector) {
  const double angle = rotation_vector.norm();
  return {angle, angle > 0 ? Vec3(rotation_vector / angle) : Vec3(Vec3::UnitX())};
}

// Rotation vector of the turn that leads from one orientation to another, both rotation vectors.
Vec3 turn_between(const Vec3& from, const Vec3& to) {
  if (from.cross(to).norm() <= 1e-12 * from.norm() * to.norm()) return to - from;
  const Eigen::AngleAxisd shortest(Eigen::Quaterniond(angle_axis(to)) *
                                   Eigen::Quaterniond(angle_axis(from)).conjugate());
  return shortest.axis() * shortest.angle();
}

}  // namespace

Eigen::Matrix3d rotation_from_degrees(const Vec3& rotation_deg) {
  return angle_axis(rotation_deg * radians_per_degree).toRotationMatrix();
}

RigidMotion::RigidMotion(const MotionCase& motion, const Vec3& centre)
    : centre_(motion.centre.value_or(centre)),
      velocity_(motion.velocity),
      angular_velocity_(motion.angular_velocity_deg * radians_per_degree),
      start_time_(motion.start_time),
      stop_time_(motion.stop_time.value_or(std::numeric_limits<double>::infinity())) {
  if (!motion.keyframes.empty() && motion.keyframes.front().time > 0) keys_.emplace_back();
  for (const KeyframeCase& key : motion.keyframes) {
    keys_.push_back({key.time, key.translation, key.rotation_deg * radians_per_degree});
  }
}

RigidMotion::Pose RigidMotion::pose(double time) const {
  return keys_.empty() ? constant_velocity_pose(time) : keyframe_pose(time);
}

RigidMotion::Pose RigidMotion::constant_velocity_pose(double time) const {
  const double elapsed =
      std::clamp(time, start_time_, std::max(start_time_, stop_time_)) - start_time_;
  Pose pose;
  pose.rotation = angle_axis(angular_velocity_ * elapsed).toRotationMatrix();
  pose.translation = velocity_ * elapsed;
  if (time >= start_time_ && time < stop_time_) {
    pose.velocity = velocity_;
    pose.angular_velocity = angular_velocity_;
  }
  return pose;
}

RigidMotion::Pose RigidMotion::keyframe_pose(double time) const {
  Pose pose;
  const auto after = std::upper_bound(keys_.begin(), keys_.end(), time,
                                      [](double t, const Key& key) { return t < key.time; });
  if (after == keys_.begin() || after == keys_.end()) {
    const Key& key = after == keys_.begin() ? keys_.front() : keys_.back();
    pose.rotation = angle_axis(key.rotation).toRotationMatrix();
    pose.translation = key.translation;
    return pose;
  }
  const Key& from = *(after - 1);
  const Key& to = *after;
  const double span = to.time - from.time;
  const double s = (time - from.time) / span;
  const double eased = s * s * s * (10 + s * (6 * s - 15));
  const double rate = 30 * s * s * (1 - s) * (1 - s) / span;
  const Vec3 turn = turn_between(from.rotation, to.rotation);
  pose.rotation = (angle_axis(turn * eased) * angle_axis(from.rotation)).toRotationMatrix();
  pose.translation = from.translation + eased * (to.translation - from.translation);
  pose.velocity = rate * (to.translation - from.translation);
  pose.angular_velocity = turn * rate;
  return pose;
}

void RigidMotion::apply(double time, std::span<const Vec3> start, std::span<Vec3> position,
                        std::span<Vec3> velocity) const {
  assert(start.size() == position.size() && start.size() == velocity.size());
  const Pose now = pose(time);
  for (std::size_t i = 0; i < start.size(); ++i) {
    const Vec3 arm = now.rotation * (start[i] - centre_);
    position[i] = arm + centre_ + now.translation;
    velocity[i] = now.velocity + now.angular_velocity.cross(arm);
  }
}

}  // namespace weft::sim
