#include "sim/motion/spectral_estimate.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "sim/base/parallel.h"

namespace weft::sim {

namespace {

constexpr int iterations = 30;
// Number of iterations at the start of a tracker. The calls of follow() continue the iteration.
constexpr int first_iterations = 10;

struct Spectrum {
  double radius = 0;
  int place = -1;  // particle with the largest entry of the vector
};

// Returns start vectors of the power iterations. The fastest vibrations of an image change sign
// from texel to texel; the random part covers vibrations that do not. Random vectors alone would
// need more iterations.
std::vector<Vec3> alternating_vectors(const Scene& scene) {
  const Vec3 slanted(1, 0.4, 0.7);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> entry(-1, 1);
  std::vector<Vec3> vectors(scene.dynamic_particles);
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const bsi::Atlas& atlas = scene.bodies[b].atlas;
    for (int p = 0; p < static_cast<int>(atlas.patches().size()); ++p) {
      const bsi::Patch& patch = atlas.patches()[p];
      for (int row = 0; row < patch.rows; ++row) {
        for (int col = 0; col < patch.cols; ++col) {
          const Vec3 chance(entry(random), entry(random), entry(random));
          vectors[scene.bodies[b].first_particle + atlas.particle(p, row, col)] =
              (row + col) % 2 == 0 ? Vec3(slanted + chance) : Vec3(-slanted - chance);
        }
      }
    }
  }
  return vectors;
}

int place_of_largest(const std::vector<Vec3>& vectors) {
  const auto largest = std::max_element(
      vectors.begin(), vectors.end(),
      [](const Vec3& a, const Vec3& b) { return a.squaredNorm() < b.squaredNorm(); });
  return static_cast<int>(largest - vectors.begin());
}

// Returns the spectral radius of M^-1 A for an M that is not diagonal. The vectors of the power
// iteration have length 1 in the norm of M.
Spectrum coupled_spectral_radius(Dynamics& dynamics, const BlockMatrix& matrix) {
  MassOperator& mass = dynamics.mass();
  const int threads = dynamics.threads();
  std::vector<Vec3> vector = alternating_vectors(dynamics.scene()), product(vector.size());
  double radius = 0;
  for (int k = 0; k < iterations; ++k) {
    for (std::size_t i = 0; i < vector.size(); ++i) {
      if (dynamics.scene().pinned[i] != 0) vector[i].setZero();
    }
    const double length = std::sqrt(mass.product(vector, vector, threads));
    if (length == 0) return {};
    for (Vec3& each : vector) each /= length;
    matrix.multiply(vector, product, threads);
    vector = product;
    mass.solve(vector);
    radius = std::sqrt(std::max(0.0, dot(vector, product, threads)));
  }
  return {radius, place_of_largest(vector)};
}

// Returns the spectral radius of M^-1/2 A M^-1/2, a symmetric matrix with the eigenvalues of M^-1
// A.
Spectrum spectral_radius(Dynamics& dynamics, const BlockMatrix& matrix) {
  if (!dynamics.mass().is_diagonal()) return coupled_spectral_radius(dynamics, matrix);
  const Scene& scene = dynamics.scene();
  const int count = dynamics.particle_count();
  std::vector<Vec3> vector = alternating_vectors(scene), scaled(count), product(count);
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
  return {radius, place_of_largest(vector)};
}

// Returns the typical size (m) of a quad.
double usual_length(const Scene& scene) {
  Eigen::AlignedBox3d box;
  for (int i = 0; i < scene.dynamic_particles; ++i) box.extend(scene.initial_position[i]);
  return box.diagonal().norm() / std::sqrt(scene.dynamic_particles);
}
// Displacement of finite differences, as a fraction of the size of a quad. Forces are nearly linear
// over it.
constexpr double part_of_length = 1e-6;

Eigen::Map<const Eigen::ArrayXd> components(std::span<const Vec3> vectors) {
  return {vectors[0].data(), 3 * static_cast<Eigen::Index>(vectors.size())};
}
Eigen::Map<Eigen::ArrayXd> components(std::vector<Vec3>& vectors) {
  return {vectors[0].data(), 3 * static_cast<Eigen::Index>(vectors.size())};
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

FrequencyTracker::FrequencyTracker(Dynamics& dynamics, double t, std::span<const double> y)
    : dynamics_(dynamics),
      amplitude_(part_of_length * usual_length(dynamics.scene())),
      vibration_(alternating_vectors(dynamics.scene())),
      moved_(dynamics.state_size()),
      change_(dynamics.particle_count()) {
  for (std::size_t i = 0; i < vibration_.size(); ++i) {
    if (dynamics.scene().pinned[i] != 0) vibration_[i].setZero();
  }
  std::vector<Vec3> acceleration(vibration_.size());
  if (dynamics.acceleration(t, y, acceleration)) return;
  for (int k = 0; k < first_iterations; ++k) follow(t, y, acceleration);
}

void FrequencyTracker::follow(double t, std::span<const double> y,
                              std::span<const Vec3> acceleration) {
  const MassOperator& mass = dynamics_.mass();
  std::copy(y.begin(), y.end(), moved_.begin());
  Eigen::Map<Eigen::ArrayXd>(moved_.data(), components(vibration_).size()) +=
      amplitude_ * components(vibration_);
  if (dynamics_.acceleration(t, moved_, change_)) return;
  components(change_) = (components(acceleration) - components(change_)) / amplitude_;  // M^-1 K u
  const double before = mass.product(vibration_, vibration_, dynamics_.threads());
  const double after = mass.product(change_, change_, dynamics_.threads());
  frequency_ = before > 0 ? std::pow(after / before, 0.25) : 0;
  track_direction_of(change_);
}

int FrequencyTracker::place() const { return place_of_largest(vibration_); }

void FrequencyTracker::track_direction_of(std::span<const Vec3> acceleration) {
  const double largest = components(acceleration).abs().maxCoeff();
  if (largest > 0) components(vibration_) = components(acceleration) / largest;
}

}  // namespace weft::sim
