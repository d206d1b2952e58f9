#include "sim/motion/energy_watch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "sim/case/time_methods.h"
#include "sim/motion/tolerances.h"

namespace weft::sim {

namespace {

constexpr double energy_share = 0.05;

// Part of what the test allows for errors above which the energy counts as gained.
constexpr double gain_part = 0.1;

// True for methods that compute motions. For searches for equilibria, true only under proportional
// loading without prescribed motion, applied loads and wind that acts on a body. The work of these
// three never becomes motion.
bool can_be_watched(const Dynamics& dynamics) {
  const Scene& scene = dynamics.scene();
  // Impulses never add energy to spheres, and obstacles that move do work that is not evaluated.
  if (scene.source.time.method == TimeMethod::impulses) return false;
  if (!traits_of(scene.source.time.method).finds_equilibria()) return true;
  if (scene.source.equilibria.loading != Loading::proportional || dynamics.has_loads())
    return false;
  const bool moves = std::any_of(scene.prescribed.begin(), scene.prescribed.end(),
                                 [](const PrescribedMotion& held) { return held.moves; });
  return !moves && !dynamics.has_moving_points() &&
         !(dynamics.has_external_forces() && !scene.source.world.wind.is_zero());
}

// Returns the diagonal (m) of the box around the dynamic bodies at the start.
double size_of_start(const Scene& scene) {
  Eigen::AlignedBox3d box;
  for (int i = 0; i < scene.dynamic_particles; ++i) box.extend(scene.initial_position[i]);
  return box.diagonal().norm();
}

}  // namespace

EnergyWatch::EnergyWatch(Dynamics& dynamics, std::span<const double> start, double start_time)
    : scene_(dynamics.scene()),
      dynamics_(dynamics),
      external_(dynamics, start, start_time),
      applies_(can_be_watched(dynamics)),
      start_time_(start_time),
      mass_(std::accumulate(scene_.mass.begin(), scene_.mass.end(), 0.0)),
      longest_fall_(size_of_start(scene_)) {
  const Energies energies = dynamics.energies(start_time, start);
  start_ = energies.total() - energies.gravitational + gravitational(start_time, start, energies) -
           external_.held_kinetic_energy() - external_.held_gravitational_energy();
  start_dissipated_ = energies.dissipated.value_or(0);
  start_kinetic_ = energies.kinetic - external_.held_kinetic_energy();
}

// Returns the energy (J) of a free fall from rest that lasts until `time`.
double EnergyWatch::fall_energy(double time) const {
  time -= start_time_;
  if (scene_.source.world.gravity.varies()) {
    const double speed = external_.fall_speed();
    return mass_ * std::min(external_.largest_gravity() * longest_fall_, 0.5 * speed * speed);
  }
  const double gravity = scene_.source.world.gravity.constant().norm();
  // In searches for equilibria, `time` is the load, so the fall is not limited by it.
  const bool is_motion = !traits_of(scene_.source.time.method).finds_equilibria();
  const double fall = is_motion ? 0.5 * gravity * time * time : longest_fall_;
  return mass_ * gravity * std::min(longest_fall_, fall);
}

// Returns the gravitational energy (J) under the whole weight, whatever the load of an equilibrium.
double EnergyWatch::gravitational(double time, std::span<const double> y,
                                  const Energies& now) const {
  if (!traits_of(scene_.source.time.method).finds_equilibria()) return now.gravitational;
  return -dynamics_.gravity(time).dot(dynamics_.moment_of_weight(StateView::of(y).position));
}

void EnergyWatch::transfer(StateArchive& archive) {
  archive(start_time_, start_, start_dissipated_, start_kinetic_, most_, largest_share_);
  external_.transfer(archive);
}

std::optional<Failure> EnergyWatch::check(double time, std::span<const double> y,
                                          const Energies& now) {
  if (!applies_) return std::nullopt;
  external_.add_step(time, y);
  const double within = now.total() - now.gravitational - now.contact - now.constraints -
                        external_.held_kinetic_energy();
  const double height = gravitational(time, y, now) - external_.held_gravitational_energy();
  const double put_in =
      start_ - height + external_.work() - (now.dissipated.value_or(0) - start_dissipated_);
  most_ = std::max({most_, put_in, start_kinetic_ + fall_energy(time)});
  const TimeCase& options = scene_.source.time;
  const double error = std::sqrt(1.5 * mass_) * velocity_tolerance(options) +
                       options.relative_tolerance * std::sqrt(most_);
  const double given = std::max(put_in + external_.doubt(), 0.0);
  const double limit = std::sqrt(given + energy_share * most_) + error;
  has_gain_ = std::sqrt(within) > (1 - gain_part) * std::sqrt(given) + gain_part * limit;
  const double share = within / (limit * limit);
  largest_share_ = std::max(largest_share_, share);
  // A NaN fails this comparison.
  if (share <= 1) return std::nullopt;
  return failure(time, y, within, put_in);
}

Failure EnergyWatch::failure(double time, std::span<const double> y, double within,
                             double put_in) const {
  const std::span<const Vec3> velocity = StateView::of(y).velocity;
  const auto fastest = std::max_element(
      velocity.begin(), velocity.end(),
      [](const Vec3& a, const Vec3& b) { return a.squaredNorm() < b.squaredNorm(); });
  const int particle = static_cast<int>(fastest - velocity.begin());
  char numbers[128];
  std::snprintf(numbers, sizeof numbers, "%.3g J at t = %.6g s, of %.3g J put in", within, time,
                put_in);
  return {Failure::Kind::energy, time, particle,
          std::string("the motion has gained energy: ") + numbers + "; fastest is " +
              scene_.describe_particle(particle) +
              (scene_.source.time.step ? " (time.step is too long)"
                                       : " (the tolerances are too loose)")};
}

}  // namespace weft::sim
