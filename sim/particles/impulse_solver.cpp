#include "sim/particles/impulse_solver.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "sim/scene/sphere_groups.h"

namespace weft::sim {

namespace {

// Gap of resting contacts, as a fraction of the radius. Twice this is the error of a stack of two.
constexpr double rest_gap_share = 1e-3;
// Gaps above the rest gap, as a fraction of it, up to which a contact takes part in the velocities.
constexpr double touching_share = 0.25;
// Most sweeps of one solution. Sweeps end once no relative speed changes by more than
// `small_change_share` of the resting speed. Contacts whose spheres have not changed by more since
// are not solved again.
constexpr int most_velocity_sweeps = 25;
constexpr double small_change_share = 0.1;

// Returns the first time (s) in [0, length] at which gap + speed t + acceleration t^2 / 2 is zero
// or less, or a negative number if there is none.
double closing_time(double gap, double speed, double acceleration, double length) {
  if (gap <= 0) return speed < 0 || (speed == 0 && acceleration < 0) ? 0 : -1;
  const double root = speed * speed - 2 * acceleration * gap;
  if (root < 0) return -1;
  // This form of the smaller root does not cancel.
  const double denominator = -speed + std::sqrt(root);
  if (denominator <= 0) return -1;
  const double time = 2 * gap / denominator;
  return time <= length ? time : -1;
}

}  // namespace

ImpulseSolver::ImpulseSolver(const Scene& scene) : radius_(sphere_radii(scene)) {
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const SceneBody& body = scene.bodies[b];
    for (int i = 0; i < body.particle_count(); ++i) {
      const double mass = scene.mass[body.first_particle + i], radius = body.spheres->radius;
      const double inertia = 0.4 * mass * radius * radius;
      inverse_mass_.push_back(1 / mass);
      inertia_.push_back(body.spheres->spin ? inertia : 0);
      inverse_inertia_.push_back(body.spheres->spin ? 1 / inertia : 0);
      rest_gap_.push_back(rest_gap_share * radius);
    }
  }
}

double ImpulseSolver::least_gap(const SphereContact& contact) const {
  return contact.other < 0 ? rest_gap_[contact.sphere]
                           : std::min(rest_gap_[contact.sphere], rest_gap_[contact.other]);
}

// Applies an impulse to both sides. Its normal part does not turn spheres.
void ImpulseSolver::apply(const Row& row, double along_normal, const Vec3& tangential) {
  const Vec3 impulse = along_normal * row.normal + tangential;
  const Vec3 turn = row.normal.cross(tangential);
  Motion& a = motion_[row.sphere];
  a.velocity += a.mass_share * impulse;
  a.turning -= a.turning_share * turn;
  if (row.other < 0) return;
  Motion& b = motion_[row.other];
  b.velocity -= b.mass_share * impulse;
  b.turning -= b.turning_share * turn;
}

// Sets the least normal velocity at the end of the step. Returns false if the contact neither
// touches nor closes in free motion.
bool ImpulseSolver::set_target(const SphereContact& contact, const ImpulseStep& step,
                               Row& row) const {
  const auto relative = [&](std::span<const Vec3> of) {
    const Vec3& own = of[contact.sphere];
    return contact.normal.dot(contact.other < 0 ? own : Vec3(own - of[contact.other]));
  };
  const double rest = least_gap(contact), gap = contact.gap - rest;
  const double speed = relative(step.velocity) - contact.normal.dot(contact.drive);
  const double acceleration = relative(step.acceleration);
  const double time = closing_time(gap, speed, acceleration, step.length);
  if (time < 0) {
    row.target = gap <= 0 ? 0 : -gap / step.length;
    return gap <= touching_share * rest;
  }
  const double impact_speed = -(speed + acceleration * time);
  row.is_impact = impact_speed > step.resting_speed;
  row.impact_time = time;
  const double rebound = contact.restitution * impact_speed;
  const bool parts = row.is_impact && rebound > step.resting_speed;
  row.target = parts ? rebound + acceleration * (step.length - time) : 0;
  return true;
}

void ImpulseSolver::start(const ImpulseStep& step, std::span<const Vec3> spin) {
  motion_.resize(spin.size());
  for (std::size_t i = 0; i < spin.size(); ++i) {
    motion_[i] = {step.velocity[i] + step.length * step.acceleration[i], inverse_mass_[i],
                  radius_[i] * spin[i], radius_[i] * radius_[i] * inverse_inertia_[i]};
  }
  queue_.clear(static_cast<int>(spin.size()));
}

void ImpulseSolver::make_rows(std::span<const SphereContact> contacts, const ImpulseStep& step) {
  rows_.clear();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const SphereContact& contact = contacts[c];
    Row row;
    if (!set_target(contact, step, row)) continue;
    row.contact = static_cast<int>(c);
    row.normal = contact.normal;
    row.drive = contact.drive;
    row.friction = contact.friction;
    row.sphere = contact.sphere;
    row.other = contact.other;
    const Motion& a = motion_[row.sphere];
    double normal = a.mass_share, tangential = a.mass_share + a.turning_share;
    if (row.other >= 0) {
      const Motion& b = motion_[row.other];
      normal += b.mass_share;
      tangential += b.mass_share + b.turning_share;
    }
    row.normal_mass = 1 / normal;
    row.tangential_mass = 1 / tangential;
    rows_.push_back(row);
    queue_.add(row.sphere, row.other);
  }
}

