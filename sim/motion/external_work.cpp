#include "sim/motion/external_work.h"

#include <algorithm>
#include <cmath>

#include "sim/case/time_methods.h"
#include "sim/motion/particle_masses.h"
#include "sim/scene/scene_curves.h"
#include "sim/scene/sliding_supports.h"

namespace weft::sim {

ExternalWork::ExternalWork(Dynamics& dynamics, std::span<const double> y, double time)
    : dynamics_(dynamics), time_(time) {
  const Scene& scene = dynamics.scene();
  // Searches for equilibria compute no motion, so no work is summed.
  if (traits_of(scene.source.time.method).finds_equilibria()) return;
  for (const PrescribedMotion& held : scene.prescribed) {
    if (!held.moves || held.particles.empty()) continue;
    const bool is_pin = held.particles.front() < scene.dynamic_particles;
    if (is_pin) moved_.insert(moved_.end(), held.particles.begin(), held.particles.end());
    obstacles_move_ |= !is_pin;
  }
  counts_external_ =
      dynamics.has_loads() || dynamics.has_moving_points() ||
      (dynamics.has_external_forces() && (is_moved() || !scene.source.world.wind.is_zero()));
  gravity_varies_ = scene.source.world.gravity.varies();
  for (const MotionEvent& event : SceneCurves(scene.source).events()) {
    if (event.jumps) jumps_.push_back(event.time);
  }
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    if (!scene.bodies[b].supports) continue;
    for (const MotionEvent& event : events_of(*scene.bodies[b].supports)) {
      if (event.jumps) jumps_.push_back(event.time);
    }
  }
  std::ranges::sort(jumps_);
  force_.resize(moved_.size());
  place_ = last_place_ = last_force_ = force_;
  if (!is_possible()) return;
  measure(time, y);
  next_power_ = power_;
  if (!gravity_varies_) return;
  gravity_ = dynamics.gravity(time);
  moment_ = free_moment(y);
}

void ExternalWork::transfer(StateArchive& archive) {
  std::size_t loads = loads_.size();
  archive(gravity_, moment_, fall_speed_, largest_gravity_, next_power_);
  archive(time_, power_, force_, place_, work_, doubt_, held_kinetic_energy_,
          held_gravitational_energy_, loads);
  loads_.resize(loads);
  for (Load& load : loads_) archive(load.particle, load.force);
  if (archive.reads() && obstacles_move_ && dynamics_.contact() != nullptr)
    dynamics_.contact()->obstacles().find_poses(time_, false, poses_);
}

void ExternalWork::add_step(double time, std::span<const double> y) {
  if (!is_possible()) return;
  last_force_.swap(force_);
  last_place_.swap(place_);
  last_loads_.swap(loads_);
  last_poses_.swap(poses_);
  const double start = time_, h = time - time_, last_power = next_power_;
  measure(time, y);
  next_power_ = power_after_jump(time, y);
  if (gravity_varies_) add_gravity(start, time, y);
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
  work_ += 0.5 * h * (power_ + last_power) - mean;
  doubt_ += 0.5 * (std::abs(change) + h * std::abs(power_ - last_power));
  if (dynamics_.scene().source.time.newton > 0)
    doubt_ += h * std::max(0.0, -dynamics_.power_of_closing_seams(time, y));
}

// Returns the power (W) of external forces at the start of the next step, after any jump at `time`.
// Adds the kinetic energy that supports supply by a jump of their velocity. What they take is left
// out: some methods take it at the start of the next step.
double ExternalWork::power_after_jump(double time, std::span<const double> y) {
  const double nearby = dynamics_.scene().source.time.minimum_step;
  const auto jump = std::ranges::lower_bound(jumps_, time - nearby);
  const bool jumps = jump != jumps_.end() && *jump <= time + nearby;
  if (!jumps || !counts_external_) return power_;
  std::vector<double> after(y.begin(), y.end());
  dynamics_.match_supports(time, after);
  const std::span<const Vec3> v = StateView::of(y).velocity, w = StateView::of(after).velocity;
  const MassOperator& inertia = dynamics_.mass();
  work_ += std::max(0.0, 0.5 * (inertia.product(w, w, 1) - inertia.product(v, v, 1)));
  const double step_start = dynamics_.step_start();
  dynamics_.begin_step(time);
  const double power = dynamics_.external_power(time, after);
  dynamics_.begin_step(step_start);
  return power;
}

void ExternalWork::add_gravity(double start, double time, std::span<const double> y) {
  const Vec3 first = dynamics_.gravity(start), last = dynamics_.gravity(time);
  const Vec3 moment = free_moment(y);
  work_ -= moment_.dot(first - gravity_) + 0.5 * (moment_ + moment).dot(last - first);
  doubt_ += 0.5 * (moment - moment_).cwiseAbs().dot((last - first).cwiseAbs());
  fall_speed_ += 0.5 * (time - start) * (first.norm() + last.norm());
  largest_gravity_ = std::max({largest_gravity_, first.norm(), last.norm()});
  gravity_ = last;
  moment_ = moment;
}

// Returns sum m x (kg m) over the free particles. Precondition if pins or obstacles move: measure()
// has set position_ and place_ for y.
Vec3 ExternalWork::free_moment(std::span<const double> y) const {
  const Scene& scene = dynamics_.scene();
  Vec3 moment = dynamics_.moment_of_weight(is_moved() ? std::span<const Vec3>(position_)
                                                      : StateView::of(y).position);
  for (std::size_t i = 0; i < moved_.size(); ++i) moment -= scene.mass[moved_[i]] * place_[i];
  return moment;
}

// Calls visit(force before, force now, displacement) for each particle of a moving obstacle on
// which a force acts at the start or the end of the step. Particles are visited in ascending order.
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
  const MassOperator& inertia = dynamics_.mass();
  std::vector<Vec3> held_velocity(inertia.is_diagonal() ? 0 : scene.dynamic_particles,
                                  Vec3::Zero());
  const Vec3 gravity = dynamics_.gravity(time);
  for (std::size_t i = 0; i < moved_.size(); ++i) {
    const int particle = moved_[i];
    force_[i] = all_forces_[particle];
    place_[i] = position_[particle];
    const double mass = scene.mass[particle];
    held_gravitational_energy_ -= mass * gravity.dot(place_[i]);
    if (inertia.is_diagonal()) {
      held_kinetic_energy_ += 0.5 * mass * velocity_[particle].squaredNorm();
    } else {
      held_velocity[particle] = velocity_[particle];
    }
  }
  if (!held_velocity.empty())
    held_kinetic_energy_ = 0.5 * inertia.product(held_velocity, held_velocity, 1);
}

}  // namespace weft::sim
