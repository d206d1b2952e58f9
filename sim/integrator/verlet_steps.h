// The choice of verlet's steps by a tolerance.
#pragma once

#include <algorithm>
#include <cmath>

namespace weft::sim {

// At the default relative_tolerance, the step is a fifth of the longest stable one. This keeps the
// energy of an undamped sheet within one percent, whichever way its chaotic motion takes. The error
// goes as the square of the step, so steps go as the root of the tolerance, up to nine tenths of
// the longest.
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

// The most steps between two checks of how long they may be, each of which takes an evaluation of
// the forces.
inline constexpr int most_verlet_steps_per_check = 32;

// Evaluations that its longest steps take for `duration` (s), where the fastest vibration or decay
// has this rate (1/s): it is stable where h rate < 2.
inline double verlet_evaluations(double rate, double duration) {
  return (1 + 1.0 / most_verlet_steps_per_check) * duration * rate / (2 * longest_verlet_share);
}

}  // namespace weft::sim
