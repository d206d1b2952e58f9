// Rigid motion prescribed for pins and obstacles.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <vector>

#include "sim/case/case.h"

namespace weft::sim {

// Upper bounds of a rigid motion over an interval of time, for all points within a given radius of
// the centre.
struct MotionBounds {
  double angle = 0;         // rad, of the rotation
  double travel = 0;        // m, distance from a point's place at the start
  double stray = 0;         // m, distance from uniform motion along the chord of the path
  double acceleration = 0;  // m/s^2, apart from jumps of the velocity
};

// A time at which a prescribed motion or a curve is not smooth.
struct MotionEvent {
  double time = 0;     // s
  bool jumps = false;  // the velocity, or the value of the curve, is discontinuous
};

// A time (s) at which forces are evaluated. Values that jump are evaluated at `within` instead, a
// time after the start of the same step. `within` lies before a jump at the end of the step.
struct Instant {
  double time = 0;
  double within = 0;
};

// A rigid motion at one time. It maps the place of a point at t = 0 to the present place, velocity
// and acceleration of the point.
struct RigidPose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vec3 centre{0, 0, 0};                // m, at t = 0
  Vec3 translation{0, 0, 0};           // m
  Vec3 velocity{0, 0, 0};              // m/s, of the centre
  Vec3 angular_velocity{0, 0, 0};      // rad/s
  Vec3 acceleration{0, 0, 0};          // m/s^2, of the centre
  Vec3 angular_acceleration{0, 0, 0};  // rad/s^2

  // Computes the position (m) and the velocity (m/s) of the point that starts at `start` (m). Every
  // caller gets the same bits.
  void place(const Vec3& start, Vec3& position, Vec3& rate) const;
  Vec3 place(const Vec3& start) const;
  // Returns the start (m) that place() maps to `position`.
  Vec3 start_of(const Vec3& position) const;
};

// The motion x(t) = R(t) (x0 - centre) + centre + d(t), with constant velocities or through
// keyframes. The course between two keyframes is eased by 6 s^5 - 15 s^4 + 10 s^3. Velocity and
// acceleration are therefore continuous, and zero at the keyframes. The rotation between two
// keyframes is a turn about one axis. If their rotation vectors are parallel, or one is zero, it
// turns by the difference of their angles, however large. Otherwise it is the shortest turn from
// one orientation to the other. If the first keyframe is after t = 0, the motion starts at t = 0
// from the place in the case.
class RigidMotion {
 public:
  RigidMotion() = default;
  // `centre` is the default centre, used if the case gives none.
  RigidMotion(const MotionCase& motion, const Vec3& centre);

  // Returns the pose at a time (s). Where the velocity jumps, the pose has the velocity after the
  // jump, or before the jump if `before_jump`.
  RigidPose pose(double time, bool before_jump = false) const;
  // Computes positions (m) and velocities (m/s) of points from their starts (m). All spans have the
  // same size. `before_jump` as for pose().
  void apply(double time, std::span<const Vec3> start, std::span<Vec3> position,
             std::span<Vec3> velocity, bool before_jump = false) const;
  // Computes velocities (m/s) and accelerations (m/s^2) of points from their starts (m). All spans
  // have the same size. `before_jump` as for pose().
  void rates(double time, std::span<const Vec3> start, std::span<Vec3> velocity,
             std::span<Vec3> acceleration, bool before_jump = false) const;

  // Returns the first start, stop or keyframe after `time` (s), if any.
  std::optional<MotionEvent> next_event(double time) const;
  // Returns bounds from one time to a later one (s), for points whose distance from the centre at t
  // = 0 is at most `radius` (m). They hold across events in between. All are zero if nothing moves
  // in between.
  MotionBounds bounds(double from, double to, double radius) const;
  // For the moved point that is at `place` (m) at a time (s): velocity_at() returns its velocity
  // (m/s, after a jump), distance_from_centre() its distance from the centre at t = 0 (m).
  Vec3 velocity_at(double time, const Vec3& place) const;
  double distance_from_centre(double time, const Vec3& place) const;
  // Returns the largest distance (m) of these starts from the centre.
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
