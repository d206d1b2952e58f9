// The elastic laws of a material of cloth.
#pragma once

#include <optional>
#include <variant>

#include "materials/curved_bending.h"
#include "materials/measured_stretch.h"
#include "materials/strain_map.h"
#include "materials/stretch_curve.h"
#include "sim/case/case.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// Elastic laws of triangles in the axes of warp and weft. A StretchLaw is over the Green strain
// (E_11, E_22, 2 E_12), with moduli in N/m. A BendingLaw is over the curvature (kappa_11, kappa_22,
// 2 kappa_12), with moduli in N m.
using StretchLaw =
    std::variant<materials::LinearLaw, materials::CurvedStretch, materials::MeasuredStretch>;
using BendingLaw = std::variant<materials::LinearLaw, materials::CurvedBending>;

// Returns the law of the membrane; std::nullopt for shells, spring membranes and cloth without
// membrane stiffness.
std::optional<StretchLaw> stretch_law(const MaterialCase& material);
// Returns the law of bending; std::nullopt for shells and for cloth that does not resist bending.
std::optional<BendingLaw> bending_law(const MaterialCase& material);

// Returns the moduli of bending at zero curvature, N m. They are zero for cloth that does not
// resist bending.
materials::OrthotropicModuli flat_bending_moduli(const MaterialCase& material);

// Returns the direction of the warp in a triangle of a body's mesh, in the plane of the rest shape.
// The result is a vector (m) of any length. It lies along the rows of the image if the warp angle
// of the body is zero. A positive angle turns it towards the columns.
Vec3 warp_direction(const SceneBody& body, int triangle);

}  // namespace weft::sim
