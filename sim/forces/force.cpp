#include "sim/forces/force.h"

#include "sim/forces/force_arrays.h"

namespace weft::sim {

std::vector<std::unique_ptr<Force>> make_forces(const Scene& scene) {
  std::vector<std::unique_ptr<Force>> forces;
  for (auto* make : {make_membrane_force, make_spring_force, make_bending_force, make_drag_force}) {
    if (auto force = make(scene)) forces.push_back(std::move(force));
  }
  return forces;
}

}  // namespace weft::sim