// Gives rows of contacts that rest the impulses of the last step.
void ImpulseSolver::take_kept(std::span<const SphereContact> contacts, double length) {
  if (kept_.empty()) return;
  const double scale = length / kept_length_;
  auto kept = kept_.begin();
  for (Row& row : rows_) {
    const SphereContact& contact = contacts[row.contact];
    const auto key_of = [](const KeptImpulse& of) {
      return std::tuple(of.surface, of.sphere, of.other, of.triangle);
    };
    while (kept != kept_.end() && key_of(*kept) < contact.key()) ++kept;
    if (kept == kept_.end()) return;
    if (key_of(*kept) != contact.key() || row.is_impact) continue;
    row.impulse = scale * kept->normal;
    const Vec3 tangential(kept->tangential.data());
    row.tangential = scale * (tangential - tangential.dot(contact.normal) * contact.normal);
  }
}

void ImpulseSolver::keep(std::span<const SphereContact> contacts, double length) {
  kept_.clear();
  kept_length_ = length;
  for (const Row& row : rows_) {
    if (row.is_impact || row.impulse == 0) continue;
    const SphereContact& contact = contacts[row.contact];
    kept_.push_back({contact.surface,
                     contact.sphere,
                     contact.other,
                     contact.triangle,
                     row.impulse,
                     {row.tangential[0], row.tangential[1], row.tangential[2]}});
  }
}

// Solves for the normal impulse, then for friction. The normal impulse does not change the slip, so
// one relative velocity serves both. Returns true if a change matters.
bool ImpulseSolver::solve(Row& row, double small_change) {
  const Motion& a = motion_[row.sphere];
  const bool is_pair = row.other >= 0;
  Vec3 velocity = a.velocity - row.drive, turning = a.turning;
  if (is_pair) {
    velocity -= motion_[row.other].velocity;
    turning += motion_[row.other].turning;
  }
  velocity -= turning.cross(row.normal);
  const double speed = velocity.dot(row.normal);
  const double before = row.impulse;
  row.impulse = std::max(0.0, before + row.normal_mass * (row.target - speed));
  const double change = row.impulse - before;
  Vec3 slide = Vec3::Zero();
  if (row.friction > 0) {
    const Vec3 old = row.tangential;
    row.tangential -= row.tangential_mass * (velocity - speed * row.normal);
    const double limit = row.friction * row.impulse, squared = row.tangential.squaredNorm();
    if (squared > limit * limit) row.tangential *= limit / std::sqrt(squared);
    slide = row.tangential - old;
  }
  apply(row, change, slide);
  const double least = small_change * row.normal_mass, slip = small_change * row.tangential_mass;
  return std::abs(change) > least || slide.squaredNorm() > slip * slip;
}

void ImpulseSolver::find_velocities(std::span<const SphereContact> contacts,
                                    const ImpulseStep& step, std::span<Vec3> velocity,
                                    std::span<Vec3> spin) {
  start(step, spin);
  make_rows(contacts, step);
  take_kept(contacts, step.length);
  for (const Row& row : rows_) {
    if (row.impulse != 0) apply(row, row.impulse, row.tangential);
  }
  const double small_change = small_change_share * step.resting_speed;
  const auto solve_row = [&](int index) {
    Row& row = rows_[index];
    if (!solve(row, small_change)) return;
    queue_.push_rows_of(row.sphere);
    if (row.other >= 0) queue_.push_rows_of(row.other);
    queue_.remove(index);
  };
  for (int k = 0; k < most_velocity_sweeps && queue_.sweep(solve_row); ++k) ++sweeps_;
  keep(contacts, step.length);
  for (std::size_t i = 0; i < velocity.size(); ++i) {
    velocity[i] = motion_[i].velocity;
    spin[i] = motion_[i].turning / radius_[i];
  }
}

// A sphere whose impulses P act at the times t moves by v h + a h^2/2 + sum of P/m (h - t). The
// impulses of contacts that rest act evenly, at h/2 on average.
void ImpulseSolver::find_displacements(const ImpulseStep& step, std::span<const Vec3> velocity,
                                       std::span<Vec3> mean) const {
  for (std::size_t i = 0; i < mean.size(); ++i) mean[i] = 0.5 * (step.velocity[i] + velocity[i]);
  for (const Row& row : rows_) {
    if (!row.is_impact) continue;
    const Vec3 impulse = row.impulse * row.normal + row.tangential;
    const double share = 0.5 - row.impact_time / step.length;
    mean[row.sphere] += share * inverse_mass_[row.sphere] * impulse;
    if (row.other >= 0) mean[row.other] -= share * inverse_mass_[row.other] * impulse;
  }
}

void ImpulseSolver::transfer(StateArchive& archive) { archive(kept_, kept_length_, sweeps_); }

}  // namespace weft::sim
