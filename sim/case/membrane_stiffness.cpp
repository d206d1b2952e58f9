#include "sim/case/membrane_stiffness.h"

#include <algorithm>

#include "materials/stretch_curve.h"

namespace weft::sim {

namespace {

double largest_of(const std::optional<double>& stiffness,
                  const std::optional<StretchCurveCase>& curve) {
  if (!curve) return *stiffness;
  return materials::TensionCurve(curve->strains, curve->tensions).largest_stiffness();
}

}  // namespace

double largest_membrane_stiffness(const MaterialCase& material) {
  if (material.orthotropic_membrane) {
    const OrthotropicMembraneCase& membrane = *material.orthotropic_membrane;
    return std::max(largest_of(membrane.warp_stiffness, membrane.warp_curve),
                    largest_of(membrane.weft_stiffness, membrane.weft_curve));
  }
  if (material.measured_membrane) {
    const MeasuredMembraneCase& membrane = *material.measured_membrane;
    return membrane.factor *
           std::max(std::ranges::max(membrane.warp), std::ranges::max(membrane.weft));
  }
  return std::max(material.membrane_stiffness, material.structural_stiffness.value_or(0));
}

}  // namespace weft::sim
