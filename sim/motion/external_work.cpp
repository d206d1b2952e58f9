#include "sim/motion/external_work.h"
#include "sim/case/time_methods.h"

#include <cmath>

namespace weft::sim {

ExternalWork::ExternalWork(Dynamics& dynamics, std::span<const double> y, double time)
    : dynamics_(dynamics), time_(time) {
  const Scene& scene = dynamics.scene();
  // Equilibria know neither time nor velocity.
  if (traits_of(scene.source.time.method).finds_equilibria()) return;
  for (const PrescribedMotion& held : scene.prescribed) {
    if (held.moves) moved_.insert(moved_.end(), held.particles.begin(), held.particles.end());
  }
  counts_external_ =
      dynamics.has_external_forces() && (!moved_.empty() || !scene.source.world.wind.isZero());
  force_.resize(moved_.size());
  place_ = last_place_ = last_force_ = force_;
  if (is_possible()) measure(time, y);
}

void ExternalWork::add_step(double time, std::span<const double> y) {
  if (!is_possible()) return;
  last_force_.swap(force_);
  last_place_.swap(place_);
  last_power_ = power_;
  const double h = time - time_;
  measure(time, y);
  double mean = 0, change = 0;
  for (std::size_t i = 0; i < moved_.size(); ++i) {
    const Vec3 way = place_[i] - last_place_[i];
    mean += 0.5 * (force_[i] + last_force_[i]).dot(way);
    change += (force_[i] - last_force_[i]).dot(way);
  }
  work_ += 0.5 * h * (power_ + last_power_) - mean;
  doubt_ += 0.5 * (std::abs(change) + h * std::abs(power_ - last_power_));
}

void ExternalWork::measure(double time, std::span<const double> y) {
  time_ = time;
  if (counts_external_) power_ = dynamics_.external_power(time, y);
  if (moved_.empty()) return;
  const Scene& scene = dynamics_.scene();
  dynamics_.find_forces_on_all(time, y, all_forces_);
  dynamics_.expand(time, y, position_, velocity_);
  held_kinetic_energy_ = held_gravitational_energy_ = 0;
  for (std::size_t i = 0; i < moved_.size(); ++i) {
    const int particle = moved_[i];
    force_[i] = all_forces_[particle];
    place_[i] = position_[particle];
    if (particle >= scene.dynamic_particles) continue;
    const double mass = scene.mass[particle];
    held_kinetic_energy_ += 0.5 * mass * velocity_[particle].squaredNorm();
    held_gravitational_energy_ -= mass * scene.source.world.gravity.dot(place_[i]);
  }
}

}  // namespace weft::sim
