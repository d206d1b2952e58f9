#include "sim/integrator/energy_watch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "sim/integrator/tolerances.h"

namespace weft::sim {

namespace {

constexpr double energy_share = 0.05;

bool only_gravity_works(const Scene& scene) {
  const auto& bodies = scene.bodies;
  const bool drags = std::any_of(bodies.begin(), bodies.end(), [](const SceneBody& body) {
    return body.dynamic && (body.material->normal_drag > 0 || body.material->tangential_drag > 0);
  });
  const bool moves = std::any_of(scene.prescribed.begin(), scene.prescribed.end(),
                                 [](const PrescribedMotion& held) { return held.moves; });
  return !moves && !(drags && !scene.source.world.wind.isZero());
}

// m, the most that counts as a fall.
double longest_fall(const Scene& scene) {
  Eigen::AlignedBox3d box;
  for (int i = 0; i < scene.dynamic_particles; ++i) box.extend(scene.initial_position[i]);
  const double duration = scene.source.time.duration;
  return std::min(box.diagonal().norm(),
                  0.5 * scene.source.world.gravity.norm() * duration * duration);
}

}  // namespace

EnergyWatch::EnergyWatch(const Scene& scene, const Energies& start)
    : scene_(scene),
      applies_(only_gravity_works(scene)),
      mass_(std::accumulate(scene.mass.begin(), scene.mass.end(), 0.0)),
      start_(start.total()),
      most_(start.kinetic + mass_ * scene.source.world.gravity.norm() * longest_fall(scene)) {}

std::optional<std::string> EnergyWatch::check(double time, std::span<const double> y,
                                              const Energies& now) {
  if (!applies_) return std::nullopt;
  const double within = now.total() - now.gravitational - now.contact;
  const double put_in = start_ - now.gravitational;
  most_ = std::max(most_, put_in);
  const TimeCase& options = scene_.source.time;
  const double error = std::sqrt(1.5 * mass_) * velocity_tolerance(options) +
                       options.relative_tolerance * std::sqrt(most_);
  const double limit = std::sqrt(std::max(put_in, 0.0) + energy_share * most_) + error;
  const double share = within / (limit * limit);
  largest_share_ = std::max(largest_share_, share);
  // Not finite is too much, too.
  if (share <= 1) return std::nullopt;
  return describe(time, y, within, put_in);
}

std::string EnergyWatch::describe(double time, std::span<const double> y, double within,
                                  double put_in) const {
  const std::span<const Vec3> velocity = StateView::of(y).velocity;
  const auto fastest = std::max_element(
      velocity.begin(), velocity.end(),
      [](const Vec3& a, const Vec3& b) { return a.squaredNorm() < b.squaredNorm(); });
  char numbers[128];
  std::snprintf(numbers, sizeof numbers, "%.3g J at t = %.6g s, of %.3g J put in", within, time,
                put_in);
  return std::string("the motion has gained energy: ") + numbers + "; fastest is " +
         scene_.describe_particle(static_cast<int>(fastest - velocity.begin())) +
         (scene_.source.time.step ? " (time.step is too long)" : " (the tolerances are too loose)");
}

}  // namespace weft::sim
