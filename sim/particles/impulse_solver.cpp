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
// Fraction of a lacking gap that one step restores. Faster restoring would add energy.
constexpr double restored_share = 0.2;
// Most sweeps of one solution. Sweeps end once no speed changes by more than `small_change` of the
// resting speed, or no gap lacks more than `small_lack` of the rest gap.
constexpr int most_sweeps = 15;
constexpr double small_change = 0.1, small_lack = 0.3;
// A contact whose gap at the end, before corrections, exceeds this multiple of the rest gap takes
// no part in the corrections.
constexpr double clear_gap = 3;

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

Vec3 ImpulseSolver::relative_velocity(const SphereContact& contact, const Speeds& speeds) const {
  const int a = contact.sphere, b = contact.other;
  const Vec3 own = speeds.velocity[a] - radius_[a] * speeds.spin[a].cross(contact.normal);
  if (b < 0) return own - contact.drive;
  return own - speeds.velocity[b] - radius_[b] * speeds.spin[b].cross(contact.normal);
}

void ImpulseSolver::apply(const SphereContact& contact, const Vec3& impulse,
                          const Speeds& speeds) const {
  const int a = contact.sphere, b = contact.other;
  const Vec3 turn = contact.normal.cross(impulse);
  speeds.velocity[a] += inverse_mass_[a] * impulse;
  speeds.spin[a] -= radius_[a] * inverse_inertia_[a] * turn;
  if (b < 0) return;
  speeds.velocity[b] -= inverse_mass_[b] * impulse;
  speeds.spin[b] -= radius_[b] * inverse_inertia_[b] * turn;
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

void ImpulseSolver::make_rows(std::span<const SphereContact> contacts, const ImpulseStep& step) {
  rows_.clear();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const SphereContact& contact = contacts[c];
    Row row;
    row.contact = static_cast<int>(c);
    if (!set_target(contact, step, row)) continue;
    const auto add = [&](int sphere, double& normal, double& tangential) {
      const double radius = radius_[sphere];
      normal += inverse_mass_[sphere];
      tangential += inverse_mass_[sphere] + radius * radius * inverse_inertia_[sphere];
    };
    double normal = 0, tangential = 0;
    add(contact.sphere, normal, tangential);
    if (contact.other >= 0) add(contact.other, normal, tangential);
    row.normal_mass = 1 / normal;
    row.tangential_mass = 1 / tangential;
    rows_.push_back(row);
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
    row.normal = scale * kept->normal;
    const Vec3 tangential(kept->tangential.data());
    row.tangential = scale * (tangential - tangential.dot(contact.normal) * contact.normal);
  }
}

void ImpulseSolver::keep(std::span<const SphereContact> contacts, double length) {
  kept_.clear();
  kept_length_ = length;
  for (const Row& row : rows_) {
    if (row.is_impact || row.normal == 0) continue;
    const SphereContact& contact = contacts[row.contact];
    kept_.push_back({contact.surface,
                     contact.sphere,
                     contact.other,
                     contact.triangle,
                     row.normal,
                     {row.tangential[0], row.tangential[1], row.tangential[2]}});
  }
}

// Returns the change of the relative speed (m/s).
double ImpulseSolver::solve_normal(const SphereContact& contact, Row& row,
                                   const Speeds& speeds) const {
  const double speed = contact.normal.dot(relative_velocity(contact, speeds));
  const double before = row.normal;
  row.normal = std::max(0.0, before + row.normal_mass * (row.target - speed));
  const double change = row.normal - before;
  if (change != 0) apply(contact, change * contact.normal, speeds);
  return std::abs(change) / row.normal_mass;
}

double ImpulseSolver::solve_friction(const SphereContact& contact, Row& row,
                                     const Speeds& speeds) const {
  const Vec3 velocity = relative_velocity(contact, speeds);
  const Vec3 slip = velocity - velocity.dot(contact.normal) * contact.normal;
  const Vec3 before = row.tangential;
  row.tangential -= row.tangential_mass * slip;
  const double limit = contact.friction * row.normal, size = row.tangential.norm();
  if (size > limit) row.tangential *= limit / size;
  const Vec3 change = row.tangential - before;
  apply(contact, change, speeds);
  return change.norm() / row.tangential_mass;
}

