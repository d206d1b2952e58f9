// A contact of a rigid sphere.
#pragma once

#include <tuple>

#include "sim/base/vectors.h"

namespace weft::sim {

// A sphere that is near another sphere, or near a triangle of an obstacle.
struct SphereContact {
  int sphere = 0;        // index of the sphere
  int other = -1;        // index of the other sphere, or -1
  int surface = -1;      // index in SphereSurfaces, or -1
  int triangle = -1;     // triangle of the surface, or -1
  Vec3 normal{0, 0, 0};  // unit vector from the closest point of the other side to the sphere
  double gap = 0;        // m, distance of the surfaces, less half the thickness of an obstacle
  Vec3 drive{0, 0, 0};   // m/s, mean velocity of the obstacle's closest point during the step
  double restitution = 0, friction = 0;

  // Contacts with equal keys are one contact in two steps. Lists of contacts are sorted by key.
  std::tuple<int, int, int, int> key() const { return {surface, sphere, other, triangle}; }
};

}  // namespace weft::sim
