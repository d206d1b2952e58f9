// Rigid motions that a case prescribes for pins and obstacles.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <vector>

#include "sim/case/case.h"

namespace weft::sim {

// Upper bounds for a rigid motion during an interval of time. They hold for all points within a
// given radius of the centre of the motion.
struct MotionBounds {
  double angle = 0;   // rad, angle of the rotation
  double travel = 0;  // m, distance of a point from its place at the start of the interval
  double stray = 0;   // m, distance of a point from uniform motion along the chord of its path
  double acceleration = 0;  // m/s^2, acceleration of a point, apart from jumps of the velocity
};

// A time at which a prescribed motion or a curve is not smooth.
struct MotionEvent {
  double time = 0;     // s
  bool jumps = false;  // true if the velocity, or the value of the curve, jumps
};

// A time (s) at which forces are evaluated. Values that jump are evaluated at `within` instead, a
// time within the same step. If a value jumps at the end of the step, `within` lies before the
// jump.
struct Instant {
  double time = 0;
  double within = 0;
};

// The state of a rigid motion at one time. It maps the place of a point at t = 0 to the present
// place, velocity and acceleration of the point.
struct RigidPose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vec3 centre{0, 0, 0};                // m, place of the centre of rotation at t = 0
  Vec3 translation{0, 0, 0};           // m
  Vec3 velocity{0, 0, 0};              // velocity of the centre, m/s
  Vec3 angular_velocity{0, 0, 0};      // rad/s
  Vec3 acceleration{0, 0, 0};          // acceleration of the centre, m/s^2
  Vec3 angular_acceleration{0, 0, 0};  // rad/s^2

  // Computes the position (m) and the velocity (m/s) of the point whose place at t = 0 is `start`
  // (m). Every caller gets the same bits.
  void place(const Vec3& start, Vec3& position, Vec3& rate) const;
  Vec3 place(const Vec3& start) const;
  // Returns the place at t = 0 (m) that place() maps to `position` (m).
  Vec3 start_of(const Vec3& position) const;
};

// The motion x(t) = R(t) (x0 - centre) + centre + d(t), with constant velocities or with keyframes.
// The change between two keyframes is eased by 6 s^5 - 15 s^4 + 10 s^3. Velocity and acceleration
// are therefore continuous, and zero at the keyframes. If the first keyframe is after t = 0, the
// motion starts at t = 0 without translation or rotation.
//
// The rotation between two keyframes is about one axis. If the rotation vectors of the keyframes
// are parallel, or one of them is zero, its rotation vector is their difference, however long.
// Otherwise it is the shortest rotation from one orientation to the other.
class RigidMotion {
 public:
  RigidMotion() = default;
  // `centre` (m) is the centre of the motion if the case gives none.
  RigidMotion(const MotionCase& motion, const Vec3& centre);

  // Returns the pose at a time (s). Where the velocity jumps, the pose has the velocity after the
  // jump, or before the jump if `before_jump`.
  RigidPose pose(double time, bool before_jump = false) const;
  // Computes the positions (m) and velocities (m/s) of points at `time` (s). `start` has the places
  // of the points at t = 0 (m). All spans have the same size. `before_jump` as for pose().
  void apply(double time, std::span<const Vec3> start, std::span<Vec3> position,
             std::span<Vec3> velocity, bool before_jump = false) const;
  // Computes the velocities (m/s) and accelerations (m/s^2) of points at `time` (s). `start` has
  // the places of the points at t = 0 (m). All spans have the same size. `before_jump` as for
  // pose().
  void rates(double time, std::span<const Vec3> start, std::span<Vec3> velocity,
             std::span<Vec3> acceleration, bool before_jump = false) const;

  // Returns the first start of motion, stop or keyframe after `time` (s), if any.
  std::optional<MotionEvent> next_event(double time) const;
  // Returns bounds for the interval from `from` to `to` (s), for points whose distance from the
  // centre at t = 0 is at most `radius` (m). They also hold if the interval contains events. All
  // are zero if nothing moves during the interval.
  MotionBounds bounds(double from, double to, double radius) const;
  // velocity_at() returns the velocity (m/s) of the moved point that is at `place` (m) at a time
  // (s). Where the velocity jumps, it is the velocity after the jump. distance_from_centre()
  // returns the distance (m) of the same point from the centre.
  Vec3 velocity_at(double time, const Vec3& place) const;
  double distance_from_centre(double time, const Vec3& place) const;
  // Returns the largest distance (m) of the places `start` from the centre.
  double radius_of(std::span<const Vec3> start) const;

 private:
  struct Key {
    double time = 0;
    Vec3 translation{0, 0, 0};
    Vec3 rotation{0, 0, 0};  // rotation vector, rad
  };
  RigidPose constant_velocity_pose(double time, bool before_jump) const;
  RigidPose keyframe_pose(double time) const;
  MotionBounds constant_velocity_bounds(double from, double to, double radius) const;
  MotionBounds keyframe_bounds(double from, double to, double radius) const;

  Vec3 centre_{0, 0, 0};
  Vec3 velocity_{0, 0, 0};
  Vec3 angular_velocity_{0, 0, 0};  // rad/s
  double start_time_ = 0;
  double stop_time_ = 0;
  std::vector<Key> keys_;
};

// Returns the rotation by a rotation vector (axis times angle) in degrees.
Eigen::Matrix3d rotation_from_degrees(const Vec3& rotation_deg);

}  // namespace weft::sim
