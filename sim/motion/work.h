// The work of integration, counted and not timed: choices that depend on it are the same on every
// machine.
#pragma once

#include <algorithm>

#include "sim/base/statistics.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// The unit of work is an iteration of conjugate gradients with block-Jacobi, without contact, at
// 33^2 vertices. Iterations with multigrid take up to four times as long, and are not told apart.
inline constexpr double assembly_work = 5;
inline double evaluation_work(const Scene& scene) {
  double work = 0.3;
  for (const SceneBody& body : scene.bodies) {
    if (!body.dynamic) continue;
    const MaterialCase& material = *body.material;
    const bool drags = material.normal_drag > 0 || material.tangential_drag > 0;
    if (drags) work = std::max(work, 0.6);
    if (material.membrane == MembraneModel::springs) work = std::max(work, 1.0);
    if (material.bending_stiffness > 0) work = std::max(work, 1.2);
  }
  return work;
}
inline double work_of(const Scene& scene, const Counters& counters,
                      std::int64_t linear_iterations) {
  return static_cast<double>(linear_iterations) +
         assembly_work * static_cast<double>(counters.matrix_assemblies) +
         evaluation_work(scene) * static_cast<double>(counters.force_evaluations);
}

}  // namespace weft::sim
