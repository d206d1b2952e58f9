// The length of the first step of a run or after a restart, which depends on its first instant
// alone.
#pragma once

#include <span>

#include "sim/motion/dynamics.h"

namespace weft::sim {

// Upper bound of the first step. A body at rest may soon meet another. Methods correct a first step
// that is a thousand times too short at once, so a small bound costs little.
inline constexpr double longest_first_step = 1e-3;  // s

// Returns the length (s) of the first step of a method with error control, from `time` (s)
// and the state `y` (6 * particles). It is the step h of Euler's method whose local error h^2 |y''|
// / 2, in the norm of tolerances.h, is a quarter of the tolerances. y'' is the difference of two
// rates. The second is taken where y has changed by the tolerances along the first (Hairer,
// Noersett, Wanner, Solving Ordinary Differential Equations I, II.4). The result lies between
// minimum_step and longest_first_step. The end of the run does not enter: the same steps serve runs
// of any length. Costs two evaluations of the forces, more where surfaces would touch. Returns
// minimum_step if the forces cannot be evaluated: the step itself then reports why.
double first_step(Dynamics& dynamics, double time, std::span<const double> y);

}  // namespace weft::sim
