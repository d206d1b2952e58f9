// Mass-weighted sums and accelerations, vectorised over particles, for use in every step.
#pragma once

#include <span>

#include "sim/matrix/block_matrix.h"

namespace weft::sim {

// Returns sum_i mass_i a_i . b_i. Precondition of all functions in this file: `mass` has one entry
// per vector.
double mass_product(std::span<const double> mass, std::span<const Vec3> a, std::span<const Vec3> b);

// Sums over a vibration sampled at three equidistant times as `before`, `a` and `after`. `all` is
// sum_i mass_i a_i . a_i, and `bent` is sum_i mass_i a_i . (2 a_i - before_i - after_i). Then bent
// = (2 - 2 cos(phase between two samples)) all.
struct VibrationProducts {
  double all = 0, bent = 0;
};
VibrationProducts vibration_products(std::span<const double> mass, std::span<const Vec3> before,
                                     std::span<const Vec3> a, std::span<const Vec3> after);

// Returns sum_i mass_i x_i.
Vec3 mass_moment(std::span<const double> mass, std::span<const Vec3> x);

// Replaces the forces (N) by accelerations (m/s^2) with gravity added. Returns the sum of all
// components, which is not finite if any component is not finite.
double accelerate(std::span<const double> mass, const Vec3& gravity, std::span<Vec3> force);

}  // namespace weft::sim
