// The obstacles that spheres collide with.
#pragma once

#include <span>
#include <vector>

#include "bsi/pyramid.h"
#include "bsi/traversal.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// The surface of an obstacle in its frame at t = 0, with a pyramid that is built once.
struct ObstacleSurface {
  int body = 0;                // index into Scene::bodies
  const RigidMotion* motion;   // null if the obstacle rests
  std::vector<Vec3> vertices;  // m, at t = 0
  const bsi::Mesh* mesh;       // triangles of the vertices
  double half_thickness = 0;   // m
  double radius = 0;           // m, of the vertices about the centre of the motion; 0 at rest
  bsi::Pyramid pyramid;
};

class SphereSurfaces {
 public:
  // The scene must outlive the object. O(vertices of obstacles).
  explicit SphereSurfaces(const Scene& scene);

  std::span<const ObstacleSurface> all() const { return all_; }
  int count() const { return static_cast<int>(all_.size()); }
  // Returns the poses of all surfaces at `time` (s). Where velocities jump, they are those after
  // the jump, or before it if `before_jump`.
  std::vector<RigidPose> poses(double time, bool before_jump = false) const;

 private:
  std::vector<ObstacleSurface> all_;
};

}  // namespace weft::sim
