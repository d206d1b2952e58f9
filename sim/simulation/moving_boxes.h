// Boxes around moving obstacles, which show when an obstacle comes near a sleeping body.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// Detects moving obstacles near a sleeping body. Contact cannot detect them: it treats a sleeping
// body as an obstacle, and ignores pairs of obstacles. A body whose motion is wholly prescribed
// counts as an obstacle.
class MovingBoxes {
 public:
  // The scene must outlive the boxes.
  explicit MovingBoxes(const Scene& scene);

  // True if an obstacle that moves between the times `from` and `to` (s) may come within contact
  // range of a body in `box` (m) with this thickness (m). Conservative: only boxes are compared.
  // False if contact is disabled. O(obstacles that move).
  bool may_reach(const Eigen::AlignedBox3d& box, double thickness, double from, double to) const;

 private:
  struct Moving {
    const PrescribedMotion* held;
    Vec3 centre, half_extents;  // centre and half extents of the box at t = 0 (m)
    double thickness;           // m
  };
  double range_;  // contact.range (m)
  std::vector<Moving> moving_;
};

}  // namespace weft::sim
