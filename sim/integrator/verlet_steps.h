// The step lengths that verlet chooses from a tolerance.
#pragma once

#include <algorithm>
#include <cmath>

namespace weft::sim {

// Fraction of the longest stable step that verlet takes, at the default relative_tolerance. It
// keeps the energy of an undamped sheet in chaotic motion within one percent. The error is
// proportional to the square of the step. The fraction therefore grows with the square root of the
// tolerance, up to `longest_verlet_share`.
inline constexpr double default_verlet_share = 0.2, default_verlet_tolerance = 1e-4;
inline constexpr double longest_verlet_share = 0.9;

inline double verlet_share(double relative_tolerance) {
  const double share =
      default_verlet_share * std::sqrt(relative_tolerance / default_verlet_tolerance);
  return std::min(share, longest_verlet_share);
}
inline double verlet_tolerance(double share) {
  const double ratio = share / default_verlet_share;
  return default_verlet_tolerance * ratio * ratio;
}

// Returns the rate r (1/s) of the longest stable step 2 / r: the positive solution h of
// h^2 frequency^2 + 4 h decay = 4 (docs/theory.md, "Verlet without step"). `frequency` (rad/s) and
// `decay` (1/s) are the largest ones of the motion. If damping dominates, the longest step is half
// of 2 / decay, because damping acts on a velocity that is extrapolated from the start of the step.
inline double verlet_rate(double frequency, double decay) {
  return decay + std::hypot(decay, frequency);
}

// Largest number of steps between two checks of the longest stable step. A check costs one
// evaluation of the forces.
inline constexpr int most_verlet_steps_per_check = 32;

// Returns the number of force evaluations of verlet over `duration` (s), with the longest steps
// that it takes. `rate` (1/s) is that of verlet_rate().
inline double verlet_evaluations(double rate, double duration) {
  return (1 + 1.0 / most_verlet_steps_per_check) * duration * rate / (2 * longest_verlet_share);
}

}  // namespace weft::sim
