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
  motion_.assign(spin.size() + 1, {Vec3::Zero(), 0, Vec3::Zero(), 0});
  for (std::size_t i = 0; i < spin.size(); ++i) {
    motion_[i] = {step.velocity[i] + step.length * step.acceleration[i], inverse_mass_[i],
                  radius_[i] * spin[i], radius_[i] * radius_[i] * inverse_inertia_[i]};
  }
  batches_.clear(static_cast<int>(spin.size()));
  lanes_.clear();
}

void ImpulseSolver::make_rows(std::span<const SphereContact> contacts, const ImpulseStep& step) {
  rows_.clear();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    Row row;
    if (!set_target(contacts[c], step, row)) continue;
    row.contact = static_cast<int>(c);
    add_row(contacts[c], row);
    rows_.push_back(row);
  }
}

void ImpulseSolver::add_row(const SphereContact& contact, Row& row) {
  const LaneVec3 zero = LaneVec3::Constant(0.0);
  row.place = batches_.add(contact.sphere, contact.other);
  lanes_.resize(static_cast<std::size_t>(batches_.count()) * registers_per_batch,
                {zero, 0.0, 0.0, 0.0, zero, 0.0, 0.0, zero});
  const Motion& a = motion_[contact.sphere];
  const Motion& b = contact.other < 0 ? motion_.back() : motion_[contact.other];
  const double normal = a.mass_share + b.mass_share;
  LaneRows& rows = lanes_of(row);
  const int lane = lane_of(row.place);
  set_lane(rows.normal, lane, contact.normal);
  set_lane(rows.drive, lane, contact.drive);
  rows.friction.values[lane] = contact.friction;
  rows.target.values[lane] = row.target;
  rows.normal_mass.values[lane] = 1 / normal;
  rows.tangential_mass.values[lane] = 1 / (normal + a.turning_share + b.turning_share);
}

// Gives rows of contacts that rest the impulses of the last step.
void ImpulseSolver::take_kept(std::span<const SphereContact> contacts, double length) {
  const double scale = length / kept_length_;
  const auto key_of = [&](std::size_t row) { return contacts[rows_[row].contact].key(); };
  match_kept(kept_, rows_.size(), key_of, [&](std::size_t index, const KeptImpulse& kept) {
    const Row& row = rows_[index];
    if (row.is_impact) return;
    const Vec3& normal = contacts[row.contact].normal;
    const Vec3 tangential(kept.tangential.data());
    lanes_of(row).impulse.values[lane_of(row.place)] = scale * kept.normal;
    set_lane(lanes_of(row).tangential, lane_of(row.place),
             scale * (tangential - tangential.dot(normal) * normal));
  });
}

void ImpulseSolver::keep(std::span<const SphereContact> contacts, double length) {
  kept_.clear();
  kept_length_ = length;
  for (const Row& row : rows_) {
    const double impulse = lanes_of(row).impulse.values[lane_of(row.place)];
    if (row.is_impact || impulse == 0) continue;
    const Vec3 tangential = get_lane(lanes_of(row).tangential, lane_of(row.place));
    kept_.push_back(
        {contacts[row.contact].key(), impulse, {tangential[0], tangential[1], tangential[2]}});
  }
}

[[gnu::always_inline]] inline ImpulseSolver::Sides ImpulseSolver::load(int index) const {
  const int* const first = batches_.spheres(first_place(index));
  const int* const second = batches_.others(first_place(index));
  return {load_records([&](int lane) -> const Vec3& { return motion_[first[lane]].velocity; }),
          load_records([&](int lane) -> const Vec3& { return motion_[first[lane]].turning; }),
          load_records([&](int lane) -> const Vec3& { return motion_[second[lane]].velocity; }),
          load_records([&](int lane) -> const Vec3& { return motion_[second[lane]].turning; })};
}

