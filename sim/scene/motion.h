// Rigid motion prescribed for pins and obstacles.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <vector>

#include "sim/case/case.h"

namespace weft::sim {

// Upper bounds of the motion of points in an interval of time, over all points within a given
// radius.
struct MotionBounds {
  double angle = 0;         // rad, of the rotation
  double travel = 0;        // m, distance from a point's place at the start
  double stray = 0;         // m, distance from uniform motion along the chord
  double acceleration = 0;  // m/s^2, apart from jumps of the velocity
};

// A time at which a motion changes its course.
struct MotionEvent {
  double time = 0;     // s
  bool jumps = false;  // the velocity is discontinuous
};

// A time (s) at which forces are evaluated. If a value jumps at that time, the value on the side of
// `within` counts: another time in the same step, after its start.
struct Instant {
  double time = 0;
  double within = 0;
};

// A rigid motion at one time: the present places, velocities and accelerations of its points follow
// from their places at t = 0.
struct RigidPose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vec3 centre{0, 0, 0};
  Vec3 translation{0, 0, 0};
  Vec3 velocity{0, 0, 0};
  Vec3 angular_velocity{0, 0, 0};  // rad/s
  Vec3 acceleration{0, 0, 0};
  Vec3 angular_acceleration{0, 0, 0};  // rad/s^2

  // Moves one point (m) and gives its velocity (m/s). The bits are the same for every caller.
  void place(const Vec3& start, Vec3& position, Vec3& rate) const;
  Vec3 place(const Vec3& start) const;
  // Returns the point that place() puts at `position`, m.
  Vec3 start_of(const Vec3& position) const;
};

// x(t) = R(t) (x0 - centre) + centre + d(t). With keyframes each stretch between two frames is
// eased by 6 s^5 - 15 s^4 + 10 s^3, so that velocity and acceleration are continuous and zero at
// the frames. The rotation between two frames is a turn about one axis. If their rotation vectors
// are parallel (or one is zero), it turns by the difference of their angles, however large.
// Otherwise it is the shortest turn from one orientation to the other. If the first frame is after
// t = 0, the motion leads up to it from the place in the case.
class RigidMotion {
 public:
  RigidMotion() = default;
  // `centre` is the default centre, used if the case gives none.
  RigidMotion(const MotionCase& motion, const Vec3& centre);

  // Returns the pose at a time. Where the velocity jumps it has the one after the jump, or with
  // `before_jump` the one before.
  RigidPose pose(double time, bool before_jump = false) const;
  // Moves points and gives their velocities (m, m/s). Sizes must agree. Where the velocity jumps it
  // is the one after the jump, or with `before_jump` the one before.
  void apply(double time, std::span<const Vec3> start, std::span<Vec3> position,
             std::span<Vec3> velocity, bool before_jump = false) const;
  // Computes velocities (m/s) and accelerations (m/s^2).
  void rates(double time, std::span<const Vec3> start, std::span<Vec3> velocity,
             std::span<Vec3> acceleration, bool before_jump = false) const;

  // The first start, stop or keyframe after `time`, if any.
  std::optional<MotionEvent> next_event(double time) const;
  // Returns bounds for points up to `radius` (m) from the centre at t = 0, from one time to a later
  // one. They hold across any events in between. All are zero if nothing moves in between.
  MotionBounds bounds(double from, double to, double radius) const;
  // Velocity (m/s, after a jump) of a moved point that is at `place`, and its distance from the
  // centre at t = 0 (m).
  Vec3 velocity_at(double time, const Vec3& place) const;
  double distance_from_centre(double time, const Vec3& place) const;
  // Largest distance (m) of these points from the centre.
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

// Rotation by a rotation vector in degrees.
Eigen::Matrix3d rotation_from_degrees(const Vec3& rotation_deg);

}  // namespace weft::sim
