// Obstacles that move as rigid bodies, and where contact gets their vertices from.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bsi/rigid_pyramid.h"
#include "bsi/sphere.h"
#include "sim/contact/body_tree.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// A box around all that a pose makes of the box about `middle` with these half extents, m, a little
// larger than need be.
BodyTree::Box box_around(const Vec3& middle, const Vec3& half, const RigidPose& pose);

// A body that one motion carries: an obstacle of the case, or a body that is held as a whole.
struct RigidObstacle {
  int number = 0;  // in RigidObstacles::all()
  int body = 0;
  int first_particle = 0;
  const PrescribedMotion* held = nullptr;  // start[i] is that of particle first_particle + i
  // The box around its points at the start, m, and their largest distance from the middle of it.
  Vec3 middle{0, 0, 0}, half{0, 0, 0};
  double radius = 0;

  // The points at the start, about the middle: the frame of the obstacle's pyramid.
  std::vector<Vec3> own_positions() const;
  bsi::RigidFrame frame(const RigidPose& pose) const;
  // Boxes and spheres around all points, m, a little larger than need be.
  BodyTree::Box box(const RigidPose& pose) const { return box_around(middle, half, pose); }
  bsi::Sphere sphere(const RigidPose& start, const RigidPose& end) const;
};

// All rigid obstacles of a scene that move.
class RigidObstacles {
 public:
  // O(their particles). The scene must outlive it.
  explicit RigidObstacles(const Scene& scene);

  std::span<const RigidObstacle> all() const { return all_; }
  // The number of the obstacle that a body is, in all(), or -1.
  int of_body(int body) const { return of_body_[body]; }
  // Sets poses[k] to that of obstacle k.
  void find_poses(double time, bool before_jump, std::vector<RigidPose>& poses) const;

 private:
  std::vector<RigidObstacle> all_;
  std::vector<int> of_body_;
};

// Positions of all particles at one time, m. Those of rigid obstacles may be left out: poses say
// where these are, and their particles are put in place one by one as they are needed.
class PlacedParticles {
 public:
  // Everything is given.
  PlacedParticles(std::span<const Vec3> position) : position_(position) {}  // NOLINT: implicit
  // `poses`: of RigidObstacles::all(). The positions of these obstacles, and the velocities if
  // there are any, are written where they are needed.
  PlacedParticles(std::span<Vec3> position, std::span<Vec3> velocity,
                  std::span<const RigidPose> poses)
      : position_(position), room_(position), velocity_(velocity), poses_(poses) {}

  // In these, particles of obstacles with a pose are only where place() has put them.
  std::span<const Vec3> position() const { return position_; }
  bool is_same(const PlacedParticles& other) const {
    return position_.data() == other.position_.data();
  }
  // The pose of an obstacle, or null where its particles are given.
  const RigidPose* pose(int obstacle) const {
    return obstacle < 0 || poses_.empty() ? nullptr : &poses_[obstacle];
  }
  // Puts particles of an obstacle that has a pose in place.
  void place(const RigidObstacle& obstacle, int particle) const {
    Vec3 rate;
    const Vec3& start = obstacle.held->start[particle - obstacle.first_particle];
    poses_[obstacle.number].place(start, room_[particle],
                                  velocity_.empty() ? rate : velocity_[particle]);
  }
  void place_all(const RigidObstacle& obstacle) const;

 private:
  std::span<const Vec3> position_;
  std::span<Vec3> room_, velocity_;
  std::span<const RigidPose> poses_;
};

// Tells which particles, or other numbers, come for the first time since begin().
class PlacedMarks {
 public:
  // Numbers are below `count`.
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
