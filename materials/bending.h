// Isotropic bending of a triangle from the angles of its three edges: the mid-edge second
// fundamental form (averaged normals; Grinspun et al. 2006, Computing discrete shape operators on
// general meshes) makes the curvature tensor of a triangle linear in its edge angles,
//   kappa = sum_i (theta_i - theta_i0) / h_i  m_i m_i^T,
// with m_i the outward unit normal of edge i in the plane of the rest triangle and h_i = 2 A / l_i
// the height on it. Derivation: the averaged normal at the middle of edge i is the normal of the
// triangle turned by theta_i / 2 about the edge, a change of -theta_i / 2 m_i; the function that is
// linear on the triangle, 1 at that middle and 0 at the other two, has the gradient 2 m_i / h_i;
// and kappa is minus the gradient of the normal. The plate energy is then a quadratic form,
//   W = A D/2 [(1 - nu) tr(kappa^2) + nu tr(kappa)^2] = 1/2 t^T C t with t_i = theta_i - theta_i0.
//
// On meshes whose every edge is a diagonal of a parallelogram (a grid of one diagonal, an
// equilateral mesh) kappa is exact for every quadratic deflection, and W for every direction of
// bending: the averaged slope at the middle of an edge is there the true one. On other meshes it is
// not: on a square grid of alternating diagonals, or with a cross in each cell, W is up to 1.5
// times too large.
//
// On a border edge there is no angle; it takes the value that makes W least (no moment), which
// condenses C.
#pragma once

#include <array>

#include "materials/types.h"

namespace weft::materials {

// C in N m (rad^-2): symmetric positive semi-definite; rows and columns of border edges are zero.
// Rest positions as columns, m; entry i belongs to the edge opposite node i; `has_angle[i]` is
// false on the border. `stiffness` is D in N m, not negative; -1 < poisson_ratio < 1. Precondition:
// the rest triangle has an area. For setting up; the forces are sum_i -(C t)_i d theta_i / d x.
Mat3 triangle_bending_modulus(const Nodes3& rest, const std::array<bool, 3>& has_angle,
                              double stiffness, double poisson_ratio);

}  // namespace weft::materials
