// The surface points of a scene, on which contact acts.
#pragma once

#include "sim/scene/scene.h"

namespace weft::sim {

// Returns for each vertex a third of the total area (m^2) of the triangles around it.
std::vector<double> areas_around(const bsi::Mesh& mesh, std::span<const Vec3> vertices);

// Numbers the surface points of all bodies, joins the maps of the bodies into the map of the scene,
// computes the points that seams hold together and, with contact, the areas around the points. Must
// be called when particles have their final numbers, and again when they are renumbered. O(mesh).
void number_surface_points(Scene& scene);

}  // namespace weft::sim
