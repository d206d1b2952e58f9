// The laws of elasticity of a cloth's material.
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

// The law over (E_11, E_22, 2 E_12) in the axes of warp and weft (N/m), and that over the curvature
// (N m), of triangles.
using StretchLaw =
    std::variant<materials::LinearLaw, materials::CurvedStretch, materials::MeasuredStretch>;
using BendingLaw = std::variant<materials::LinearLaw, materials::CurvedBending>;

// Returns nothing for shells, membranes of springs and cloth without stiffness.
std::optional<StretchLaw> stretch_law(const MaterialCase& material);
// Returns nothing for shells and for cloth that does not resist bending.
std::optional<BendingLaw> bending_law(const MaterialCase& material);

// The moduli of bending at zero curvature; zero for cloth that does not resist bending.
materials::OrthotropicModuli flat_bending_moduli(const MaterialCase& material);

// Returns the largest stiffness of cloth in its plane, N/m: of triangles, or of springs along rows
// and columns.
double largest_membrane_stiffness(const MaterialCase& material);

// Returns the direction of the warp in a triangle of a body's mesh, in the plane of its rest shape:
// along the rows of the image, turned by the body's warp angle towards the columns. It is not of
// unit length.
Vec3 warp_direction(const SceneBody& body, int triangle);

}  // namespace weft::sim
