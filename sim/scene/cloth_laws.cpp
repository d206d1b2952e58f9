#include "sim/scene/cloth_laws.h"

#include <cmath>

namespace weft::sim {

namespace {

using materials::CurvedBending;
using materials::CurvedStretch;
using materials::LinearLaw;
using materials::MeasuredStretch;
using materials::OrthotropicModuli;
using materials::TensionCurve;

OrthotropicModuli isotropic(double stiffness, double poisson_ratio) {
  return {stiffness, poisson_ratio * stiffness, stiffness, 0.5 * (1 - poisson_ratio) * stiffness};
}

TensionCurve tension_curve(const std::optional<double>& stiffness,
                           const std::optional<StretchCurveCase>& curve) {
  return curve ? TensionCurve(curve->strains, curve->tensions) : TensionCurve(*stiffness);
}

StretchLaw law_of(const OrthotropicMembraneCase& membrane) {
  if (membrane.has_curves()) {
    const auto& shear = membrane.shear_curve;
    return CurvedStretch{tension_curve(membrane.warp_stiffness, membrane.warp_curve),
                         tension_curve(membrane.weft_stiffness, membrane.weft_curve),
                         shear ? TensionCurve::mirrored(shear->strains, shear->tensions)
                               : TensionCurve(*membrane.shear_modulus)};
  }
  return LinearLaw{materials::orthotropic_moduli(*membrane.warp_stiffness, *membrane.weft_stiffness,
                                                 *membrane.shear_modulus, membrane.poisson_ratio)};
}

StretchLaw law_of(const MeasuredMembraneCase& membrane) {
  std::array<MeasuredStretch::Row, MeasuredStretch::row_count> rows;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i] = {membrane.factor * membrane.warp[i], membrane.factor * membrane.coupling[i],
               membrane.factor * membrane.weft[i], membrane.factor * membrane.shear[i]};
  }
  return MeasuredStretch(rows);
}

OrthotropicModuli bending_moduli_at(const MaterialCase& material, std::size_t i) {
  const OrthotropicBendingCase& bending = *material.orthotropic_bending;
  return materials::bending_moduli(bending.factor * bending.warp[i],
                                   bending.factor * bending.bias[i],
                                   bending.factor * bending.weft[i], material.poisson_ratio);
}

}  // namespace

std::optional<StretchLaw> stretch_law(const MaterialCase& material) {
  if (material.is_shell() || material.membrane != MembraneModel::triangles) return std::nullopt;
  if (material.orthotropic_membrane) return law_of(*material.orthotropic_membrane);
  if (material.measured_membrane) return law_of(*material.measured_membrane);
  if (material.membrane_stiffness == 0) return std::nullopt;
  const double nu = material.poisson_ratio;
  return LinearLaw{isotropic(material.membrane_stiffness / (1 - nu * nu), nu)};
}

std::optional<BendingLaw> bending_law(const MaterialCase& material) {
  if (material.is_shell() || !material.resists_bending()) return std::nullopt;
  if (!material.orthotropic_bending || material.orthotropic_bending->warp.size() == 1)
    return LinearLaw{flat_bending_moduli(material)};
  std::vector<OrthotropicModuli> moduli;
  for (std::size_t i = 0; i < material.orthotropic_bending->warp.size(); ++i)
    moduli.push_back(bending_moduli_at(material, i));
  return CurvedBending(material.orthotropic_bending->curvatures, moduli);
}

OrthotropicModuli flat_bending_moduli(const MaterialCase& material) {
  if (material.orthotropic_bending) return bending_moduli_at(material, 0);
  return isotropic(material.bending_stiffness, material.poisson_ratio);
}

Vec3 warp_direction(const SceneBody& body, int triangle) {
  const std::array<int, 3>& nodes = body.mesh.triangles[triangle];
  const auto edge = [&](int from, int to) -> Vec3 {
    return body.rest[nodes[to]] - body.rest[nodes[from]];
  };
  // The first triangle of a quad has the nodes (row, col), (row, col + 1), (row + 1, col). The
  // second has (row, col + 1), (row + 1, col + 1), (row + 1, col). The edge along the row therefore
  // joins nodes 0 and 1 of the first triangle, and nodes 2 and 1 of the second.
  const Vec3 along = triangle % 2 == 0 ? edge(0, 1) : edge(2, 1);
  if (body.warp_angle == 0) return along;
  const Vec3 normal = edge(0, 1).cross(edge(0, 2)).normalized();
  return std::cos(body.warp_angle) * along + std::sin(body.warp_angle) * normal.cross(along);
}

}  // namespace weft::sim
