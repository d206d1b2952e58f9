// The tolerances of a case as weights of the components of a state.
#pragma once

#include <span>

#include "sim/case/case.h"

namespace weft::sim {

// 1 / position_tolerance for positions, 1 / (velocity_tolerance + relative_tolerance |v|) for
// velocities; `y` and `weights` are of 6 * particles. One weight for the three components of a
// vector: the test does not depend on the axes. False where a value is not finite.
bool error_weights(const TimeCase& options, std::span<const double> y, std::span<double> weights);

// m/s: what the case gives, or 100 /s position_tolerance.
double velocity_tolerance(const TimeCase& options);

// The particle whose components (6 * particles) weigh most: where to look when an error is too
// large. A value that is not finite is the worst of all.
int worst_particle(std::span<const double> errors, std::span<const double> weights);

}  // namespace weft::sim
