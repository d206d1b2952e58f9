#include "sim/forces/force.h"

#include "sim/forces/force_arrays.h"
#include "sim/scene/scene.h"

namespace weft::sim {

std::vector<Vec3> rest_positions(const Scene& scene) {
  std::vector<Vec3> rest;
  rest.reserve(scene.dynamic_particles);
  for (int b = 0; b < scene.dynamic_bodies; ++b)
    rest.insert(rest.end(), scene.bodies[b].rest.begin(), scene.bodies[b].rest.end());
  return rest;
}

std::vector<std::unique_ptr<Force>> make_forces(const Scene& scene) {
  std::vector<std::unique_ptr<Force>> forces;
  for (auto* make : {make_membrane_force, make_strain_limit_force, make_spring_force,
                     make_bending_force, make_shell_force, make_clamp_force, make_seam_bending,
                     make_support_force, make_tie_force, make_seam_force, make_drag_force,
                     make_shell_drag_force, make_sphere_drag_force, make_load_force}) {
    if (auto force = make(scene)) forces.push_back(std::move(force));
  }
  return forces;
}

}  // namespace weft::sim
