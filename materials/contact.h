// The contact barrier, its damping, regularised friction and the edge-edge mollifier, as scalar
// functions with their derivatives. All functions are inline for speed.
#pragma once

#include <cassert>
#include <cmath>

namespace weft::materials {

// The barrier energy of a gap g (m) and its derivatives by g (Li et al. 2020, Incremental Potential
// Contact, eq. 6):
//   W(g) = -stiffness (g - range)^2 ln(g / range) for 0 < g < range, 0 beyond.
// With a stiffness in N/m, W and its derivatives have the units J, N, N/m and N/m^2. W is C2 at
// g = range, where the third derivative jumps. Precondition: g > 0. In a release build, g <= 0
// gives NaN or infinities, never a finite force.
struct BarrierDerivatives {
  double value = 0, first = 0, second = 0, third = 0;
};
inline BarrierDerivatives barrier(double gap, double range, double stiffness) {
  assert(gap > 0 && range > 0);
  if (gap >= range) return {};
  const double inverse = 1 / gap;
  const double depth = gap - range;         // negative
  const double relative = depth * inverse;  // 1 - range / g
  const double ratio = range * inverse;
  // std::log1p would be more accurate for gaps near the range, where the force vanishes, but less
  // accurate for small gaps.
  const double logarithm = std::log(gap / range);
  return {-stiffness * depth * depth * logarithm, -stiffness * depth * (2 * logarithm + relative),
          -stiffness * (2 * logarithm + (4 - relative) * relative),
          -2 * stiffness * inverse * (1 + ratio * (1 + ratio))};
}

// The normal force of a contact, barrier and damping together: F = P psi(z) >= 0, N. P = -W' is the
// force of the barrier alone, g' the rate of the gap (m/s) and z = D g' / P, with
//   D = damping_time W'' x / (x + 1/100),  x = 1 - gap / range,
//   psi(z) = 1 - z for z <= 0,  (1 - z)^2 (1 + z) for 0 < z < 1,  0 for z >= 1.
// Approaching surfaces repel each other with the force P - D g'. If D > 0, separating surfaces
// repel each other with less than P, and from the rate P / D on with no force. F is C1 in the gap
// and in the rate, also at g = range. D is nearly damping_time W'' except for gaps near the range,
// where it vanishes as fast as P. Only psi dissipates energy: P is conservative (docs/theory.md,
// section 7). `barrier` is the result of barrier() at `gap`.
struct DampedPush {
  double force = 0;      // N
  double stiffness = 0;  // -dF/dg, N/m
  double damping = 0;    // -dF/dg', N s/m
};
inline DampedPush damped_push(const BarrierDerivatives& barrier, double gap, double range,
                              double damping_time, double gap_rate) {
  constexpr double onset = 0.01;
  const double push = -barrier.first;
  if (!(push > 0)) return {};
  const double depth = 1 - gap / range;
  const double share = depth / (depth + onset);
  const double share_slope = -onset / ((depth + onset) * (depth + onset) * range);
  const double damping = damping_time * barrier.second * share;
  const double damping_slope =
      damping_time * (barrier.third * share + barrier.second * share_slope);
  const double z = damping * gap_rate / push;
  if (z <= 0)
    return {push - damping * gap_rate, barrier.second + damping_slope * gap_rate, damping};
  if (z >= 1) return {};
  const double psi = (1 - z) * (1 - z) * (1 + z), slope = (3 * z + 1) * (z - 1);
  return {push * psi, barrier.second * (psi - z * slope) - slope * damping_slope * gap_rate,
          -damping * slope};
}

// The normal force of a contact that bounces: F = P phi(g') >= 0, N, with P = -W' as above and
//   phi(u) = 1 - c s(u / v),  c = (1 - e^2) / (1 + e^2),
//   s(x) = x (3 - x^2) / 2 for |x| < 1,  the sign of x beyond.
// An approach at the speed u >> v stores the share 1 / (1 + c) of its energy in the barrier, which
// gives 1 - c of that back: the speed of parting is e u, whatever the masses and the stiffness. At
// rest F is P, and motions slower than v are damped. F is C1 in the rate and never pulls. As
// (phi - 1) u <= 0, it adds no energy. Preconditions: 0 <= e <= 1, `settling_speed` v > 0 (m/s).
inline DampedPush bouncing_push(const BarrierDerivatives& barrier, double restitution,
                                double settling_speed, double gap_rate) {
  const double push = -barrier.first;
  if (!(push > 0)) return {};
  const double squared = restitution * restitution, loss = (1 - squared) / (1 + squared);
  const double x = gap_rate / settling_speed;
  if (std::abs(x) >= 1) {
    const double phi = x > 0 ? 1 - loss : 1 + loss;
    return {push * phi, barrier.second * phi, 0};
  }
  const double phi = 1 - loss * 0.5 * x * (3 - x * x);
  return {push * phi, barrier.second * phi, push * loss * 1.5 * (1 - x * x) / settling_speed};
}

// Regularised Coulomb friction (Li et al. 2020, eq. 13 and after). At the sliding speed s >= 0
// (m/s) the friction force is mu N f(s), with
//   f(s) = 2 s/e - (s/e)^2 for s < e,  1 for s >= e.
// The force vector is -mu N (f/s) v_t. The function therefore returns f(s) / s, which is finite at
// s = 0, and f'(s). Precondition: e = regularisation_speed > 0.
struct FrictionFactor {
  double over_speed = 0;  // f(s) / s, s/m
  double slope = 0;       // f'(s), s/m
};
inline FrictionFactor friction_factor(double speed, double regularisation_speed) {
  assert(speed >= 0 && regularisation_speed > 0);
  if (speed >= regularisation_speed) return {1 / speed, 0};
  const double inverse = 1 / regularisation_speed;
  const double ratio = speed * inverse;
  return {(2 - ratio) * inverse, 2 * (1 - ratio) * inverse};
}

// The edge-edge mollifier m(c) (Li et al. 2020, section 4.1) and its derivatives by c. c is the
// squared cross product of the two edges, m^4. With the threshold e > 0 (m^4),
//   m(c) = 2 c/e - (c/e)^2 for c < e,  1 for c >= e.
// m is 0 for parallel edges, and C1 at c = e.
struct MollifierDerivatives {
  double value = 1, first = 0, second = 0;
};
inline MollifierDerivatives edge_edge_mollifier(double squared_cross_product, double threshold) {
  assert(squared_cross_product >= 0 && threshold > 0);
  if (squared_cross_product >= threshold) return {};
  const double inverse = 1 / threshold;
  const double ratio = squared_cross_product * inverse;
  return {ratio * (2 - ratio), 2 * (1 - ratio) * inverse, -2 * inverse * inverse};
}

}  // namespace weft::materials
