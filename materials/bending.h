// Bending of a triangle of cloth from the angles of its three edges.
//
// The mid-edge second fundamental form (Grinspun et al. 2006, Computing discrete shape operators on
// general meshes) uses the mean normal of two triangles on their common edge. The curvature tensor
// of a triangle is then linear in the angles theta_i at its edges,
//   kappa = sum_i (theta_i - theta_i0) / h_i  m_i m_i^T.
// Here theta_i0 is the angle at rest and m_i the outward unit normal of edge i in the plane of the
// rest triangle. h_i = 2 A / l_i is the height over edge i. With t_i = theta_i - theta_i0, the
// energy of an isotropic plate is a quadratic form,
//   W = A D/2 [(1 - nu) tr(kappa^2) + nu tr(kappa)^2] = 1/2 t^T C t.
//
// Derivation of kappa: kappa is minus the gradient of the normal. The mean normal at the middle of
// edge i is the triangle's normal rotated by theta_i / 2 about the edge, which changes it by
// -theta_i / 2 m_i. The linear function that is 1 at the middle of edge i and 0 at the middles of
// the other edges has the gradient 2 m_i / h_i.
//
// Accuracy: for a quadratic deflection, the mean slope at the middle of an edge is exact if the two
// triangles of the edge form a parallelogram. Equilateral meshes, and uniform grids whose diagonals
// are all parallel, have only such inner edges. In triangles of these meshes without border edges,
// kappa and W are exact for every quadratic deflection. On other meshes W can be too large: by a
// factor of up to 1.5 on a square grid with alternating diagonals, or with both diagonals in each
// cell.
//
// A border edge has no angle. Its t_i takes the value that minimises W, so the edge transmits no
// moment. This eliminates t_i from W and condenses C.
#pragma once

#include <array>

#include "materials/strain_map.h"
#include "materials/types.h"

namespace weft::materials {

// Returns C of an isotropic plate, N m. It is symmetric positive semi-definite, with zero rows and
// columns for border edges. The forces are -sum_i (C t)_i d theta_i / d x, N. `rest` holds the
// positions of the nodes (m) as columns. `has_angle[i]` is false if the edge opposite node i is a
// border edge. `stiffness` is D in N m, not negative; -1 < poisson_ratio < 1. Precondition: the
// rest triangle has an area.
Mat3 triangle_bending_modulus(const Nodes3& rest, const std::array<bool, 3>& has_angle,
                              double stiffness, double poisson_ratio);

// Returns C of an orthotropic plate, N m, with the energy
//   W = A/2 kappa : D : kappa.
// The matrix D of `moduli` (N m) acts on (kappa_11, kappa_22, 2 kappa_12). Axis 1 is the projection
// of `warp` onto the triangle. Axis 2 is rotated from it by 90 degrees, counter-clockwise as the
// order of the nodes. Preconditions: the rest triangle has an area, `warp` is not normal to it, and
// D is positive definite.
Mat3 triangle_bending_modulus(const Nodes3& rest, const Vec3& warp,
                              const std::array<bool, 3>& has_angle,
                              const OrthotropicModuli& moduli);
// Returns the map from the angle changes t to the curvature (kappa_11, kappa_22, 2 kappa_12), 1/m,
// in the same axes, for laws that are not linear (curved_bending.h). The t_i of a border edge takes
// the value that minimises the W of the orthotropic plate. Its column of the map is therefore zero.
// Preconditions: as for the orthotropic plate.
StrainMapOf<double> bending_map(const Nodes3& rest, const Vec3& warp,
                                const std::array<bool, 3>& has_angle,
                                const OrthotropicModuli& moduli);

}  // namespace weft::materials
