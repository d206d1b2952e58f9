// The check of a scene's initial state.
#pragma once

#include <span>
#include <vector>

#include "sim/scene/scene.h"
#include "sim/view/crossings.h"

namespace weft::sim {

// Returns the surfaces on which contact acts, in the order of Scene::bodies, with their points at
// `points` (m, all points of the scene). The result refers to both arguments.
std::vector<CrossingSurface> contact_surfaces(const Scene& scene, std::span<const Vec3> points);

// Returns the pairs of triangles that may not intersect but do, with the points of surfaces at
// `points` (m). Surfaces are numbered as Scene::bodies. Pairs of obstacles, and pairs of triangles
// that seams hold together, may intersect.
std::vector<Crossing> forbidden_crossings(const Scene& scene, std::span<const Vec3> points);

// Throws CaseError if surfaces intersect or leave no gap in the initial state, if spheres overlap
// each other or an obstacle, or if a membrane exceeds its strain_limit. Obstacles may intersect
// each other, and a body without self_contact may intersect itself. The message lists the first
// intersections. If contact is disabled, only strain limits are checked.
void check_initial_state(const Scene& scene);

}  // namespace weft::sim
