// Groups of spheres as bodies of a scene.
#pragma once

#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// Appends the groups of spheres of the case to the bodies of the scene, and then the spins of those
// that can turn, unless the method of impulses moves them, which keeps spins itself. Precondition:
// no obstacle has been added.
//
// The spin of a sphere of radius r and mass m is a particle with the velocity w = r omega, where
// omega is its angular velocity, and the mass 2/5 m, so that 1/2 (2/5 m) w^2 is the energy of its
// rotation. At t = 0 it is at the centre of the sphere. From there it moves by r times the angle
// turned. It has no weight, and only friction acts on it (Sliding, sim/contact/contact_pair.h).
//
// Throws CaseError if a file cannot be read, if a number in it is not finite, or if a region has no
// room for the random places.
void add_sphere_groups(Scene& scene);

// Mass of a spin as part of the mass of its sphere: moment of inertia by mass and radius squared.
constexpr double spin_mass_share = 0.4;

// Returns the radius (m) of each dynamic particle. Precondition: all dynamic bodies are groups of
// spheres.
std::vector<double> sphere_radii(const Scene& scene);

}  // namespace weft::sim
