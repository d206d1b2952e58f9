// Bodies that count as obstacles: those whose every vertex is pinned, and those that sleep.
#pragma once

#include <span>
#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// Moves bodies that are held as a whole (scene.h), with their particles, behind all other bodies.
// Sets dynamic_bodies, dynamic_particles and case_order of the scene. `pins` are the prescribed
// motions of all bodies. Their particles are renumbered, and pins that hold a whole body at rest
// are dropped. Precondition: the scene has all bodies of the case and no obstacles yet.
void put_held_bodies_last(Scene& scene, std::vector<PrescribedMotion>& pins);

// Makes obstacles of the dynamic bodies marked in `is_held` (by body), and moves them with their
// particles behind the other dynamic bodies. Does nothing if all are marked, or none is. `pins` are
// the prescribed motions of the scene. Their particles are renumbered, and pins at rest of held
// bodies are dropped.
void hold_bodies(Scene& scene, std::span<const char> is_held, std::vector<PrescribedMotion>& pins);

}  // namespace weft::sim
