// Groups of spheres as bodies of a scene.
#pragma once

#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// Appends the groups of spheres of the case to the bodies of the scene. Precondition: no obstacle
// has been added. Throws CaseError if a file cannot be read, if a number in it is not finite, or if
// a region has no room for the random places.
void add_sphere_groups(Scene& scene);

// Returns the radius (m) of each dynamic particle. Precondition: all dynamic bodies are groups of
// spheres.
std::vector<double> sphere_radii(const Scene& scene);

}  // namespace weft::sim