// Applies impulses to both sides and stores their motions. The normal parts do not turn spheres.
[[gnu::always_inline]] inline void ImpulseSolver::apply(Sides& sides, int index,
                                                        const Lanes& along_normal,
                                                        const LaneVec3& tangential) {
  const LaneVec3& normal = lanes_[index].normal;
  const LaneVec3 impulse = along_normal * normal + tangential;
  const LaneVec3 turn = normal.cross(tangential);
  sides.velocity.vector += sides.velocity.number * impulse;
  sides.turning.vector -= sides.turning.number * turn;
  sides.other_velocity.vector -= sides.other_velocity.number * impulse;
  sides.other_turning.vector -= sides.other_turning.number * turn;
  const int* const first = batches_.spheres(first_place(index));
  const int* const second = batches_.others(first_place(index));
  store_records(sides.velocity, [&](int lane) -> Vec3& { return motion_[first[lane]].velocity; });
  store_records(sides.turning, [&](int lane) -> Vec3& { return motion_[first[lane]].turning; });
  store_records(sides.other_velocity,
                [&](int lane) -> Vec3& { return motion_[second[lane]].velocity; });
  store_records(sides.other_turning,
                [&](int lane) -> Vec3& { return motion_[second[lane]].turning; });
}

// Solves for the normal impulses, then for friction. A normal impulse does not change the slip, so
// one relative velocity serves both. Returns the lanes whose changes matter.
unsigned ImpulseSolver::solve(int index, double small_change) {
  LaneRows& rows = lanes_[index];
  Sides sides = load(index);
  const LaneVec3 turning = sides.turning.vector + sides.other_turning.vector;
  const LaneVec3 velocity =
      sides.velocity.vector - sides.other_velocity.vector - rows.drive - turning.cross(rows.normal);
  const Lanes speed = velocity.dot(rows.normal);
  const Lanes before = rows.impulse;
  rows.impulse = larger(0.0, before + rows.normal_mass * (rows.target - speed));
  const Lanes change = rows.impulse - before;
  const LaneVec3 old = rows.tangential;
  rows.tangential -= rows.tangential_mass * (velocity - speed * rows.normal);
  const Lanes limit = rows.friction * rows.impulse, squared = rows.tangential.squaredNorm();
  rows.tangential *= choose(limit * limit < squared, limit / square_root(squared), 1.0);
  const LaneVec3 slide = rows.tangential - old;
  apply(sides, index, change, slide);
  const Lanes least = small_change * rows.normal_mass, slip = small_change * rows.tangential_mass;
  return bits_of((least < magnitude(change)) | (slip * slip < slide.squaredNorm()));
}

void ImpulseSolver::find_velocities(std::span<const SphereContact> contacts,
                                    const ImpulseStep& step, std::span<Vec3> velocity,
                                    std::span<Vec3> spin) {
  start(step, spin);
  make_rows(contacts, step);
  take_kept(contacts, step.length);
  for (int i = 0; i < static_cast<int>(lanes_.size()); ++i) {
    Sides sides = load(i);
    apply(sides, i, lanes_[i].impulse, lanes_[i].tangential);
  }
  const double small_change = small_change_share * step.resting_speed;
  const auto solve_rows = [&](int batch) {
    return solve_batch(batch, [&](int index) { return solve(index, small_change); });
  };
  for (int k = 0; k < most_velocity_sweeps && batches_.sweep(solve_rows); ++k) ++sweeps_;
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
    const LaneRows& rows = lanes_of(row);
    const int lane = lane_of(row.place), sphere = *batches_.spheres(row.place),
              other = *batches_.others(row.place);
    const Vec3 impulse =
        rows.impulse.values[lane] * get_lane(rows.normal, lane) + get_lane(rows.tangential, lane);
    const double share = 0.5 - row.impact_time / step.length;
    mean[sphere] += share * inverse_mass_[sphere] * impulse;
    if (other != batches_.nobody()) mean[other] -= share * inverse_mass_[other] * impulse;
  }
}

void ImpulseSolver::transfer(StateArchive& archive) { archive(kept_, kept_length_, sweeps_); }

}  // namespace weft::sim
