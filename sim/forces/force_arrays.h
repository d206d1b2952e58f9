// Makers of the force arrays. Each returns null if the scene does not need its force.
#pragma once

#include <memory>

#include "sim/forces/force.h"

namespace weft::sim {

struct MaterialCase;

// Returns the rest positions (m) of the particles of the dynamic bodies.
std::vector<Vec3> rest_positions(const Scene& scene);

std::unique_ptr<Force> make_membrane_force(const Scene& scene);      // triangles, by all their laws
std::unique_ptr<Force> make_strain_limit_force(const Scene& scene);  // of triangles
std::unique_ptr<Force> make_spring_force(const Scene& scene);  // structural, shear and bend springs
std::unique_ptr<Force> make_bending_force(const Scene& scene);  // from the angles of edges
std::unique_ptr<Force> make_shell_force(const Scene& scene);    // spline shells
std::unique_ptr<Force> make_clamp_force(
    const Scene& scene);  // bending at the edges that clamps hold
std::unique_ptr<Force> make_support_force(const Scene& scene);     // springs of sliding supports
std::unique_ptr<Force> make_tie_force(const Scene& scene);         // springs of ties
std::unique_ptr<Force> make_seam_force(const Scene& scene);        // springs of seams
std::unique_ptr<Force> make_seam_bending(const Scene& scene);      // bending across seams
std::unique_ptr<Force> make_drag_force(const Scene& scene);        // wind on triangles
std::unique_ptr<Force> make_shell_drag_force(const Scene& scene);  // wind on spline shells
std::unique_ptr<Force> make_load_force(const Scene& scene);        // loads from outside

// Parts of the bending force: of all materials that yield, and of a material whose stiffness
// depends on its curvature.
std::unique_ptr<Force> make_yielding_bending_force(const Scene& scene);
std::unique_ptr<Force> make_curved_bending_force(const Scene& scene, const MaterialCase& material);
// Parts of the membrane force: one for each material whose tension is not linear in its strain.
std::vector<std::unique_ptr<Force>> make_fabric_membrane_forces(const Scene& scene);

}  // namespace weft::sim
