// Points outside the state that move rigidly with pins or obstacles.
#pragma once

#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// Points to which forces are anchored: the ghosts of clamps, and the places on obstacles to which
// vertices are tied.
class MovingPoints {
 public:
  // Adds a point at `start` (m) that moves with `held`, or rests if `held` does not move. Returns
  // the number of the point. `held` must outlive this object.
  int add(const PrescribedMotion& held, const Vec3& start) {
    return add(held.moves ? &held : nullptr, start);
  }
  int add(const PrescribedMotion* held, const Vec3& start);
  // Adds a point that a body which is not simulated carries along, and which is at `place` (m) at
  // the start of the scene. Returns its number. The scene must outlive this object.
  int add_on_body(const Scene& scene, const SceneBody& body, const Vec3& place);
  // True if a point moves.
  bool move() const { return !motions_.empty(); }
  // Sets positions and velocities of the points at `now`. Must be called before their first use if
  // move().
  void set_time(const Instant& now);
  const Vec3& position(int point) const { return position_[point]; }  // m
  const Vec3& velocity(int point) const { return velocity_[point]; }  // m/s

 private:
  std::vector<const PrescribedMotion*> motions_;
  std::vector<int> motion_of_;  // by point; -1: at rest
  std::vector<Vec3> start_, position_, velocity_;
};

}  // namespace weft::sim
