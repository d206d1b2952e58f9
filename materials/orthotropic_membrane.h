// Membranes of woven cloth, whose stiffness differs along warp, weft and shear. The strain of a
// triangle is e = (E_11, E_22, 2 E_12). E is the Green strain, with components along warp and weft
// in the plane of the rest triangle. An edge with the rest components a and b along warp and weft
// has
//   q = l^2 - L^2 = 2 (a^2 E_11 + b^2 E_22 + a b 2 E_12).
// The three edges of a triangle give three such equations; their solution is e = B q. The energy
// per rest area is
//   w = 1/2 (C_11 E_11^2 + 2 C_12 E_11 E_22 + C_22 E_22^2 + G (2 E_12)^2),
// the St. Venant-Kirchhoff membrane of an orthotropic sheet.
#pragma once

#include "materials/membrane.h"
#include "materials/orthotropic_moduli.h"

namespace weft::materials {

// Returns B (1/m^2). `rest` holds the positions of the nodes (m) as columns. The warp is the
// projection of `warp` onto the triangle; the weft is a quarter turn further, counter-clockwise as
// the order of the nodes. Precondition: the rest triangle has an area, and `warp` is not normal to
// it.
Mat3 green_strain_map(const Nodes3& rest, const Vec3& warp);

// A `Membrane` (membrane.h) with any symmetric C.
template <class Real>
struct OrthotropicMembraneOf {
  std::array<Real, 3> rest_squared_length{};  // of the edge opposite each node, m^2
  Symmetric3Of<Real> edge_modulus{};          // C, N/m^3
  Real damping_time = 0;                      // beta, s

  const Real& modulus(int i, int j) const { return edge_modulus(i, j); }
  Vec3Of<Real> times_modulus(const Vec3Of<Real>& q) const { return edge_modulus * q; }
};
using OrthotropicMembrane = OrthotropicMembraneOf<double>;

// Makes the membrane of a triangle: C = A B^T M B with the rest area A and the matrix M of `moduli`
// (N/m). `damping_time` is beta (s). Preconditions as for green_strain_map().
OrthotropicMembrane make_orthotropic_membrane(const Nodes3& rest, const Vec3& warp,
                                              const OrthotropicModuli& moduli, double damping_time);

}  // namespace weft::materials
