// Membranes of woven cloth with one stiffness for each of warp, weft and shear. The strain of a
// triangle is e = (E_11, E_22, 2 E_12). E is the Green strain in the axes of warp (1) and weft (2)
// in the plane of the rest triangle. An edge of the rest triangle with the components a along the
// warp and b along the weft has
//   q = l^2 - L^2 = 2 (a^2 E_11 + b^2 E_22 + a b 2 E_12).
// The three edges of a triangle give three such equations; their solution is e = B q. The energy
// per rest area is
//   w = 1/2 (C_11 E_11^2 + 2 C_12 E_11 E_22 + C_22 E_22^2 + G (2 E_12)^2),
// the St. Venant-Kirchhoff membrane of an orthotropic sheet.
#pragma once

#include "materials/membrane.h"
#include "materials/orthotropic_moduli.h"

namespace weft::materials {

// Returns the map B (1/m^2). `rest` holds the positions of the nodes (m) as columns. The axis of
// the warp is the projection of `warp` onto the triangle. The axis of the weft is rotated from it
// by 90 degrees, counter-clockwise as the order of the nodes. Preconditions: the rest triangle has
// an area, and `warp` is not normal to it.
Mat3 green_strain_map(const Nodes3& rest, const Vec3& warp);

// A membrane of a triangle with any symmetric C, usable as the `Membrane` of membrane.h.
template <class Real>
struct OrthotropicMembraneOf {
  std::array<Real, 3> rest_squared_length{};  // L_i^2 of the edge opposite node i, m^2
  Symmetric3Of<Real> edge_modulus{};          // C, N/m^3
  Real damping_time = 0;                      // beta, s

  const Real& modulus(int i, int j) const { return edge_modulus(i, j); }
  Vec3Of<Real> times_modulus(const Vec3Of<Real>& q) const { return edge_modulus * q; }
};
using OrthotropicMembrane = OrthotropicMembraneOf<double>;

// Makes the membrane of a triangle: C = A B^T M B, with the rest area A and the matrix M of
// `moduli` (N/m). `damping_time` is beta (s). The preconditions are those of green_strain_map().
OrthotropicMembrane make_orthotropic_membrane(const Nodes3& rest, const Vec3& warp,
                                              const OrthotropicModuli& moduli, double damping_time);

}  // namespace weft::materials
