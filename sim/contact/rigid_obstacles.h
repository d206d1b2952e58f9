// Obstacles that move as rigid bodies, and the positions of their vertices for contact.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bsi/rigid_pyramid.h"
#include "bsi/sphere.h"
#include "sim/contact/body_tree.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// Returns an axis-aligned box (m) around the box with this middle and these half extents after
// `pose` has moved it. The result is slightly larger than necessary.
BodyTree::Box box_around(const Vec3& middle, const Vec3& half, const RigidPose& pose);

// An obstacle that a single motion carries: an obstacle of the case, or a body held as a whole.
struct RigidObstacle {
  int number = 0;  // index in RigidObstacles::all()
  int body = 0;
  int first_particle = 0, first_point = 0;
  const PrescribedMotion* held = nullptr;  // start[i] belongs to particle first_particle + i
  std::vector<Vec3> sampled_start;         // of surface points; empty if these are the particles
  // The box around the points at the start, and the largest distance of a point from its middle, m.
  Vec3 middle{0, 0, 0}, half{0, 0, 0};
  double radius = 0;

  // Returns the surface points at the start, m: start()[i] belongs to point first_point + i.
  const std::vector<Vec3>& start() const {
    return sampled_start.empty() ? held->start : sampled_start;
  }
  // Returns the points at the start relative to the middle, m. The obstacle's pyramid is built from
  // these points.
  std::vector<Vec3> own_positions() const;
  bsi::RigidFrame frame(const RigidPose& pose) const;
  // Return boxes and spheres around all points, m, slightly larger than necessary. A sphere covers
  // the path between two poses.
  BodyTree::Box box(const RigidPose& pose) const { return box_around(middle, half, pose); }
  bsi::Sphere sphere(const RigidPose& start, const RigidPose& end) const;
};

// All rigid obstacles of a scene that move.
class RigidObstacles {
 public:
  // O(points of these obstacles). The scene must outlive the object.
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

// Positions of all surface points at one time, m. Points of rigid obstacles may be missing if their
// poses are given instead. Single points are then placed when they are needed.
class PlacedPoints {
 public:
  // All positions are given.
  PlacedPoints(std::span<const Vec3> position) : position_(position) {}  // NOLINT: implicit
  // `poses` are those of RigidObstacles::all(). place() writes the positions of points of these
  // obstacles, and their velocities (m/s) unless `velocity` is empty.
  PlacedPoints(std::span<Vec3> position, std::span<Vec3> velocity, std::span<const RigidPose> poses)
      : position_(position), room_(position), velocity_(velocity), poses_(poses) {}

  // Returns the positions. A point of an obstacle with a pose is valid only after place().
  std::span<const Vec3> position() const { return position_; }
  bool is_same(const PlacedPoints& other) const {
    return position_.data() == other.position_.data();
  }
  // Returns the pose of an obstacle (index in RigidObstacles::all() or -1), or null if its points
  // are given.
  const RigidPose* pose(int obstacle) const {
    return obstacle < 0 || poses_.empty() ? nullptr : &poses_[obstacle];
  }
  // Places one point of an obstacle that has a pose.
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
};

// Detects the first occurrence of each number since begin(), for example of a point.
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
