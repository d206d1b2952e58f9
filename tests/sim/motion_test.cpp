// Prescribed motions: velocities against differences of positions, full rotations, and starting
// poses.
#include "sim/scene/motion.h"

#include <gtest/gtest.h>

#include <numbers>

namespace weft::sim::motion_test {
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

TEST(RigidMotion, BoundsHoldForAllPointsAndTimes) {
  MotionCase steady;
  steady.velocity = {0.1, 0.2, -0.3};
  steady.angular_velocity_deg = {30, -50, 270};
  steady.start_time = 0.5;
  steady.stop_time = 1.5;
  MotionCase keyed;
  keyed.keyframes = {{0.2, {0, 0, 0}, {0, 0, 0}},
                     {1.0, {0.5, 0, 1}, {0, 300, 0}},
                     {1.8, {0, 0, 1}, {40, 10, -20}}};
  for (const MotionCase& from : {steady, keyed}) {
    const RigidMotion motion(from, {0.2, 0.1, 0});
    const double radius = motion.radius_of(corner);
    for (double start = 0; start < 2; start += 0.04) {
      for (const double length : {1e-3, 0.03, 0.2, 0.9}) {
        const MotionBounds bounds = motion.bounds(start, start + length, radius);
        const Moved begin = at(motion, start), end = at(motion, start + length);
        double stray = 0, travel = 0;
        for (double q = 0; q <= 1; q += 0.05) {
          const Moved now = at(motion, start + q * length);
          for (std::size_t i = 0; i < corner.size(); ++i) {
            const Vec3 chord = (1 - q) * begin.position[i] + q * end.position[i];
            stray = std::max(stray, (now.position[i] - chord).norm());
            travel = std::max(travel, (now.position[i] - begin.position[i]).norm());
          }
        }
        EXPECT_LE(stray, bounds.stray + 1e-14) << start << " + " << length;
        EXPECT_LE(travel, bounds.travel + 1e-14) << start << " + " << length;
        // The bounds are not so large that they would forbid every step.
        if (length < 0.01) {
          EXPECT_LE(bounds.stray, 3e-5);
        }
      }
    }
  }
}

TEST(RigidMotion, RatesAreTheSlopes) {
  MotionCase keyed;
  keyed.keyframes = {{0.2, {0, 0, 0}, {0, 0, 0}}, {1.0, {0.5, 0, 1}, {0, 300, 40}}};
  const RigidMotion motion(keyed, {0.2, 0.1, 0});
  const double step = 1e-6;
  Moved rates;
  motion.rates(0.5, corner, rates.position, rates.velocity);
  const Moved before = at(motion, 0.5 - step), now = at(motion, 0.5),
              after = at(motion, 0.5 + step);
  for (std::size_t i = 0; i < corner.size(); ++i) {
    EXPECT_EQ(rates.position[i], now.velocity[i]);
    const Vec3 slope = (after.velocity[i] - before.velocity[i]) / (2 * step);
    EXPECT_LT((rates.velocity[i] - slope).norm(), 1e-6 * slope.norm());
  }
}

TEST(RigidMotion, EventsAreStartsStopsAndKeyframes) {
  MotionCase steady;
  steady.velocity = {1, 0, 0};
  steady.start_time = 1;
  steady.stop_time = 2;
  const RigidMotion motion(steady, {0, 0, 0});
  EXPECT_EQ(motion.next_event(0)->time, 1);
  EXPECT_TRUE(motion.next_event(0)->jumps);
  EXPECT_EQ(motion.next_event(1)->time, 2);
  EXPECT_FALSE(motion.next_event(2));
  MotionCase keyed;
  keyed.keyframes = {{1, {2, 0, 0}, {0, 0, 90}}};
  EXPECT_EQ(RigidMotion(keyed, {0, 0, 0}).next_event(0.5)->time, 1);
  EXPECT_FALSE(RigidMotion(keyed, {0, 0, 0}).next_event(0.5)->jumps);
}

TEST(RigidMotion, RotationVectorsTurnTheRightWay) {
  EXPECT_LT((rotation_from_degrees({0, 0, 90}) * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-15);
  EXPECT_LT((rotation_from_degrees(Vec3::Constant(120 / std::numbers::sqrt3)) * Vec3::UnitX() -
             Vec3::UnitY())
                .norm(),
            1e-12);
}

}  // namespace
}  // namespace weft::sim::motion_test
