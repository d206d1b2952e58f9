// Stiffness of orthotropic sheets, in their plane and in bending.
#pragma once

#include "materials/types.h"

namespace weft::materials {

// The matrix [warp coupling 0; coupling weft 0; 0 0 shear] over (e_11, e_22, 2 e_12): N/m for a
// strain in the plane, N m for a curvature. It is positive semi-definite if its diagonal is not
// negative and coupling^2 <= warp weft.
struct OrthotropicModuli {
  double warp = 0, coupling = 0, weft = 0, shear = 0;

  Mat3 matrix() const;
};

// Returns the moduli of a sheet with these constants (N/m): Young's moduli times thickness along
// warp and weft, the shear modulus times thickness, and the ratio of the contraction along the weft
// to the stretch along the warp. Precondition: poisson_ratio^2 weft < warp, or the ratio is zero.
OrthotropicModuli orthotropic_moduli(double warp, double weft, double shear, double poisson_ratio);

// Returns the moduli of a plate that bends to a cylinder of curvature k with the energy 1/2 B k^2
// per area, where B (N m) is `warp`, `bias` and `weft` for curvature along the warp, at 45 degrees
// and along the weft. With
//   H = D_12 + 2 D_66 = 2 bias - (warp + weft) / 2,
// in other directions B = warp c^4 + 2 H c^2 s^2 + weft s^4. Cylinders leave D_12 open: it is
// poisson_ratio min(H, sqrt(warp weft)), or H where that is negative; the isotropic plate has D_12
// = poisson_ratio D. Preconditions: -1 < poisson_ratio < 1 and is_bending_possible().
OrthotropicModuli bending_moduli(double warp, double bias, double weft, double poisson_ratio);
// True if every cylinder has a positive energy: warp, weft > 0 and H > -sqrt(warp weft).
bool is_bending_possible(double warp, double bias, double weft);
// The least `bias` (N m), not included, for which it is possible.
double least_bias(double warp, double weft);

}  // namespace weft::materials
