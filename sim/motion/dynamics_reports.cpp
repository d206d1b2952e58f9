// Energies, powers and forces of a state, for reports and records.
#include <algorithm>
#include <cmath>

#include "sim/motion/dynamics.h"

namespace weft::sim {

std::vector<std::string> Dynamics::force_names() const {
  std::vector<std::string> names;
  for (const auto& force : forces_) names.emplace_back(force->name());
  return names;
}

Vec3 Dynamics::moment_of_weight(std::span<const Vec3> position) const {
  const auto count = static_cast<std::size_t>(scene_.heavy_particles);
  return mass_moment(std::span(scene_.mass).first(count), position.first(count));
}

Energies Dynamics::energies_at_last_rate(double time, std::span<const double> y) {
  const PhaseTimer timer(statistics_.phases.energies);
  const Kinematics state = kinematics(time, y);
  Energies energies;
  energies.kinetic = 0.5 * mass_.product(state.velocity, state.velocity, threads_);
  energies.gravitational = -load() * gravity_.dot(moment_of_weight(state.position));
  if (creases_) energies.dissipated = 0;
  for (const auto& force : forces_) {
    energies.elastic.emplace_back(force->name(), force->energy(state, threads_));
    if (force->is_constraint()) energies.constraints += energies.elastic.back().second;
    if (creases_) *energies.dissipated += force->dissipated(state, threads_);
  }
  if (contact_) energies.contact = contact_->energy();
  return energies;
}

Energies Dynamics::energies(double time, std::span<const double> y) {
  if (contact_) {
    set_time(time);
    expand(time, y, position_, velocity_);
    // After a fault, contact would have no pairs. Accepted states have no fault.
    static_cast<void>(evaluate_contact(time));
  }
  return energies_at_last_rate(time, y);
}

double Dynamics::external_power(double time, std::span<const double> y) {
  const Kinematics state = kinematics(time, y);
  std::vector<Vec3> force(state.position.size(), Vec3::Zero());
  for (const auto& each : forces_) {
    if (each->is_external()) each->add_forces(state, force, threads_);
  }
  for (const int i : held_) force[i].setZero();
  double power = 0;
  for (std::size_t i = 0; i < force.size(); ++i) power += force[i].dot(state.velocity[i]);
  for (const auto& each : forces_) power += each->power_of_moving_points(state);
  return power;
}

double Dynamics::power_of_closing_seams(double time, std::span<const double> y) {
  const Kinematics state = kinematics(time, y);
  double power = 0;
  for (const auto& each : forces_) power += each->power_of_closing_seams(state);
  return power;
}

void Dynamics::find_forces_on_all(double time, std::span<const double> y, std::vector<Vec3>& force,
                                  std::vector<int>& loaded) {
  set_time(time);
  expand(time, y, position_, velocity_);
  const auto count = static_cast<std::size_t>(scene_.dynamic_particles);
  force.resize(position_.size(), Vec3::Zero());
  std::fill_n(force.begin(), count, Vec3::Zero());
  for (const int particle : loaded) force[particle].setZero();
  loaded.clear();
  const Kinematics state{std::span(position_).first(count), std::span(velocity_).first(count)};
  for (const auto& each : forces_) {
    if (!each->is_external()) each->add_forces(state, std::span(force).first(count), threads_);
  }
  if (contact_) {
    // After a fault, contact would have no pairs. Accepted states have no fault.
    static_cast<void>(evaluate_contact(time));
    contact_->add_forces(force);
    contact_->find_loaded_obstacles(loaded);
  }
  if (!mass_.is_diagonal() && pins_move_)
    subtract_coupled_inertia(time, state, std::span(force).first(count));
}

// Subtracts M_pf (a_f - r v_f) from the forces F_p on pins p, with the free particles f and the
// rate r of mass damping. The energy E = v_f . M_ff v_f / 2 + v_f . M_fp v_p + U excludes the
// kinetic energy of the pins alone. Without external forces, dE/dt is at most -F_p . v_p with the
// reduced F_p.
void Dynamics::subtract_coupled_inertia(double time, const Kinematics& state,
                                        std::span<Vec3> force) {
  std::vector<Vec3> inertia(force.begin(), force.end());
  for (const auto& each : forces_) {
    if (each->is_external()) each->add_forces(state, inertia, threads_);
  }
  add_weight_and_damping(state, inertia);
  solve_for_accelerations(time, inertia);
  for (std::size_t i = 0; i < mass_damping_.size(); ++i) {
    if (scene_.pinned[i] == 0) inertia[i] -= mass_damping_[i] * state.velocity[i];
  }
  for (const int i : held_) force[i] -= mass_.row_product(i, inertia.data());
}

void Dynamics::find_force_parts(double time, std::span<const double> y, ForceParts& parts) {
  set_time(time);
  expand(time, y, position_, velocity_);
  if (load_) std::fill(velocity_.begin(), velocity_.end(), Vec3::Zero());
  const auto count = static_cast<std::size_t>(scene_.dynamic_particles);
  const Kinematics state{std::span(position_).first(count), std::span(velocity_).first(count)};
  parts.own.resize(count);
  add_forces(state, parts.own);
  parts.outer.clear();
  for (const auto& each : forces_) each->list_outer_forces(state, parts.outer);
  add_weight_and_damping(state, parts.own);
  parts.contact.assign(count, Vec3::Zero());
  parts.friction.assign(count, Vec3::Zero());
  parts.obstacles.assign(scene_.bodies.size(), {});
  if (contact_) {
    // After a fault, contact would have no pairs. Accepted states have no fault.
    static_cast<void>(evaluate_contact(time));
    contact_->add_forces(parts.contact, parts.friction);
    contact_->add_wrenches(position_, parts.obstacles);
  }
  find_forces_of_pins(time, parts);
}

// A pin exerts M a - F on the particles that it holds. With the consistent mass of shells, M a
// includes accelerations of free particles.
void Dynamics::find_forces_of_pins(double time, ForceParts& parts) {
  const auto force = [&](int i) {
    return Vec3(parts.own[i] + parts.contact[i] + parts.friction[i]);
  };
  parts.support.assign(parts.own.size(), Vec3::Zero());
  if (mass_.is_diagonal() || held_.empty()) {
    find_accelerations_of_pins(time, parts.support);
    for (const int i : held_) {
      parts.support[i] =
          scene_.mass[i] * parts.support[i] - parts.own[i] - parts.contact[i] - parts.friction[i];
    }
    return;
  }
  std::vector<Vec3> acceleration(parts.own.size());
  for (int i = 0; i < particle_count(); ++i) acceleration[i] = force(i);
  solve_for_accelerations(time, acceleration);
  find_accelerations_of_pins(time, acceleration);
  for (const int i : held_) parts.support[i] = mass_.row_product(i, acceleration.data()) - force(i);
}

Dynamics::LargestStretch Dynamics::find_largest_stretch(std::span<const Vec3> position) const {
  double largest = -1;
  int particle = 0;
  std::vector<Vec3> room, rest_room;
  for (int b = 0; b < scene_.dynamic_bodies; ++b) {
    const SceneBody& body = scene_.bodies[b];
    const SurfaceMap& map = image_maps_[b];
    const int count = body.particle_count();
    const auto x = map.points_of(position.subspan(body.first_particle, count), count, room);
    const auto rest = map.points_of(body.rest, count, rest_room);
    for (const std::array<int, 3>& triangle : body.mesh.triangles) {
      for (int i = 0; i < 3; ++i) {
        const int p = triangle[i], q = triangle[(i + 1) % 3];
        const double ratio = (x[p] - x[q]).squaredNorm() / (rest[p] - rest[q]).squaredNorm();
        if (!(ratio > largest)) continue;
        largest = ratio;
        particle = body.first_particle + p;
      }
    }
  }
  if (largest < 0) return {0, particle};  // only spheres, which have no edges
  return {std::sqrt(largest) - 1, particle};
}

double Dynamics::largest_displacement(std::span<const Vec3> position) const {
  double largest = 0;
  std::vector<Vec3> room, start_room;
  const std::span<const Vec3> start_position(scene_.initial_position);
  for (int b = 0; b < scene_.dynamic_bodies; ++b) {
    const SceneBody& body = scene_.bodies[b];
    const int count = body.particle_count();
    const auto points_of = [&](std::span<const Vec3> all, std::vector<Vec3>& into) {
      return image_maps_[b].points_of(all.subspan(body.first_particle, count), count, into);
    };
    const auto now = points_of(position, room), start = points_of(start_position, start_room);
    for (int i = 0; i < count; ++i) largest = std::max(largest, (now[i] - start[i]).norm());
  }
  return largest;
}

}  // namespace weft::sim
