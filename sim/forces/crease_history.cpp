#include "sim/forces/crease_history.h"

#include <algorithm>

#include "sim/scene/scene.h"

namespace weft::sim {

materials::YieldLaw yield_law_of(const materials::Nodes3& rest, const MaterialCase& material) {
  if (!material.yields()) return {};
  const double area = 0.5 * (rest.col(1) - rest.col(0)).cross(rest.col(2) - rest.col(0)).norm();
  return materials::make_yield_law(area, material.bending_stiffness, *material.yield_curvature,
                                   material.hardening.value_or(0));
}

bool has_yielding_bodies(const Scene& scene) {
  return std::ranges::any_of(
      scene.bodies, [](const SceneBody& body) { return body.dynamic && body.material->yields(); });
}

CreaseHistory::CreaseHistory(const Scene& scene) : first_{0} {
  for (std::size_t i = 0; i < scene.source.body.size(); ++i) {
    const SceneBody& body = scene.bodies[scene.case_order[i]];
    first_.push_back(first_.back() + (body.material->yields() ? body.mesh.triangles.size() : 0));
  }
  static_cast<StepHistory&>(*this) = StepHistory(Creases(first_.back()));
}

std::span<const materials::Crease> CreaseHistory::of_body(int case_body) const {
  return std::span(selected()).subspan(first_[case_body], count_of(case_body));
}

void CreaseHistory::transfer(StateArchive& archive) {
  StepHistory::transfer(archive, [&](Creases& creases) {
    for (materials::Crease& crease : creases) archive(crease.angles, crease.curvature);
  });
}

}  // namespace weft::sim
