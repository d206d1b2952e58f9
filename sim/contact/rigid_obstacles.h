// Obstacles that move as rigid bodies, and the positions of their surface points.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bsi/rigid_pyramid.h"
#include "bsi/sphere.h"
#include "sim/contact/body_tree.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// Returns an axis-aligned box (m) around a box that `pose` has moved. `middle` and `half` are the
// middle and the half extents of the box before the motion. The result is slightly larger than
// necessary.
BodyTree::Box box_around(const Vec3& middle, const Vec3& half, const RigidPose& pose);

// An obstacle of the case that moves, or a moving body held as a whole. One rigid motion carries
// all its points.
struct RigidObstacle {
  int number = 0;  // index in RigidObstacles::all()
  int body = 0;
  int first_particle = 0, first_point = 0;
  // Motion of the particles. Particle first_particle + i starts at held->start[i].
  const PrescribedMotion* held = nullptr;
  std::vector<Vec3> sampled_start;  // m, surface points at t = 0; empty if they are the particles
  // Middle and half extents of the box around the points at t = 0, m.
  Vec3 middle{0, 0, 0}, half{0, 0, 0};
  double radius = 0;

  // Returns the surface points at t = 0, m. start()[i] belongs to point first_point + i.
  const std::vector<Vec3>& start() const {
    return sampled_start.empty() ? held->start : sampled_start;
  }
  // Returns the surface points at t = 0 relative to the middle, m. The obstacle's pyramid is built
  // from them.
  std::vector<Vec3> own_positions() const;
  bsi::RigidFrame frame(const RigidPose& pose) const;
  // box() and sphere() return bounds of all points, m, slightly larger than necessary. The sphere
  // also contains the points on straight paths from `start` to `end`.
  BodyTree::Box box(const RigidPose& pose) const { return box_around(middle, half, pose); }
  bsi::Sphere sphere(const RigidPose& start, const RigidPose& end) const;
};

// All rigid obstacles of a scene that move.
class RigidObstacles {
 public:
  // The scene must outlive the object. O(points of moving obstacles).
  explicit RigidObstacles(const Scene& scene);

  std::span<const RigidObstacle> all() const { return all_; }
  // Returns the index of a body in all(), or -1 if it is not a moving rigid obstacle.
  int of_body(int body) const { return of_body_[body]; }
  // Sets poses[k] to the pose of obstacle k at `time` (s). Where a motion jumps, `before_jump`
  // selects the pose before the jump.
  void find_poses(double time, bool before_jump, std::vector<RigidPose>& poses) const;

 private:
  std::vector<RigidObstacle> all_;
  std::vector<int> of_body_;
};

// Positions of all surface points at one time, m. The points of rigid obstacles may be given by the
// poses of the obstacles instead. place() then computes single positions when they are needed. The
// time (s) helps the contact search to expect motions. A wrong one costs time, and nothing else.
class PlacedPoints {
 public:
  // Takes the positions of all points, without poses.
  PlacedPoints(std::span<const Vec3> position, double time = 0)  // NOLINT: implicit
      : position_(position), time_(time) {}
  // `poses` has one pose per obstacle of RigidObstacles::all(). place() writes positions of points
  // of these obstacles to `position`, and their velocities (m/s) to `velocity` unless it is empty.
  PlacedPoints(std::span<Vec3> position, std::span<Vec3> velocity, std::span<const RigidPose> poses,
               double time = 0)
      : position_(position), room_(position), velocity_(velocity), poses_(poses), time_(time) {}

  // Returns the positions. A point of an obstacle with a pose is valid only after place().
  std::span<const Vec3> position() const { return position_; }
  double time() const { return time_; }
  bool is_same(const PlacedPoints& other) const {
    return position_.data() == other.position_.data();
  }
  // Returns the pose of an obstacle, or null if its points are given. `obstacle` is its index in
  // RigidObstacles::all(); for -1 the result is null.
  const RigidPose* pose(int obstacle) const {
    return obstacle < 0 || poses_.empty() ? nullptr : &poses_[obstacle];
  }
  // Computes one point of an obstacle that has a pose.
  void place(const RigidObstacle& obstacle, int point) const {
    Vec3 rate;
    const Vec3& start = obstacle.start()[point - obstacle.first_point];
    poses_[obstacle.number].place(start, room_[point], velocity_.empty() ? rate : velocity_[point]);
  }
  void place_all(const RigidObstacle& obstacle) const;

 private:
  std::span<const Vec3> position_;
  std::span<Vec3> room_, velocity_;
  std::span<const RigidPose> poses_;
  double time_ = 0;
};

// Tells whether a number, such as the index of a point, occurs for the first time since begin().
class PlacedMarks {
 public:
  // Forgets all occurrences. Later numbers must be below `count`.
  void begin(int count);
  bool is_new(int number) {
    const bool is_first = mark_[number] != now_;
    mark_[number] = now_;
    return is_first;
  }

 private:
  std::vector<std::uint32_t> mark_;
  std::uint32_t now_ = 0;
};

}  // namespace weft::sim
