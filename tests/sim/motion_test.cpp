// Prescribed motions: velocities against differences, whole turns, and where they begin.
#include "sim/scene/motion.h"

#include <gtest/gtest.h>

#include <numbers>

namespace weft::sim {
namespace {

const std::vector<Vec3> corner{{1, 0, 0}, {0, 1, 0}, {0.3, -0.2, 0.7}};

struct Moved {
  std::vector<Vec3> position = corner, velocity = corner;
};

Moved at(const RigidMotion& motion, double time) {
  Moved moved;
  motion.apply(time, corner, moved.position, moved.velocity);
  return moved;
}

void expect_velocity_is_the_slope(const RigidMotion& motion, double time) {
  const double step = 1e-6;
  const Moved now = at(motion, time), before = at(motion, time - step),
              after = at(motion, time + step);
  for (std::size_t i = 0; i < corner.size(); ++i) {
    const Vec3 slope = (after.position[i] - before.position[i]) / (2 * step);
    EXPECT_LT((now.velocity[i] - slope).norm(), 1e-7) << "t = " << time;
  }
}

TEST(RigidMotion, VelocityIsTheSlopeOfThePosition) {
  MotionCase steady;
  steady.velocity = {0.1, 0.2, -0.3};
  steady.angular_velocity_deg = {30, -50, 70};
  steady.start_time = 0.5;
  steady.stop_time = 1.5;
  MotionCase keyed;
  keyed.keyframes = {{0.2, {0, 0, 0}, {0, 0, 0}},
                     {1.0, {0.5, 0, 1}, {0, 300, 0}},
                     {1.8, {0, 0, 1}, {40, 10, -20}}};
  for (double t : {0.1, 0.7, 1.2, 1.7}) {
    expect_velocity_is_the_slope(RigidMotion(steady, {0, 0, 0}), t);
    expect_velocity_is_the_slope(RigidMotion(keyed, {0.2, 0.1, 0}), t);
  }
}

TEST(RigidMotion, StandsStillOutsideItsTimes) {
  MotionCase steady;
  steady.velocity = {1, 0, 0};
  steady.start_time = 1;
  steady.stop_time = 2;
  const RigidMotion motion(steady, {0, 0, 0});
  EXPECT_EQ(at(motion, 0.5).position[0], corner[0]);
  EXPECT_EQ(at(motion, 0.5).velocity[0], Vec3(0, 0, 0));
  EXPECT_LT((at(motion, 3).position[0] - Vec3(2, 0, 0)).norm(), 1e-15);
  EXPECT_EQ(at(motion, 3).velocity[0], Vec3(0, 0, 0));
}

TEST(RigidMotion, AWholeTurnIsMade) {
  MotionCase keyed;
  keyed.keyframes = {{0, {0, 0, 0}, {0, 0, 0}}, {1, {0, 0, 0}, {0, 0, 360}}};
  const RigidMotion motion(keyed, {0, 0, 0});
  EXPECT_LT((at(motion, 0.5).position[0] - Vec3(-1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((at(motion, 1).position[0] - corner[0]).norm(), 1e-12);
}

TEST(RigidMotion, LeadsUpToAFirstKeyframe) {
  MotionCase keyed;
  keyed.keyframes = {{1, {2, 0, 0}, {0, 0, 90}}};
  const RigidMotion motion(keyed, {0, 0, 0});
  EXPECT_EQ(at(motion, 0).position[0], corner[0]);
  EXPECT_LT((at(motion, 1).position[0] - Vec3(2, 1, 0)).norm(), 1e-12);
}

TEST(RigidMotion, RotationVectorsTurnTheRightWay) {
  EXPECT_LT((rotation_from_degrees({0, 0, 90}) * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-15);
  EXPECT_LT((rotation_from_degrees(Vec3::Constant(120 / std::numbers::sqrt3)) * Vec3::UnitX() -
             Vec3::UnitY())
                .norm(),
            1e-12);
}

}  // namespace
}  // namespace weft::sim
