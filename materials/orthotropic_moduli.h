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

// Returns the moduli (N/m) of a sheet in its plane. `warp` and `weft` are Young's moduli times
// thickness, `shear` the shear modulus times thickness (N/m). `poisson_ratio` is the contraction
// along the weft per stretch along the warp, under a pull along the warp. Precondition:
// poisson_ratio^2 weft < warp, or the ratio is zero.
OrthotropicModuli orthotropic_moduli(double warp, double weft, double shear, double poisson_ratio);

// Returns the bending moduli (N m) of a plate from its stiffness as a cylinder. A cylinder of
// curvature k has the energy 1/2 B k^2 per area. B (N m) is `warp`, `bias` and `weft` for curvature
// along the warp, at 45 degrees and along the weft. In the direction with the cosine c and the sine
// s to the warp,
//   B = warp c^4 + 2 H c^2 s^2 + weft s^4,
//   H = D_12 + 2 D_66 = 2 bias - (warp + weft) / 2.
// Cylinders do not determine D_12 itself. It is set to poisson_ratio min(H, sqrt(warp weft)), or to
// H if H is negative. The isotropic plate thus has D_12 = poisson_ratio D. Preconditions: -1 <
// poisson_ratio < 1 and is_bending_possible().
OrthotropicModuli bending_moduli(double warp, double bias, double weft, double poisson_ratio);
// Returns true if every cylinder has a positive energy: warp, weft > 0 and H > -sqrt(warp weft).
bool is_bending_possible(double warp, double bias, double weft);
// Returns the lower bound of `bias` (N m), itself excluded, for is_bending_possible().
double least_bias(double warp, double weft);

}  // namespace weft::materials
