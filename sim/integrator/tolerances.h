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

// Root mean square of the weighted errors (6 * particles), or, where that is larger, that of the
// particle which weighs most divided by `peak_to_mean`: a norm in which no particle's error exceeds
// the mean allowed by more than that factor. NaN where an error is.
double peak_norm(std::span<const double> errors, std::span<const double> weights,
                 double peak_to_mean);

// The particle whose components (6 * particles) weigh most: where to look when an error is too
// large. A value that is not finite is the worst of all.
int worst_particle(std::span<const double> errors, std::span<const double> weights);

}  // namespace weft::sim
