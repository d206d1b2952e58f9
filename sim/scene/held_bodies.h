// Bodies of which pins hold every vertex.
#pragma once

#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// Moves bodies that are held as a whole (scene.h) behind those that are simulated, with their
// particles, and sets the numbers of dynamic bodies and particles and the order of the case. To be
// called when all bodies of the case and no obstacles are there. `pins` are those of all bodies:
// their particles get their new numbers, and pins that hold a whole body at rest are dropped.
void put_held_bodies_last(Scene& scene, std::vector<PrescribedMotion>& pins);

}  // namespace weft::sim
