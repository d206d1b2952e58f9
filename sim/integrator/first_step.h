// The length of the first step of a run, or after a restart, from its first instant alone.
#pragma once

#include <span>

#include "sim/motion/dynamics.h"

namespace weft::sim {

// Methods multiply a first step that was too short by thousands at once, and what rests now may be
// met by something soon.
inline constexpr double longest_first_step = 1e-3;  // s

// Length (s) of the first step of a method with error control that begins at `time` (s) with the
// state `y` (6 * particles): the step h of Euler's method whose local error, h^2 |y''| / 2, is a quarter
// of the tolerances, in the norm of tolerances.h, and at most a millisecond. y'' is the difference
// of two rates, one of them as far along the slope as changes y by the tolerances (Hairer,
// Noersett, Wanner, Solving Ordinary Differential Equations I, II.4). The end of the run has no
// part in it: what a run computes does not depend on how long it will be. Two evaluations of the
// forces, more where surfaces would touch. At least minimum_step, which is returned where the
// forces cannot be evaluated: the step itself then says why.
double first_step(Dynamics& dynamics, double time, std::span<const double> y);

}  // namespace weft::sim
