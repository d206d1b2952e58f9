// The length of the first step of a run or after a restart. It depends only on the forces at the
// start.
#pragma once

#include <span>

#include "sim/motion/dynamics.h"

namespace weft::sim {

// Upper bound of the first step, since a body at rest may soon meet another. A small bound costs
// little: methods at once lengthen a first step that is a thousand times too short.
inline constexpr double longest_first_step = 1e-3;  // s

// Returns the length (s) of the first step of a method with error control, from `time` (s) and the
// state `y` (6 * particles). For Euler's method, this step h has a local error h^2 |y''| / 2 of a
// quarter of the tolerances, in the norm of tolerances.h. The finite difference of two rates
// estimates y''; the second rate is taken where y has changed by the tolerances along the first
// (Hairer, Noersett, Wanner, Solving Ordinary Differential Equations I, II.4). The result lies
// between minimum_step and longest_first_step. The result does not depend on the duration of the
// run. Costs two evaluations of the forces, more if surfaces would touch. Returns minimum_step if
// the forces cannot be evaluated; the step itself then reports the failure.
double first_step(Dynamics& dynamics, double time, std::span<const double> y);

}  // namespace weft::sim
