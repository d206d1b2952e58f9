// Makers of the forces of a scene. A maker of a single force may return null, which means that the
// scene does not need the force.
#pragma once

#include <memory>

#include "sim/forces/force.h"

namespace weft::sim {

struct MaterialCase;

// Returns the rest positions (m) of the particles of the dynamic bodies.
std::vector<Vec3> rest_positions(const Scene& scene);

std::unique_ptr<Force> make_membrane_force(const Scene& scene);      // membranes of triangles
std::unique_ptr<Force> make_strain_limit_force(const Scene& scene);  // limits of triangles' strains
std::unique_ptr<Force> make_spring_force(const Scene& scene);        // membranes of springs
std::unique_ptr<Force> make_bending_force(const Scene& scene);       // bending of cloth
std::unique_ptr<Force> make_shell_force(const Scene& scene);         // elasticity of spline shells
std::unique_ptr<Force> make_clamp_force(const Scene& scene);         // bending at clamped edges
std::unique_ptr<Force> make_support_force(const Scene& scene);       // springs of sliding supports
std::unique_ptr<Force> make_tie_force(const Scene& scene);           // springs of ties
std::unique_ptr<Force> make_seam_force(const Scene& scene);          // springs of seams
std::unique_ptr<Force> make_seam_bending(const Scene& scene);        // bending across seams
std::unique_ptr<Force> make_drag_force(const Scene& scene);          // drag of cloth in the wind
std::unique_ptr<Force> make_shell_drag_force(
    const Scene& scene);  // drag of spline shells in the wind
std::unique_ptr<Force> make_sphere_drag_force(const Scene& scene);  // drag of particles in the wind
std::unique_ptr<Force> make_load_force(const Scene& scene);         // applied loads

// Returns the bending force of all cloth that yields. Null if no dynamic body yields.
std::unique_ptr<Force> make_yielding_bending_force(const Scene& scene);
// Returns the bending force of all dynamic cloth with this material; null if no dynamic body has
// the material. Precondition: the bending stiffness of the material depends on the curvature.
std::unique_ptr<Force> make_curved_bending_force(const Scene& scene, const MaterialCase& material);
// Returns one membrane force for each material of dynamic bodies in which the tension is a
// nonlinear function of the strain.
std::vector<std::unique_ptr<Force>> make_fabric_membrane_forces(const Scene& scene);

}  // namespace weft::sim
