// Spheres of bodies' pyramids, and surfaces that represent them.
#pragma once

#include <span>
#include <vector>

#include "sim/view/rendered_body.h"

namespace weft::sim {

// Sets RenderedBody::spheres and RenderedBody::touching_spheres of all bodies, for one level of
// their pyramids. A patch with fewer levels uses its last level. Precondition: the pyramids are
// built and hold spheres.
void surround_bodies(int level, std::vector<RenderedBody>& bodies);

// Returns triangulated spheres of these radii (m), at as many centres (m). Each has equally many
// points, which follow each other.
SphereSurface surface_of_spheres(std::span<const Vec3> centres, std::span<const double> radii);

// Sets RenderedBody::spheres of a group of particles, which are its particles at the present
// positions.
void draw_particles(RenderedBody& body);

// Returns the spheres of one level of a body's pyramid. A patch with fewer levels uses its last
// level. Precondition: the pyramid is built and holds spheres.
std::vector<bsi::Sphere> spheres_of_level(const bsi::Pyramid& pyramid, int level);

}  // namespace weft::sim
