// Rigid motion prescribed for pins and obstacles.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "sim/case/case.h"

namespace weft::sim {

// x(t) = R(t) (x0 - centre) + centre + d(t). With keyframes each stretch between two frames is
// eased by 6 s^5 - 15 s^4 + 10 s^3, so that velocity and acceleration are continuous and zero at
// the frames. The rotation between two frames is a turn about one axis: where their rotation
// vectors are parallel (or one is zero), by the difference of their angles, however large;
// otherwise the shortest turn from one orientation to the other. A first frame after t = 0 is led
// up to from where the case puts the points.
class RigidMotion {
 public:
  RigidMotion() = default;
  // `centre` is used where the case names none.
  RigidMotion(const MotionCase& motion, const Vec3& centre);

  // Moves points and gives their velocities (m, m/s). Sizes must agree.
  void apply(double time, std::span<const Vec3> start, std::span<Vec3> position,
             std::span<Vec3> velocity) const;

 private:
  struct Key {
    double time = 0;
    Vec3 translation{0, 0, 0};
    Vec3 rotation{0, 0, 0};  // rotation vector, rad
  };
  struct Pose {
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    Vec3 translation{0, 0, 0};
    Vec3 velocity{0, 0, 0};
    Vec3 angular_velocity{0, 0, 0};  // rad/s
  };
  Pose pose(double time) const;
  Pose constant_velocity_pose(double time) const;
  Pose keyframe_pose(double time) const;

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
