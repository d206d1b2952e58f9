#include "sim/motion/external_work.h"
#include "sim/case/time_methods.h"

#include <cmath>

namespace weft::sim {

ExternalWork::ExternalWork(Dynamics& dynamics, std::span<const double> y, double time)
    : dynamics_(dynamics), time_(time) {
  const Scene& scene = dynamics.scene();
  // Equilibria have neither time nor velocity.
  if (traits_of(scene.source.time.method).finds_equilibria()) return;
  for (const PrescribedMotion& held : scene.prescribed) {
    if (!held.moves || held.particles.empty()) continue;
    const bool is_pin = held.particles.front() < scene.dynamic_particles;
    if (is_pin) moved_.insert(moved_.end(), held.particles.begin(), held.particles.end());
    obstacles_move_ |= !is_pin;
  }
  counts_external_ =
      dynamics.has_external_forces() && (is_moved() || !scene.source.world.wind.isZero());
  force_.resize(moved_.size());
  place_ = last_place_ = last_force_ = force_;
  if (is_possible()) measure(time, y);
}

void ExternalWork::transfer(StateArchive& archive) {
  std::size_t loads = loads_.size();
  archive(time_, power_, force_, place_, work_, doubt_, held_kinetic_energy_,
          held_gravitational_energy_, loads);
  loads_.resize(loads);
  for (Load& load : loads_) archive(load.particle, load.force);
  if (archive.reads() && obstacles_move_)
    dynamics_.contact()->obstacles().find_poses(time_, false, poses_);
}

void ExternalWork::add_step(double time, std::span<const double> y) {
  if (!is_possible()) return;
  last_force_.swap(force_);
  last_place_.swap(place_);
  last_loads_.swap(loads_);
  last_poses_.swap(poses_);
  last_power_ = power_;
  const double h = time - time_;
  measure(time, y);
  double mean = 0, change = 0;
  visit_loads([&](const Vec3& last_force, const Vec3& force, const Vec3& way) {
    mean += 0.5 * (force + last_force).dot(way);
    change += (force - last_force).dot(way);
  });
  for (std::size_t i = 0; i < moved_.size(); ++i) {
    const Vec3 way = place_[i] - last_place_[i];
    mean += 0.5 * (force_[i] + last_force_[i]).dot(way);
    change += (force_[i] - last_force_[i]).dot(way);
  }
  work_ += 0.5 * h * (power_ + last_power_) - mean;
  doubt_ += 0.5 * (std::abs(change) + h * std::abs(power_ - last_power_));
}

// Calls visit(force before, force now, way) for the particles of obstacles that have a force at one
// end of the step or at both, in order.
template <class Visit>
void ExternalWork::visit_loads(const Visit& visit) const {
  if (loads_.empty() && last_loads_.empty()) return;
  const Scene& scene = dynamics_.scene();
  const RigidObstacles& obstacles = dynamics_.contact()->obstacles();
  auto now = loads_.begin(), before = last_loads_.begin();
  while (now != loads_.end() || before != last_loads_.end()) {
    const bool has_before =
        before != last_loads_.end() && (now == loads_.end() || before->particle <= now->particle);
    const bool has_now = now != loads_.end() && (!has_before || now->particle == before->particle);
    const int particle = has_now ? now->particle : before->particle;
    const int number = obstacles.of_body(scene.body_index_of_particle(particle));
    if (number >= 0) {
      const RigidObstacle& obstacle = obstacles.all()[number];
      const Vec3& start = obstacle.held->start[particle - obstacle.first_particle];
      const Vec3 way = poses_[number].place(start) - last_poses_[number].place(start);
      visit(has_before ? before->force : Vec3(Vec3::Zero()),
            has_now ? now->force : Vec3(Vec3::Zero()), way);
    }
    if (has_before) ++before;
    if (has_now) ++now;
  }
}

void ExternalWork::measure(double time, std::span<const double> y) {
  time_ = time;
  if (counts_external_) power_ = dynamics_.external_power(time, y);
  if (!is_moved()) return;
  const Scene& scene = dynamics_.scene();
  dynamics_.find_forces_on_all(time, y, all_forces_, loaded_particles_);
  dynamics_.expand(time, y, position_, velocity_);
  loads_.clear();
  for (const int particle : loaded_particles_) loads_.push_back({particle, all_forces_[particle]});
  if (dynamics_.contact() != nullptr)
    dynamics_.contact()->obstacles().find_poses(time, false, poses_);
  held_kinetic_energy_ = held_gravitational_energy_ = 0;
  for (std::size_t i = 0; i < moved_.size(); ++i) {
    const int particle = moved_[i];
    force_[i] = all_forces_[particle];
    place_[i] = position_[particle];
    const double mass = scene.mass[particle];
    held_kinetic_energy_ += 0.5 * mass * velocity_[particle].squaredNorm();
    held_gravitational_energy_ -= mass * scene.source.world.gravity.dot(place_[i]);
  }
}

}  // namespace weft::sim