// Returns the largest change of a relative speed (m/s).
double ImpulseSolver::sweep(std::span<const SphereContact> contacts, const Speeds& speeds) {
  ++sweeps_;
  double largest = 0;
  for (Row& row : rows_) {
    const SphereContact& contact = contacts[row.contact];
    largest = std::max(largest, solve_normal(contact, row, speeds));
    if (contact.friction > 0) largest = std::max(largest, solve_friction(contact, row, speeds));
  }
  return largest;
}

void ImpulseSolver::find_velocities(std::span<const SphereContact> contacts,
                                    const ImpulseStep& step, std::span<Vec3> velocity,
                                    std::span<Vec3> spin) {
  for (std::size_t i = 0; i < velocity.size(); ++i)
    velocity[i] = step.velocity[i] + step.length * step.acceleration[i];
  make_rows(contacts, step);
  take_kept(contacts, step.length);
  const Speeds speeds{velocity, spin};
  for (const Row& row : rows_) {
    if (row.normal == 0) continue;
    const SphereContact& contact = contacts[row.contact];
    apply(contact, row.normal * contact.normal + row.tangential, speeds);
  }
  for (int k = 0; k < most_sweeps; ++k) {
    if (sweep(contacts, speeds) <= small_change * step.resting_speed) break;
  }
  keep(contacts, step.length);
}

// A sphere whose impulses P act at the times t moves by v h + a h^2/2 + sum of P/m (h - t). The
// impulses of contacts that rest act evenly, at h/2 on average.
void ImpulseSolver::find_displacements(std::span<const SphereContact> contacts,
                                       const ImpulseStep& step, std::span<const Vec3> velocity,
                                       std::span<Vec3> mean) {
  for (std::size_t i = 0; i < mean.size(); ++i) mean[i] = 0.5 * (step.velocity[i] + velocity[i]);
  for (const Row& row : rows_) {
    if (!row.is_impact) continue;
    const SphereContact& contact = contacts[row.contact];
    const Vec3 impulse = row.normal * contact.normal + row.tangential;
    const double share = 0.5 - row.impact_time / step.length;
    mean[contact.sphere] += share * inverse_mass_[contact.sphere] * impulse;
    if (contact.other >= 0) mean[contact.other] -= share * inverse_mass_[contact.other] * impulse;
  }
  std::vector<SphereContact> closing;
  for (const SphereContact& contact : contacts) {
    const Vec3& other = contact.other < 0 ? contact.drive : mean[contact.other];
    const double gap = contact.gap + step.length * contact.normal.dot(mean[contact.sphere] - other);
    if (gap < clear_gap * least_gap(contact)) closing.push_back(contact);
  }
  correct_displacements(closing, step, {}, mean);
}

void ImpulseSolver::correct_displacements(std::span<const SphereContact> contacts,
                                          const ImpulseStep& step, std::span<const char> is_fixed,
                                          std::span<Vec3> mean) const {
  const auto mobility = [&](int sphere) {
    return is_fixed.empty() || is_fixed[sphere] == 0 ? inverse_mass_[sphere] : 0.0;
  };
  std::vector<double> multiplier(contacts.size(), 0.0);
  for (int k = 0; k < most_sweeps; ++k) {
    bool lacks = false;
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      const SphereContact& contact = contacts[c];
      const int a = contact.sphere, b = contact.other;
      const double rest = least_gap(contact);
      const double gap = contact.gap;
      const double target = gap < rest ? gap + restored_share * (rest - gap) : rest;
      const Vec3& other = b < 0 ? contact.drive : mean[b];
      const double lack = (target - gap) / step.length - contact.normal.dot(mean[a] - other);
      const double of_a = mobility(a), of_b = b < 0 ? 0.0 : mobility(b);
      if (of_a + of_b == 0) continue;
      const double before = multiplier[c];
      multiplier[c] = std::max(0.0, before + lack / (of_a + of_b));
      const double change = multiplier[c] - before;
      if (change == 0) continue;
      lacks |= lack * step.length > small_lack * rest;
      mean[a] += of_a * change * contact.normal;
      if (b >= 0) mean[b] -= of_b * change * contact.normal;
    }
    if (!lacks) return;
  }
}

void ImpulseSolver::transfer(StateArchive& archive) { archive(kept_, kept_length_, sweeps_); }

}  // namespace weft::sim
