// Points that rest or move rigidly with pins or obstacles, and are not part of the state.
#pragma once

#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// Points to which forces are attached, such as the ghosts of clamps and the points of obstacles to
// which vertices are tied.
class MovingPoints {
 public:
  // Adds a point whose place at t = 0 is `start` (m), and returns its index. The point moves with
  // `held`, which must outlive this object. It rests if `held` does not move or is null.
  int add(const PrescribedMotion& held, const Vec3& start) {
    return add(held.moves ? &held : nullptr, start);
  }
  int add(const PrescribedMotion* held, const Vec3& start);
  // Adds a point of a body that is not simulated and carries it along; it is at `place` (m) at the
  // start of the scene. Returns its number. The scene must outlive this object.
  int add_on_body(const Scene& scene, const SceneBody& body, const Vec3& place);
  // Returns true if any point was added with a motion.
  bool move() const { return !motions_.empty(); }
  // Sets the positions and velocities of all points at `now`. Must be called before position() and
  // velocity() if move().
  void set_time(const Instant& now);
  const Vec3& position(int point) const { return position_[point]; }  // m
  const Vec3& velocity(int point) const { return velocity_[point]; }  // m/s

 private:
  std::vector<const PrescribedMotion*> motions_;
  std::vector<int> motion_of_;                     // by point: index into motions_; -1: at rest
  std::vector<Vec3> start_, position_, velocity_;  // by point: m, m and m/s
};

}  // namespace weft::sim
