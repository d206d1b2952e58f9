#include "sim/integrator/spectral_estimate.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace weft::sim {

namespace {

constexpr int iterations = 60;

struct Spectrum {
  double radius = 0;
  int place = -1;  // the particle with the largest entry of the vector
};

// Of M^-1/2 A M^-1/2, which is symmetric and has the same eigenvalues as M^-1 A.
Spectrum spectral_radius(const Dynamics& dynamics, const BlockMatrix& matrix) {
  const Scene& scene = dynamics.scene();
  const int count = dynamics.particle_count();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> entry(-1, 1);
  std::vector<Vec3> vector(count), scaled(count), product(count);
  for (Vec3& v : vector) v = Vec3(entry(random), entry(random), entry(random));
  double radius = 0;
  for (int k = 0; k < iterations; ++k) {
    double norm = 0;
    for (int i = 0; i < count; ++i) {
      if (scene.pinned[i] != 0) vector[i].setZero();
      norm += vector[i].squaredNorm();
    }
    if (norm == 0) return {};
    norm = std::sqrt(norm);
    for (int i = 0; i < count; ++i) {
      vector[i] /= norm;
      scaled[i] = vector[i] / std::sqrt(scene.mass[i]);
    }
    matrix.multiply(scaled, product, dynamics.threads());
    double square = 0;
    for (int i = 0; i < count; ++i) {
      vector[i] =
          scene.pinned[i] != 0 ? Vec3(Vec3::Zero()) : Vec3(product[i] / std::sqrt(scene.mass[i]));
      square += vector[i].squaredNorm();
    }
    radius = std::sqrt(square);
  }
  const auto largest = std::max_element(
      vector.begin(), vector.end(),
      [](const Vec3& a, const Vec3& b) { return a.squaredNorm() < b.squaredNorm(); });
  return {radius, static_cast<int>(largest - vector.begin())};
}

}  // namespace

SpectralEstimate estimate_spectrum(Dynamics& dynamics, double t, std::span<const double> y) {
  dynamics.assemble(t, y);
  SpectralEstimate estimate;
  const Spectrum vibration = spectral_radius(dynamics, dynamics.stiffness());
  estimate.frequency = std::sqrt(vibration.radius);
  estimate.place = vibration.place;
  if (!dynamics.has_damping()) return estimate;
  const Spectrum decay = spectral_radius(dynamics, dynamics.damping());
  estimate.decay = decay.radius;
  if (estimate.decay > estimate.frequency) estimate.place = decay.place;
  return estimate;
}

}  // namespace weft::sim
