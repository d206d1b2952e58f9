// Measurements on runs of cloth that show its material: strains, decay of vibrations, creases.
#pragma once

#include <span>
#include <vector>

#include "sim/base/vectors.h"
#include "sim/case/case.h"
#include "sim/scene/scene.h"
#include "sim/simulation/simulation.h"

namespace weft::bench {

// Returns the largest principal strain of all triangles of dynamic bodies, from singular values of
// their deformation. `position` has all particles of the scene (m).
double largest_strain(const sim::Scene& scene, std::span<const sim::Vec3> position);

// The largest principal strains of a run.
struct RunStrain {
  double at_ends = 0;  // of steps
  double within = 0;   // in the middle of steps, by interpolation
};
// Runs the case to time.duration. Throws std::runtime_error if that fails.
RunStrain largest_strains(const sim::Case& source);

// A decaying vibration.
struct Decay {
  double frequency = 0;  // Hz
  double loss_factor = 0;
};
// Finds frequency and loss factor from samples at equal times, `step` s apart. The distances
// between extremes count: they hold whatever the place about which it vibrates. The logarithmic
// decrement of x'' + eta omega x' + omega^2 x = 0 is delta = pi eta / sqrt(1 - eta^2 / 4). The
// first two periods, in which higher vibrations die out, do not count. Throws std::runtime_error
// for fewer than six periods.
Decay decay_of(std::span<const double> samples, double step);
// Runs the case to time.duration by its fixed step, and samples the last vertex of its first body
// along an axis (0, 1, 2). Throws std::runtime_error if a step fails.
Decay ring_down(const sim::Case& source, int axis);

// Returns the angle (rad) between the tangents at the two ends of the first body, along its middle
// row: an arc in the plane across y.
double turning_angle(const sim::Scene& scene, std::span<const sim::Vec3> position);

}  // namespace weft::bench
