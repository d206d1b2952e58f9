// Isotropic bending of a triangle from the angles of its three edges: the mid-edge second
// fundamental form (averaged normals) makes the curvature tensor of a triangle linear in its edge
// angles, kappa = sum_i g_i (theta_i - theta_i0), and the plate energy a quadratic form in them: W
// = A D/2 [(1 - nu) tr(kappa^2) + nu tr(kappa)^2] = 1/2 t^T C t with t_i = theta_i - theta_i0. On a
// border edge there is no angle; it takes the value that makes W least (no moment), which condenses
// C.
#pragma once

#include <array>

#include "materials/types.h"

namespace weft::materials {

// C in N m (rad^-2): symmetric positive semi-definite; rows and columns of border edges are zero.
// Rest positions as columns; entry i belongs to the edge opposite node i; `has_angle[i]` is false
// on the border. `stiffness` is D in N m.
Mat3 triangle_bending_modulus(const Nodes3& rest, const std::array<bool, 3>& has_angle,
                              double stiffness, double poisson_ratio);

}  // namespace weft::materials
