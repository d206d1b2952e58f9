#include "sim/motion/energy_watch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "sim/motion/tolerances.h"

namespace weft::sim {

namespace {

constexpr double energy_share = 0.05;

// Equilibria under growing loads have no motion that work could become.
bool can_be_watched(const Scene& scene) {
  if (scene.source.time.method != TimeMethod::static_loads) return true;
  const auto& bodies = scene.bodies;
  const bool drags = std::any_of(bodies.begin(), bodies.end(), [](const SceneBody& body) {
    return body.dynamic && (body.material->normal_drag > 0 || body.material->tangential_drag > 0);
  });
  const bool moves = std::any_of(scene.prescribed.begin(), scene.prescribed.end(),
                                 [](const PrescribedMotion& held) { return held.moves; });
  return !moves && !(drags && !scene.source.world.wind.isZero());
}

// m: the diagonal of the box around the start.
double size_of_start(const Scene& scene) {
  Eigen::AlignedBox3d box;
  for (int i = 0; i < scene.dynamic_particles; ++i) box.extend(scene.initial_position[i]);
  return box.diagonal().norm();
}

}  // namespace

EnergyWatch::EnergyWatch(Dynamics& dynamics, std::span<const double> start)
    : scene_(dynamics.scene()),
      external_(dynamics, start),
      applies_(can_be_watched(scene_)),
      mass_(std::accumulate(scene_.mass.begin(), scene_.mass.end(), 0.0)),
      longest_fall_(size_of_start(scene_)) {
  const Energies energies = dynamics.energies(0, start);
  start_ =
      energies.total() - external_.held_kinetic_energy() - external_.held_gravitational_energy();
  start_kinetic_ = energies.kinetic - external_.held_kinetic_energy();
}

// J: by gravity alone, from rest.
double EnergyWatch::fall_energy(double time) const {
  const double gravity = scene_.source.world.gravity.norm();
  // Steps of equilibria are loads, not times.
  const bool is_motion = scene_.source.time.method != TimeMethod::static_loads;
  const double fall = is_motion ? 0.5 * gravity * time * time : longest_fall_;
  return mass_ * gravity * std::min(longest_fall_, fall);
}

std::optional<std::string> EnergyWatch::check(double time, std::span<const double> y,
                                              const Energies& now) {
  if (!applies_) return std::nullopt;
  external_.add_step(time, y);
  const double within =
      now.total() - now.gravitational - now.contact - external_.held_kinetic_energy();
  const double gravitational = now.gravitational - external_.held_gravitational_energy();
  const double put_in = start_ - gravitational + external_.work();
  most_ = std::max({most_, put_in, start_kinetic_ + fall_energy(time)});
  const TimeCase& options = scene_.source.time;
  const double error = std::sqrt(1.5 * mass_) * velocity_tolerance(options) +
                       options.relative_tolerance * std::sqrt(most_);
  const double limit =
      std::sqrt(std::max(put_in + external_.doubt(), 0.0) + energy_share * most_) + error;
  const double share = within / (limit * limit);
  largest_share_ = std::max(largest_share_, share);
  // A share that is not finite is too large, too.
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
