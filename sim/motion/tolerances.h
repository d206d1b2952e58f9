// The tolerances of a case as weights of the components of a state.
#pragma once

#include <span>

#include "sim/case/case.h"

namespace weft::sim {

// Computes the weights 1 / position_tolerance for positions and 1 / (velocity_tolerance +
// relative_tolerance |v|) for velocities; `y` and `weights` have 6 * particles entries. The three
// components of a vector share one weight, so error tests do not depend on the axes. Returns false
// if a weight is not finite.
bool error_weights(const TimeCase& options, std::span<const double> y, std::span<double> weights);

// Returns the velocity tolerance of the case (m/s). By default it is 100 /s * position_tolerance.
double velocity_tolerance(const TimeCase& options);

// Returns the particle with the largest weighted error. `errors` and `weights` have 6 * particles
// entries. A value that is not finite counts as the largest.
int worst_particle(std::span<const double> errors, std::span<const double> weights);

}  // namespace weft::sim
