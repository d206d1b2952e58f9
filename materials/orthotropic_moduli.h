// Stiffness of orthotropic sheets against stretching and bending.
#pragma once

#include "materials/types.h"

namespace weft::materials {

// The entries of the stiffness matrix [warp coupling 0; coupling weft 0; 0 0 shear], which acts on
// (e_11, e_22, 2 e_12). Their unit is N/m for strains and N m for curvatures. The matrix is
// positive semi-definite if its diagonal is not negative and coupling^2 <= warp weft.
struct OrthotropicModuli {
  double warp = 0, coupling = 0, weft = 0, shear = 0;

  Mat3 matrix() const;
};

// Returns the moduli (N/m) of a sheet against stretching. `warp` and `weft` are Young's moduli
// times thickness, `shear` is the shear modulus times thickness (N/m). A pull along the warp that
// stretches the warp by e contracts the weft by poisson_ratio e. Precondition:
// poisson_ratio^2 weft < warp, or poisson_ratio is zero.
OrthotropicModuli orthotropic_moduli(double warp, double weft, double shear, double poisson_ratio);

// Returns the bending moduli (N m) of a plate from its stiffness in three directions. Bent to a
// cylinder of curvature k, the plate has the energy 1/2 B k^2 per area. B (N m) depends on the
// direction of curvature: it is `warp` along the warp, `bias` at 45 degrees, and `weft` along the
// weft. In the direction at the angle phi to the warp, with c = cos phi and s = sin phi,
//   B = warp c^4 + 2 H c^2 s^2 + weft s^4,
//   H = D_12 + 2 D_66 = 2 bias - (warp + weft) / 2.
// These stiffnesses do not determine D_12 itself. It is set to poisson_ratio min(H, sqrt(warp
// weft)), or to H if H is negative. An isotropic plate of stiffness D gets D_12 = poisson_ratio D.
// Preconditions: -1 < poisson_ratio < 1 and is_bending_possible().
OrthotropicModuli bending_moduli(double warp, double bias, double weft, double poisson_ratio);
// Returns true if B is positive in every direction: warp > 0, weft > 0 and H > -sqrt(warp weft).
bool is_bending_possible(double warp, double bias, double weft);
// Returns the bound (N m) that `bias` must exceed for is_bending_possible() to hold.
double least_bias(double warp, double weft);

}  // namespace weft::materials
