// The tolerances of a case as weights of the components of a state.
#pragma once

#include <span>

#include "sim/base/step_census.h"
#include "sim/case/case.h"

namespace weft::sim {

class Dynamics;
struct Scene;

// Computes the weights 1 / position_tolerance for positions and 1 / (velocity_tolerance +
// relative_tolerance |v|) for velocities; `y` and `weights` have 6 * particles entries. The three
// components of a vector share one weight, so error tests do not depend on the axes. The weights of
// the spheres of [[particles]] are larger: their mean error over all spheres, not over all
// particles, is kept to a third of the tolerances, which resolves bounces. Returns false if a
// weight is not finite.
bool error_weights(const Scene& scene, std::span<const double> y, std::span<double> weights);

// Returns the velocity tolerance of the case (m/s). By default it is 100 /s * position_tolerance.
double velocity_tolerance(const TimeCase& options);

// Returns the part of the error that contributes most to its sum of squares (step_census.h).
// `weighted` has the 6 * particles errors, multiplied by their weights. Particles are in contact if
// they belong to a pair of the last evaluation of contact.
StepLimit largest_error_part(const Dynamics& dynamics, std::span<const double> weighted);

// Returns the particle with the largest weighted error. `errors` and `weights` have 6 * particles
// entries. A value that is not finite counts as the largest.
int worst_particle(std::span<const double> errors, std::span<const double> weights);

}  // namespace weft::sim
