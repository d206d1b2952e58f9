// Shells that fall on other bodies: crossings of their curved surfaces, and the cost.
#pragma once

#include <span>

#include "sim/base/vectors.h"
#include "sim/case/case.h"
#include "sim/scene/scene.h"

namespace weft::bench {

// Returns the number of pairs of triangles that cross. Cloth and obstacles have their own
// triangles; shells have those between 6 x 6 points per element of their curved surface, far finer
// than the triangles of contact. `position` has all particles of the scene (m).
int surface_crossings(const sim::Scene& scene, std::span<const sim::Vec3> position);

struct ShellDrop {
  int crossings = 0;     // of the start and ten later times, all together
  bool touched = false;  // contact has acted
  double cpu_s = 0;      // of the simulation alone
};
// Runs the case to time.duration. Throws std::runtime_error if that fails.
ShellDrop drop_shell(const sim::Case& source);

}  // namespace weft::bench
