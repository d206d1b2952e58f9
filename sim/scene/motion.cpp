#include "sim/scene/motion.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/scene/easing.h"

namespace weft::sim {

namespace {

constexpr double radians_per_degree = std::numbers::pi / 180.0;

Eigen::AngleAxisd angle_axis(const Vec3& rotation_vector) {
  const double angle = rotation_vector.norm();
  return {angle, angle > 0 ? Vec3(rotation_vector / angle) : Vec3(Vec3::UnitX())};
}

// Returns the rotation vector of the rotation from one orientation to another. Orientations are
// rotation vectors, too (rad). RigidMotion states which rotation is chosen.
Vec3 turn_between(const Vec3& from, const Vec3& to) {
  if (from.cross(to).norm() <= 1e-12 * from.norm() * to.norm()) return to - from;
  const Eigen::AngleAxisd shortest(Eigen::Quaterniond(angle_axis(to)) *
                                   Eigen::Quaterniond(angle_axis(from)).conjugate());
  return shortest.axis() * shortest.angle();
}

// largest_slope() and largest_curvature() return the largest slope of the easing and the largest
// magnitude of its second derivative for s in an interval. The slope rises up to s = 1/2 and then
// falls. The second derivative has its extremes, +-10 / sqrt(3), at (3 -+ sqrt(3)) / 6.
double largest_slope(double from, double to) { return eased_slope(std::clamp(0.5, from, to)); }
double largest_curvature(double from, double to) {
  double largest = std::max(std::abs(eased_curvature(from)), std::abs(eased_curvature(to)));
  for (const double sign : {-1.0, 1.0}) {
    const double extreme = (3 + sign * std::numbers::sqrt3) / 6;
    if (from < extreme && extreme < to) largest = std::max(largest, 10 / std::numbers::sqrt3);
  }
  return largest;
}

// Returns an upper bound (m) of the distance between two points of an arc. It is the smaller of the
// length of the arc and the diameter of its circle.
double arc_travel(double angle, double radius) { return radius * std::min(angle, 2.0); }

}  // namespace

Eigen::Matrix3d rotation_from_degrees(const Vec3& rotation_deg) {
  return angle_axis(rotation_deg * radians_per_degree).toRotationMatrix();
}

// Never inlined, so that every caller gets the same bits. Copies inlined into different callers
// might fuse different products and sums.
[[gnu::noinline]] void RigidPose::place(const Vec3& start, Vec3& position, Vec3& rate) const {
  const Vec3 arm = rotation * (start - centre);
  position = arm + centre + translation;
  rate = velocity + angular_velocity.cross(arm);
}

Vec3 RigidPose::place(const Vec3& start) const {
  Vec3 position, rate;
  place(start, position, rate);
  return position;
}

Vec3 RigidPose::start_of(const Vec3& position) const {
  return rotation.transpose() * (position - centre - translation) + centre;
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

RigidPose RigidMotion::pose(double time, bool before_jump) const {
  RigidPose pose = keys_.empty() ? constant_velocity_pose(time, before_jump) : keyframe_pose(time);
  pose.centre = centre_;
  return pose;
}

RigidPose RigidMotion::constant_velocity_pose(double time, bool before_jump) const {
  const double elapsed =
      std::clamp(time, start_time_, std::max(start_time_, stop_time_)) - start_time_;
  RigidPose pose;
  pose.rotation = angle_axis(angular_velocity_ * elapsed).toRotationMatrix();
  pose.translation = velocity_ * elapsed;
  if (before_jump ? time > start_time_ && time <= stop_time_
                  : time >= start_time_ && time < stop_time_) {
    pose.velocity = velocity_;
    pose.angular_velocity = angular_velocity_;
  }
  return pose;
}

RigidPose RigidMotion::keyframe_pose(double time) const {
  RigidPose pose;
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
  const double rate = eased_slope(s) / span, change = eased_curvature(s) / (span * span);
  const Vec3 turn = turn_between(from.rotation, to.rotation);
  const Vec3 way = to.translation - from.translation;
  pose.rotation = (angle_axis(turn * eased(s)) * angle_axis(from.rotation)).toRotationMatrix();
  pose.translation = from.translation + eased(s) * way;
  pose.velocity = rate * way;
  pose.angular_velocity = turn * rate;
  pose.acceleration = change * way;
  pose.angular_acceleration = turn * change;
  return pose;
}

void RigidMotion::apply(double time, std::span<const Vec3> start, std::span<Vec3> position,
                        std::span<Vec3> velocity, bool before_jump) const {
  assert(start.size() == position.size() && start.size() == velocity.size());
  const RigidPose now = pose(time, before_jump);
  for (std::size_t i = 0; i < start.size(); ++i) now.place(start[i], position[i], velocity[i]);
}

void RigidMotion::rates(double time, std::span<const Vec3> start, std::span<Vec3> velocity,
                        std::span<Vec3> acceleration, bool before_jump) const {
  assert(start.size() == velocity.size() && start.size() == acceleration.size());
  const RigidPose now = pose(time, before_jump);
  for (std::size_t i = 0; i < start.size(); ++i) {
    const Vec3 arm = now.rotation * (start[i] - centre_);
    const Vec3 turning = now.angular_velocity.cross(arm);
    velocity[i] = now.velocity + turning;
    acceleration[i] = now.acceleration + now.angular_acceleration.cross(arm) +
                      now.angular_velocity.cross(turning);
  }
}

std::optional<MotionEvent> RigidMotion::next_event(double time) const {
  for (const Key& key : keys_) {
    if (key.time > time) return MotionEvent{key.time, false};
  }
  if (!keys_.empty() || (velocity_.isZero(0) && angular_velocity_.isZero(0))) return std::nullopt;
  for (const double jump : {start_time_, stop_time_}) {
    if (jump > time && std::isfinite(jump)) return MotionEvent{jump, true};
  }
  return std::nullopt;
}

MotionBounds RigidMotion::bounds(double from, double to, double radius) const {
  return keys_.empty() ? constant_velocity_bounds(from, to, radius)
                       : keyframe_bounds(from, to, radius);
}

// `stray` is the smallest of three bounds. Each of them bounds the distance between a point and
// uniform motion along its chord, at all fractions q of an interval of length h:
// - 2 q (1 - q) h v if the speed is at most v. Its maximum is at q = 1/2.
// - q (1 - q) a h^2 / 2 if the acceleration is at most a during the whole interval. A point that
//   rests for a part of the interval is compared with one that moves on. This adds at most twice
//   the distance that the second point moves in that part.
// - The travel, which bounds the distance of every place on the path from both ends of the path.
MotionBounds RigidMotion::constant_velocity_bounds(double from, double to, double radius) const {
  const double begin = std::max(from, start_time_), end = std::min(to, stop_time_);
  if (!(begin < end)) return {};
  const double speed = velocity_.norm(), turn = angular_velocity_.norm();
  MotionBounds bounds;
  bounds.angle = turn * (end - begin);
  bounds.travel = speed * (end - begin) + arc_travel(bounds.angle, radius);
  bounds.acceleration = turn * turn * radius;
  const double h = to - from, fastest = speed + turn * radius;
  const double at_rest = begin - from + to - end;
  bounds.stray = std::min(
      {bounds.travel, fastest * h / 2, bounds.acceleration * h * h / 8 + 2 * fastest * at_rest});
  return bounds;
}

MotionBounds RigidMotion::keyframe_bounds(double from, double to, double radius) const {
  MotionBounds bounds;
  for (std::size_t k = 0; k + 1 < keys_.size(); ++k) {
    const double span = keys_[k + 1].time - keys_[k].time;
    const double s0 = std::clamp((from - keys_[k].time) / span, 0.0, 1.0);
    const double s1 = std::clamp((to - keys_[k].time) / span, 0.0, 1.0);
    if (!(s0 < s1)) continue;
    const double way = (keys_[k + 1].translation - keys_[k].translation).norm();
    const double turn = turn_between(keys_[k].rotation, keys_[k + 1].rotation).norm();
    const double part = std::max(0.0, eased(s1) - eased(s0));
    bounds.angle += turn * part;
    bounds.travel += way * part + arc_travel(turn * part, radius);
    const double rate = largest_slope(s0, s1) / span;
    bounds.acceleration = std::max(
        bounds.acceleration, (way + radius * turn) * largest_curvature(s0, s1) / (span * span) +
                                 radius * turn * turn * rate * rate);
  }
  bounds.stray = std::min(bounds.travel, bounds.acceleration * (to - from) * (to - from) / 8);
  return bounds;
}

Vec3 RigidMotion::velocity_at(double time, const Vec3& place) const {
  const RigidPose now = pose(time);
  return now.velocity + now.angular_velocity.cross(place - centre_ - now.translation);
}

double RigidMotion::distance_from_centre(double time, const Vec3& place) const {
  return (place - centre_ - pose(time).translation).norm();
}

double RigidMotion::radius_of(std::span<const Vec3> start) const {
  double largest = 0;
  for (const Vec3& place : start) largest = std::max(largest, (place - centre_).squaredNorm());
  return std::sqrt(largest);
}

}  // namespace weft::sim
