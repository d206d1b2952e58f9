#include "sim/solver/frequency_estimate.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "sim/base/parallel.h"

namespace weft::sim {

namespace {

constexpr std::int64_t assemblies_per_estimate = 100;
constexpr int power_steps = 10;

std::vector<Vec3> random_vector(int count) {
  std::vector<Vec3> vector(count);
  std::uint32_t random = 1;
  for (Vec3& v : vector) {
    for (double& component : v) {
      random = 1664525 * random + 1013904223;
      component = random / 4294967296.0 - 0.5;
    }
  }
  return vector;
}

}  // namespace

double FrequencyEstimate::highest() {
  const std::int64_t assemblies = dynamics_.statistics().counters.matrix_assemblies;
  if (frequency_ >= 0 && assemblies < assembly_ + assemblies_per_estimate) return frequency_;
  assembly_ = assemblies;
  const Scene& scene = dynamics_.scene();
  const int count = dynamics_.particle_count(), threads = dynamics_.threads();
  std::vector<Vec3> direction = random_vector(count), product(count);
  double square = 0;
  for (int step = 0; step < power_steps; ++step) {
    for (int i = 0; i < count; ++i) {
      if (scene.pinned[i] != 0) direction[i].setZero();
    }
    const double size = std::sqrt(dot(direction, direction, threads));
    if (!(size > 0)) break;
    for (Vec3& v : direction) v /= size;
    dynamics_.stiffness().multiply(direction, product, threads);
    dynamics_.mass().solve(product);
    square = dot(direction, product, threads);
    direction.swap(product);
  }
  frequency_ = std::sqrt(std::max(0.0, square));
  return frequency_;
}

}  // namespace weft::sim
