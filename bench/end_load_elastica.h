// The tip of an inextensible cantilever under a dead transverse force at its end.
#pragma once

#include <cmath>

namespace weft::bench {

// Displacements of the tip in lengths of the cantilever: towards the clamp and along the force.
struct ElasticaTip {
  double inward = 0, across = 0;
};

// Returns the exact solution (Bisshopp and Drucker 1945) for `load` = P L^2 / (E I) > 0. With a =
// sqrt(load), the modulus p and sin phi = 1 / (p sqrt 2), the angle of the tip follows from a =
// K(p)
// - F(p, phi). Then across = 1 - 2 (E(p) - E(p, phi)) / a and inward = 1 - 2 p cos phi / a.
inline ElasticaTip end_load_elastica(double load) {
  const double a = std::sqrt(load);
  const auto phi_of = [](double p) { return std::asin(std::sqrt(0.5) / p); };
  double low = std::sqrt(0.5), high = 1;
  for (int i = 0; i < 200; ++i) {
    const double p = 0.5 * (low + high);
    if (p == low || p == high) break;
    (std::comp_ellint_1(p) - std::ellint_1(p, phi_of(p)) < a ? low : high) = p;
  }
  const double p = low, phi = phi_of(p);
  return {1 - 2 * p * std::cos(phi) / a,
          1 - 2 * (std::comp_ellint_2(p) - std::ellint_2(p, phi)) / a};
}

}  // namespace weft::bench
