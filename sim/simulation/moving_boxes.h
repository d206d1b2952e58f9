// Boxes around moving obstacles. They tell when an obstacle comes near a sleeping body.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// Detects moving obstacles near a sleeping body. Contact cannot: it treats a sleeping body as an
// obstacle, and does not search between obstacles. Bodies that are held as a whole and move count
// as obstacles.
class MovingBoxes {
 public:
  // The scene must outlive the boxes.
  explicit MovingBoxes(const Scene& scene);

  // True if an obstacle that moves between the times `from` and `to` (s) may come within contact
  // range of a body in `box` (m) with this thickness (m). Conservative: only boxes are compared.
  // O(obstacles that move).
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
