// Isotropic bending of a triangle from the angles of its three edges. The mid-edge second
// fundamental form (averaged normals; Grinspun et al. 2006, Computing discrete shape operators on
// general meshes) makes the curvature tensor of a triangle linear in its edge angles,
//   kappa = sum_i (theta_i - theta_i0) / h_i  m_i m_i^T,
// with m_i the outward unit normal of edge i in the plane of the rest triangle and h_i = 2 A / l_i
// the height on it. The plate energy is then a quadratic form,
//   W = A D/2 [(1 - nu) tr(kappa^2) + nu tr(kappa)^2] = 1/2 t^T C t with t_i = theta_i - theta_i0.
//
// Derivation of kappa: the averaged normal at the middle of edge i is the triangle's normal rotated
// by theta_i / 2 about the edge, which changes it by -theta_i / 2 m_i. The linear function that is
// 1 at that middle and 0 at the other two has the gradient 2 m_i / h_i. kappa is minus the gradient
// of the normal.
//
// On meshes whose every edge is a diagonal of a parallelogram, the averaged slope at the middle of
// an edge is exact. Examples are grids with one diagonal and equilateral meshes. There kappa is
// exact for every quadratic deflection, and W for every direction of bending. Elsewhere they are
// not: on a square grid with alternating diagonals, or with a cross in each cell, W is up to 1.5
// times too large.
//
// A border edge has no angle. Its t_i is set to the value that minimises W (no moment), which
// condenses C.
#pragma once

#include <array>

#include "materials/strain_map.h"
#include "materials/types.h"

namespace weft::materials {

// Returns C in N m (rad^-2): symmetric positive semi-definite, with zero rows and columns for
// border edges. The forces are sum_i -(C t)_i d theta_i / d x. Rest positions (m) are columns.
// Entry i belongs to the edge opposite node i; `has_angle[i]` is false on the border. `stiffness`
// is D in N m, not negative; -1 < poisson_ratio < 1. Precondition: the rest triangle has an area.
// Called once per triangle, at set-up.
Mat3 triangle_bending_modulus(const Nodes3& rest, const std::array<bool, 3>& has_angle,
                              double stiffness, double poisson_ratio);

// The same for an orthotropic plate, whose axis 1 lies along `warp`, a direction that is not normal
// to the triangle, and whose axis 2 is a quarter turn further, counter-clockwise as the nodes:
//   W = A/2 kappa : D : kappa,  D over (kappa_11, kappa_22, 2 kappa_12).
Mat3 triangle_bending_modulus(const Nodes3& rest, const Vec3& warp,
                              const std::array<bool, 3>& has_angle,
                              const OrthotropicModuli& moduli);
// Returns the map from the angles t to the curvature (kappa_11, kappa_22, 2 kappa_12) in these
// axes, for laws that are not linear (curved_bending.h). Angles of border edges count as the values
// that minimise the W above, so their columns are zero.
StrainMapOf<double> bending_map(const Nodes3& rest, const Vec3& warp,
                                const std::array<bool, 3>& has_angle,
                                const OrthotropicModuli& moduli);

}  // namespace weft::materials
