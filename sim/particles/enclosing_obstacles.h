// Spheres that start within closed obstacles.
#pragma once

#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// Spheres of one group within one obstacle, at t = 0.
struct EnclosedSpheres {
  int group = 0, obstacle = 0;  // indices into Scene::bodies
  int count = 0;
};

// Returns the groups with spheres whose centres are inside an obstacle without borders. Inside
// means that the winding number of its surface is not 0. A sphere whose path never meets the
// surface stays there: that is meant in a drum, and hardly where balls should lie on a heap of
// stones. Precondition: no centre lies on an obstacle. O(spheres + triangles) where triangles are
// of similar size, and O(1) more for each triangle above a sphere.
std::vector<EnclosedSpheres> enclosed_spheres(const Scene& scene);

}  // namespace weft::sim
