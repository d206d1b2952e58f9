// Boxes around the obstacles that move, as far as sleeping bodies need to know of them.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// Contact does not search between obstacles, and a body that sleeps is one of them: these boxes
// tell when an obstacle that moves comes near it. Bodies that are held as a whole and move count as
// obstacles.
class MovingBoxes {
 public:
  // The scene must outlive the boxes.
  explicit MovingBoxes(const Scene& scene);

  // True if an obstacle that moves between the times `from` and `to` (s) may come within the range
  // of contact of a body in `box` (m) with the given thickness (m). Boxes decide: obstacles may
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
