// Mass-weighted sums and accelerations, vectorised over particles: methods with many short steps
// need them in every step.
#pragma once

#include <span>

#include "sim/matrix/block_matrix.h"

namespace weft::sim {

// Returns sum_i mass_i a_i . b_i. Precondition, here and below: there are as many masses as
// vectors.
double mass_product(std::span<const double> mass, std::span<const Vec3> a, std::span<const Vec3> b);

// `all` is sum_i mass_i a_i . a_i, `bent` is sum_i mass_i a_i . (2 a_i - before_i - after_i). For a
// vibration sampled three times, bent = (2 - 2 cos(phase between two samples)) all.
struct VibrationProducts {
  double all = 0, bent = 0;
};
VibrationProducts vibration_products(std::span<const double> mass, std::span<const Vec3> before,
                                     std::span<const Vec3> a, std::span<const Vec3> after);

// Returns sum_i mass_i x_i.
Vec3 mass_moment(std::span<const double> mass, std::span<const Vec3> x);

// Turns forces (N) into accelerations (m/s^2) and adds gravity. Returns the sum of all components,
// which is not finite if any component is not finite.
double accelerate(std::span<const double> mass, const Vec3& gravity, std::span<Vec3> force);

}  // namespace weft::sim
