// Bodies whose every vertex is pinned.
#pragma once

#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// Moves bodies that are held as a whole (scene.h), with their particles, behind those that are
// simulated. Sets the numbers of dynamic bodies and particles and the order of the case.
// Precondition: the scene has all bodies of the case and no obstacles yet. `pins` are those of all
// bodies: their particles are renumbered, and pins that hold a whole body at rest are dropped.
void put_held_bodies_last(Scene& scene, std::vector<PrescribedMotion>& pins);

}  // namespace weft::sim
