#include "sim/integrator/spectral_estimate.h"

#include <cmath>
#include <random>
#include <vector>

namespace weft::sim {

namespace {

constexpr int iterations = 60;

// Of M^-1/2 A M^-1/2, which is symmetric and has the same eigenvalues as M^-1 A.
double spectral_radius(const Dynamics& dynamics, const BlockMatrix& matrix) {
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
    if (norm == 0) return 0;
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
  return radius;
}

}  // namespace

SpectralEstimate estimate_spectrum(Dynamics& dynamics, double t, std::span<const double> y) {
  dynamics.assemble(t, y);
  SpectralEstimate estimate;
  estimate.frequency = std::sqrt(spectral_radius(dynamics, dynamics.stiffness()));
  if (dynamics.has_damping()) estimate.decay = spectral_radius(dynamics, dynamics.damping());
  return estimate;
}

}  // namespace weft::sim
