// Bending of a triangle of cloth from the angles of its three edges.
//
// The mid-edge second fundamental form (Grinspun et al. 2006, Computing discrete shape operators on
// general meshes) takes the mean normal of two triangles on their common edge. It makes the
// curvature tensor of a triangle linear in its edge angles theta_i,
//   kappa = sum_i (theta_i - theta_i0) / h_i  m_i m_i^T.
// Here theta_i0 is the angle at rest and m_i the outward unit normal of edge i in the plane of the
// rest triangle. h_i = 2 A / l_i is the height over edge i. With t_i = theta_i - theta_i0, the
// energy of an isotropic plate is a quadratic form,
//   W = A D/2 [(1 - nu) tr(kappa^2) + nu tr(kappa)^2] = 1/2 t^T C t.
//
// Derivation of kappa: the mean normal at the middle of edge i is the triangle's normal rotated by
// theta_i / 2 about the edge. The rotation changes it by -theta_i / 2 m_i. The linear function that
// is 1 at this middle and 0 at the middles of the other edges has the gradient 2 m_i / h_i. kappa
// is minus the gradient of the normal.
//
// Accuracy: the mean slope at the middle of an edge is exact if the edge is the diagonal of a
// parallelogram. Grids with one diagonal and equilateral meshes have only such edges. On them,
// kappa is exact for every quadratic deflection, and W for every direction of bending. On other
// meshes W can be too large: by a factor of up to 1.5 on a square grid with alternating diagonals,
// or with a cross in each cell.
//
// A border edge has no angle. Its t_i takes the value that minimises W, so that it carries no
// moment. This eliminates t_i and condenses C.
#pragma once

#include <array>

#include "materials/strain_map.h"
#include "materials/types.h"

namespace weft::materials {

// Returns C of an isotropic plate, N m: symmetric positive semi-definite, with zero rows and
// columns for border edges. The forces are -sum_i (C t)_i d theta_i / d x, N. `rest` holds the
// positions of the nodes (m) as columns. `has_angle[i]` belongs to the edge opposite node i; it is
// false on the border. `stiffness` is D in N m, not negative; -1 < poisson_ratio < 1. Precondition:
// the rest triangle has an area. Called once per triangle, at set-up.
Mat3 triangle_bending_modulus(const Nodes3& rest, const std::array<bool, 3>& has_angle,
                              double stiffness, double poisson_ratio);

// Returns C of an orthotropic plate, N m, with the energy
//   W = A/2 kappa : D : kappa,  D over (kappa_11, kappa_22, 2 kappa_12).
// Axis 1 lies along the projection of `warp` onto the triangle. Axis 2 is a quarter turn further,
// counter-clockwise as the order of the nodes. `moduli` is D, N m. Preconditions: the rest triangle
// has an area, `warp` is not normal to it, and D is positive definite.
Mat3 triangle_bending_modulus(const Nodes3& rest, const Vec3& warp,
                              const std::array<bool, 3>& has_angle,
                              const OrthotropicModuli& moduli);
// Returns the map from the angle changes t to the curvature (kappa_11, kappa_22, 2 kappa_12) in
// these axes, 1/m. Laws that are not linear use it (curved_bending.h). The t_i of a border edge
// takes the value that minimises the W above, so its column is zero. Preconditions as above.
StrainMapOf<double> bending_map(const Nodes3& rest, const Vec3& warp,
                                const std::array<bool, 3>& has_angle,
                                const OrthotropicModuli& moduli);

}  // namespace weft::materials
