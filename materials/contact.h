// The contact barrier and regularised friction as functions of one number each.
#pragma once

namespace weft::materials {

// W(g) = -stiffness (g - range)^2 ln(g / range) for 0 < g < range, 0 beyond: value and derivatives
// with respect to the gap g, J, N, N/m, N/m^2. C2 at g = range. Precondition: g > 0. (Li et al.
// 2020, Incremental Potential Contact, eq. 6.)
struct BarrierDerivatives {
  double value = 0, first = 0, second = 0, third = 0;
};
BarrierDerivatives barrier(double gap, double range, double stiffness);

// Regularised Coulomb friction: magnitude factor f(s) in [0, 1] of the sliding speed s (m/s):
// 2 s/e - (s/e)^2 for s < e, else 1 (IPC, eq. 13 ff.), returned as f(s)/s so that force = -mu N
// (f/s) v_t is smooth at rest, with d f / d s.
struct FrictionFactor {
  double over_speed = 0;  // f(s) / s, s/m
  double slope = 0;       // f'(s), s/m
};
FrictionFactor friction_factor(double speed, double regularisation_speed);

// Edge-edge mollifier (IPC, section 4.1): 1 where the squared cross product c of the edges is >=
// the threshold, falling smoothly to 0 for parallel ones: m = -(c/e)^2 + 2 c/e.
struct MollifierDerivatives {
  double value = 1, first = 0, second = 0;
};
MollifierDerivatives edge_edge_mollifier(double squared_cross_product, double threshold);

}  // namespace weft::materials
