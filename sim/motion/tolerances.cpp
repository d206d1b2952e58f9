#include "sim/motion/tolerances.h"

#include <algorithm>
#include <cmath>

#include "sim/base/parallel.h"
#include "sim/motion/dynamics.h"
#include "sim/scene/sphere_groups.h"

namespace weft::sim {

double velocity_tolerance(const TimeCase& options) {
  return options.velocity_tolerance.value_or(100 * options.position_tolerance);
}

namespace {

// Part of the tolerances that the error of spheres may take.
constexpr double part_for_spheres = 1.0 / 3;

// Multiplies the weights of spheres and of their spins. The mean is that over the spheres, to which
// spins contribute in proportion to their energy: by their mass.
void raise_weights_of_spheres(const Scene& scene, std::span<double> weights) {
  double spheres = 0;
  for (const SceneBody& body : scene.bodies) {
    if (body.dynamic && body.spheres != nullptr && !body.are_spins)
      spheres += body.particle_count();
  }
  const double of_spheres = std::sqrt(scene.dynamic_particles / spheres) / part_for_spheres;
  for (const SceneBody& body : scene.bodies) {
    if (!body.dynamic || body.spheres == nullptr) continue;
    const double factor = of_spheres * (body.are_spins ? std::sqrt(spin_mass_share) : 1);
    const auto first = 3 * static_cast<std::size_t>(body.first_particle);
    const auto count = 3 * static_cast<std::size_t>(body.particle_count());
    for (const std::size_t half : {std::size_t{0}, weights.size() / 2})
      for (double& weight : weights.subspan(half + first, count)) weight *= factor;
  }
}

}  // namespace

bool error_weights(const Scene& scene, std::span<const double> y, std::span<double> weights) {
  const TimeCase& options = scene.source.time;
  const double tolerance = velocity_tolerance(options);
  const StateView view = StateView::of(y);
  const std::size_t half = y.size() / 2;
  const auto weigh = [&](int first, int last, char& is_finite) {
    std::fill(weights.begin() + 3 * first, weights.begin() + 3 * last,
              1 / options.position_tolerance);
    is_finite = 1;
    for (int i = first; i < last; ++i) {
      const double value = 1 / (tolerance + options.relative_tolerance * view.velocity[i].norm());
      if (!std::isfinite(value)) is_finite = 0;
      std::fill_n(weights.begin() + static_cast<std::ptrdiff_t>(half + 3 * i), 3, value);
    }
  };
  const int count = static_cast<int>(view.velocity.size());
  const auto are_finite = parallel_parts<char>(count, scene.threads, weigh);
  if (std::ranges::find(are_finite, 0) != are_finite.end()) return false;
  if (!scene.source.particles.empty()) raise_weights_of_spheres(scene, weights);
  return true;
}

StepLimit largest_error_part(const Dynamics& dynamics, std::span<const double> weighted) {
  const StateView error = StateView::of(weighted);
  std::vector<char> in_contact(error.position.size(), 0);
  if (dynamics.contact() != nullptr) dynamics.contact()->mark_particles_in_reach(in_contact);
  ErrorParts parts;
  for (std::size_t i = 0; i < error.position.size(); ++i) {
    auto& [position, velocity] = parts.sum[in_contact[i]];
    position += error.position[i].squaredNorm();
    velocity += error.velocity[i].squaredNorm();
  }
  return parts.largest();
}

int worst_particle(std::span<const double> errors, std::span<const double> weights) {
  const StateView error = StateView::of(errors), weight = StateView::of(weights);
  int worst = 0;
  double largest = -1;
  for (std::size_t i = 0; i < error.position.size(); ++i) {
    const double size = error.position[i].cwiseProduct(weight.position[i]).squaredNorm() +
                        error.velocity[i].cwiseProduct(weight.velocity[i]).squaredNorm();
    if (size <= largest) continue;
    largest = size;
    worst = static_cast<int>(i);
    if (!std::isfinite(size)) break;
  }
  return worst;
}

}  // namespace weft::sim
