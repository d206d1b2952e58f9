// Turns dynamic bodies into obstacles: bodies held as a whole, and sleeping bodies.
#pragma once

#include <span>
#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// Makes obstacles of the bodies that are held as a whole (scene.h), and moves them with their
// particles behind all other bodies. Sets dynamic_bodies, dynamic_particles, heavy_particles and
// case_order of the scene. `pins` are the prescribed motions of all bodies. Their particles are
// renumbered, and pins of these obstacles that do not move are removed. If all bodies are held as a
// whole, all stay dynamic. Precondition: the scene has all bodies of the case and no obstacles yet.
void put_held_bodies_last(Scene& scene, std::vector<PrescribedMotion>& pins);

// Makes obstacles of the dynamic bodies with a nonzero mark in `is_held` (by body), and moves them
// with their particles behind the other dynamic bodies. Does nothing if all or none of the dynamic
// bodies are marked. `pins` are the prescribed motions of the scene. Their particles are
// renumbered, and pins of marked bodies that do not move are removed.
void hold_bodies(Scene& scene, std::span<const char> is_held, std::vector<PrescribedMotion>& pins);

}  // namespace weft::sim
