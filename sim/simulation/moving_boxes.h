// Boxes around moving obstacles, which tell when one comes near a sleeping body.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// Contact does not search between obstacles, and a sleeping body is one of them. These boxes tell
// when a moving obstacle comes near it. Bodies that are held as a whole and move count as
// obstacles.
class MovingBoxes {
 public:
  // The scene must outlive the boxes.
  explicit MovingBoxes(const Scene& scene);

  // True if an obstacle that moves between the times `from` and `to` (s) may come within contact's
  // range of a body in `box` (m) with this thickness (m). Only boxes are compared: the obstacle may
  // still be farther away. O(obstacles that move).
  bool may_reach(const Eigen::AlignedBox3d& box, double thickness, double from, double to) const;

 private:
  struct Moving {
    const PrescribedMotion* held;
    Vec3 centre, half_extents;  // m, of the box at t = 0
    double thickness;           // m
  };
  double range_;  // m, of contact
  std::vector<Moving> moving_;
};

}  // namespace weft::sim
