#include "sim/forces/force_arrays.h"
#include "sim/forces/force_group.h"
#include "sim/forces/linear_bending.h"

namespace weft::sim {

namespace {

bool is_curved(const MaterialCase& material) {
  return material.orthotropic_bending && material.orthotropic_bending->warp.size() > 1;
}

std::unique_ptr<Force> make_linear_bending_force(const Scene& scene) {
  const BendingQuads quads = bending_quads(scene, [](const MaterialCase& material) {
    return !is_curved(material) && !material.yields();
  });
  if (quads.nodes.empty()) return nullptr;
  return std::make_unique<BendingForce<LinearBending>>(quads, linear_batches<LinearBending>(quads),
                                                       rest_positions(scene));
}

}  // namespace

std::unique_ptr<Force> make_bending_force(const Scene& scene) {
  std::vector<std::unique_ptr<Force>> members;
  members.push_back(make_linear_bending_force(scene));
  members.push_back(make_yielding_bending_force(scene));
  for (const MaterialCase& material : scene.source.material) {
    if (is_curved(material)) members.push_back(make_curved_bending_force(scene, material));
  }
  return grouped(std::move(members));
}

}  // namespace weft::sim
