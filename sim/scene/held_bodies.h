// Bodies that count as obstacles: those whose every vertex is pinned, and those that sleep.
#pragma once

#include <span>
#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// Moves bodies that are held as a whole (scene.h), with their particles, behind those that are
// simulated. Sets the numbers of dynamic bodies and particles and the order of the case.
// Precondition: the scene has all bodies of the case and no obstacles yet. `pins` are those of all
// bodies: their particles are renumbered, and pins that hold a whole body at rest are dropped.
void put_held_bodies_last(Scene& scene, std::vector<PrescribedMotion>& pins);

// Moves the dynamic bodies marked in `is_held` (by body) behind the other dynamic ones, with their
// particles, and makes obstacles of them. Does nothing if all are marked, or none is. `pins` are
// the prescribed motions of the scene's particles, which are renumbered; pins at rest of held
// bodies are dropped.
void hold_bodies(Scene& scene, std::span<const char> is_held, std::vector<PrescribedMotion>& pins);

}  // namespace weft::sim
