// The lengths of steps that begin without a history: at a start and after a stop.
#pragma once

#include <algorithm>
#include <span>

#include "sim/motion/dynamics.h"

namespace weft::sim {

// Upper bound of the first step: a body at rest may soon meet another. A small bound costs little,
// because methods lengthen a short first step quickly.
inline constexpr double longest_first_step = 1e-3;  // s

// Returns the length (s) of the longest step that is allowed after one of the length `last` (s)
// that ended at a stop time. SUNDIALS does not tell how long its next step will be then. Its steps
// seldom grow by more.
inline double longest_step_after_stop(double last) {
  return std::max(longest_first_step, 20 * last);
}

// Returns the length (s) of the first step of a method with error control, from `time` (s) and the
// state `y` (6 * particles). Euler's method would have a local error h^2 |y''| / 2 of a quarter of
// the tolerances in this step h, in the RMS norm of the weights of tolerances.h. The finite
// difference of two rates estimates y''. For the second rate, y moves along the first rate by the
// tolerances, or for longest_first_step if that is shorter (Hairer, Noersett, Wanner, Solving
// Ordinary Differential Equations I, II.4). The result lies between ShortSteps::shortest_ever()
// and longest_first_step. Usually costs two evaluations of the forces. Returns the shortest length
// if the forces cannot be evaluated at y; the step itself then reports the failure.
double first_step(Dynamics& dynamics, double time, std::span<const double> y);

}  // namespace weft::sim
