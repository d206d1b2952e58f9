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
// The first sweep solves each row exactly, which is all that a lone contact needs, and so do the
// last sweeps. Those in between multiply corrections of normal impulses by `velocity_relaxation`:
// the load of a heap then reaches its floor in fewer sweeps (docs/decisions/0087).
constexpr int last_exact_sweeps = 2;
constexpr float velocity_relaxation = 1.8F;
constexpr double small_change_share = 0.1;
// Impulses of contacts that rest grow with the length of the step, by no more than this factor from
// one step to the next: in a very short step they also stop what has nothing to do with weights.
constexpr double most_growth = 2;
// Sweeps that take the restitution from spheres whose impulses do work end once the impulses do
// none and no relative speed changes by more than a share of the largest rebound. After every
// `usual_settling_sweeps` it is enough that the impulses do no work, and after
// `most_settling_sweeps` the sweeps end in any case.
constexpr int usual_settling_sweeps = 25, most_settling_sweeps = 400;
constexpr double settled_share = 1e-3;
// Steps that a bounce on spheres at rest must last. Lower ones are stopped: impulses of the
// contacts below answer an impact in the middle of the step, and the error of that keeps heaps
// moving.
constexpr double least_bounce = 10;
// Work of impulses that add up to nothing in exact numbers, as a fraction of the sizes of its
// terms.
constexpr double rounding_share = 1e-12;

// Returns the first time (s) in [0, length] at which sides that approach each other touch, with the
// gap `gap` + speed t + acceleration t^2 / 2, or a negative number if there is none. Sides that
// touch already do so at 0, unless they part.
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

// Returns the largest share s in [0, 1] at which constant + linear s + square s^2 is not positive.
// If there is none, returns that of the least value. Preconditions: square >= 0, and the value at 1
// is positive.
double largest_share(double constant, double linear, double square) {
  const double discriminant = linear * linear - 4 * square * constant;
  // This form of the larger root does not cancel where the constant is negative.
  if (constant < 0) return -2 * constant / (linear + std::sqrt(discriminant));
  if (!(square > 0)) return linear < 0 ? 1 : 0;
  const double least = std::clamp(-0.5 * linear / square, 0.0, 1.0);
  return discriminant > 0 && linear < 0 && least < 1
             ? std::min(1.0, least + 0.5 * std::sqrt(discriminant) / square)
             : least;
}

}  // namespace

ImpulseSolver::ImpulseSolver(const Scene& scene) : radius_(sphere_radii(scene)), unit_mass_(0) {
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const SceneBody& body = scene.bodies[b];
    for (int i = 0; i < body.particle_count(); ++i) {
      const double mass = scene.mass[body.first_particle + i], radius = body.spheres->radius;
      const double inertia = 0.4 * mass * radius * radius;
      inverse_mass_.push_back(1 / mass);
      inertia_.push_back(body.spheres->spin ? inertia : 0);
      turning_share_.push_back(body.spheres->spin ? radius * radius / inertia : 0);
      rest_gap_.push_back(rest_gap_share * radius);
    }
  }
  support_.assign(radius_.size(), 0);
  support_by_spheres_.assign(radius_.size(), 0);
  impulse_count_.assign(radius_.size(), 0);
  unit_mass_ = 1 / *std::ranges::max_element(inverse_mass_);
}

double ImpulseSolver::least_gap(const SphereContact& contact) const {
  return contact.other < 0 ? rest_gap_[contact.sphere]
                           : std::min(rest_gap_[contact.sphere], rest_gap_[contact.other]);
}

// Returns the acceleration (m/s^2) at which the sides would part along the normal without this
// contact. Spheres that rest on others are held by them; obstacles are where they are.
double ImpulseSolver::parting_acceleration(const SphereContact& contact,
                                           const ImpulseStep& step) const {
  const int a = contact.sphere, b = contact.other;
  if (b < 0) return contact.normal.dot(step.acceleration[a]);
  return contact.normal.dot((1 - support_[a]) * step.acceleration[a] -
                            (1 - support_[b]) * step.acceleration[b]);
}

// Returns the speed (m/s) above which the sides part after an impact. Bounces must last several
// steps where the weight brings a sphere that falls back to one that rests, and in a heap, whose
// spheres rest on each other. Balls that roll on an obstacle part from each other at any speed.
double ImpulseSolver::least_rebound(const SphereContact& contact, const ImpulseStep& step) const {
  double support = 0, load_in_heap = 0;
  for (const int sphere : {contact.sphere, contact.other}) {
    if (sphere < 0) continue;
    const double weight = std::abs(contact.normal.dot(step.acceleration[sphere]));
    support = std::max(support, support_[sphere]);
    load_in_heap = std::max(load_in_heap, support_by_spheres_[sphere] * weight);
  }
  const double load = std::max(load_in_heap, -support * parting_acceleration(contact, step));
  return std::max(step.resting_speed, 0.5 * least_bounce * step.length * load);
}

// Sets the least normal velocity at the end of the step, and the time at which the impulse acts.
// Returns false if the contact neither touches nor closes in free motion.
bool ImpulseSolver::set_target(const SphereContact& contact, const ImpulseStep& step,
                               Row& row) const {
  if (contact.is_borne) return false;
  const double length = step.length, rest = least_gap(contact), gap = contact.gap - rest;
  const Vec3& other = contact.other < 0 ? contact.drive : step.velocity[contact.other];
  const double speed = contact.normal.dot(step.velocity[contact.sphere] - other);
  const double free_acceleration = parting_acceleration(contact, step);
  // The surface rises by rise * length during the step.
  const double acceleration = free_acceleration - 2 * contact.rise / length;
  const double time = closing_time(gap, speed, acceleration, length);
  row.time = 0.5 * length;
  row.target = contact.rise;
  // A sphere that parts from a curved surface by itself takes up no energy where it is kept on it.
  if (contact.rise > 0) row.target -= std::max(0.0, speed);
  if (time < 0) {
    if (gap > 0) row.target -= gap / length;
    // Sides that stay apart by themselves are not slowed down: they may come back in the next step.
    if (gap + length * (speed + 0.5 * length * acceleration) >= 0) {
      const double change = contact.normal.dot(contact.drive - contact.end_drive);
      row.target = std::min(row.target, speed + change + length * acceleration);
    }
    return gap <= touching_share * rest;
  }
  const double left = length - time, impact_speed = -(speed + acceleration * time);
  row.is_impact = impact_speed > step.resting_speed;
  if (!row.is_impact) return true;
  const double rebound = contact.restitution * impact_speed;
  row.time = time;
  row.parts = rebound > least_rebound(contact, step);
  if (row.parts) {
    row.target = rebound + free_acceleration * left;
  } else {
    // The part of the impulse that bears the weight after the impact acts evenly.
    const double load = std::max(0.0, -acceleration * left);
    row.time += 0.5 * left * load / (impact_speed + load);
  }
  return true;
}

void ImpulseSolver::start(const ImpulseStep& step, std::span<const Vec3> spin) {
  const std::size_t count = spin.size();
  velocity_.resize(count);
  turning_.resize(count);
  change_.assign(count + 1, {});
  for (std::size_t i = 0; i < count; ++i) {
    velocity_[i] = step.velocity[i] + step.length * step.acceleration[i];
    turning_[i] = radius_[i] * spin[i];
    change_[i].mass_share = static_cast<float>(unit_mass_ * inverse_mass_[i]);
    change_[i].turning_share = static_cast<float>(unit_mass_ * turning_share_[i]);
  }
  batches_.clear(static_cast<int>(count));
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

// Returns the velocity of the first side of a contact relative to the second one.
Vec3 ImpulseSolver::velocity_at(const SphereContact& contact, const Row& row) const {
  Vec3 velocity = velocity_[contact.sphere] - row.drive_of(contact),
       turning = turning_[contact.sphere];
  if (contact.other >= 0) {
    velocity -= velocity_[contact.other];
    turning += turning_[contact.other];
  }
  return velocity - turning.cross(row.normal_of(contact));
}

void ImpulseSolver::add_row(const SphereContact& contact, Row& row) {
  const int a = contact.sphere, b = contact.other;
  row.place = batches_.add(a, b);
  if (batches_.count() > static_cast<int>(lanes_.size())) {
    const FloatLaneVec3 zero = FloatLaneVec3::Constant(0.0F);
    lanes_.push_back({zero, 0.0F, 0.0F, 0.0F, zero, 0.0F, 0.0F, zero});
  }
  const double normal = inverse_mass_[a] + (b < 0 ? 0 : inverse_mass_[b]),
               turning = turning_share_[a] + (b < 0 ? 0 : turning_share_[b]);
  row.normal_mass = 1 / normal;
  row.tangential_mass = 1 / (normal + turning);
  LaneRows& rows = lanes_of(row);
  const int lane = lane_of(row.place);
  set_lane(rows.normal, lane, row.normal_of(contact));
  set_lane(rows.approach, lane, velocity_at(contact, row));
  rows.friction.values[lane] = static_cast<float>(contact.friction);
  rows.target.values[lane] = static_cast<float>(row.target);
  rows.normal_mass.values[lane] = static_cast<float>(row.normal_mass / unit_mass_);
  rows.tangential_mass.values[lane] = static_cast<float>(row.tangential_mass / unit_mass_);
}

// Gives rows of contacts that rest the impulses of the last step.
void ImpulseSolver::take_kept(std::span<const SphereContact> contacts, double length) {
  const double scale = std::min(length / kept_length_, most_growth) / unit_mass_;
  const auto key_of = [&](std::size_t row) { return contacts[rows_[row].contact].key(); };
  match_kept(kept_, rows_.size(), key_of, [&](std::size_t index, const KeptImpulse& kept) {
    const Row& row = rows_[index];
    if (row.is_impact) return;
    const Vec3 normal = row.normal_of(contacts[row.contact]);
    const Vec3 tangential(kept.tangential.data());
    lanes_of(row).impulse.values[lane_of(row.place)] = static_cast<float>(scale * kept.normal);
    set_lane(lanes_of(row).tangential, lane_of(row.place),
             scale * (tangential - tangential.dot(normal) * normal));
  });
}

// Keeps the impulses of contacts that rest for the next step, and finds how much of the
// acceleration of free spheres they take up.
void ImpulseSolver::keep(std::span<const SphereContact> contacts, const ImpulseStep& step) {
  kept_.clear();
  kept_length_ = step.length;
  std::ranges::fill(support_, 0.0);
  std::ranges::fill(support_by_spheres_, 0.0);
  std::ranges::fill(impulse_count_, 0);
  for (const Row& row : rows_) {
    if (row.impulse == 0) continue;
    const SphereContact& contact = contacts[row.contact];
    const int a = contact.sphere, b = contact.other;
    ++impulse_count_[a];
    if (b >= 0) ++impulse_count_[b];
    if (row.is_impact) continue;
    const Vec3& tangential = row.tangential;
    kept_.push_back({contact.key(), row.impulse, {tangential[0], tangential[1], tangential[2]}});
    const Vec3 impulse = row.impulse * row.normal_of(contact) + tangential;
    // Until the end of this loop, support_ has that by obstacles alone.
    (b < 0 ? support_ : support_by_spheres_)[a] -= impulse.dot(step.acceleration[a]);
    if (b >= 0) support_by_spheres_[b] += impulse.dot(step.acceleration[b]);
  }
  for (std::size_t i = 0; i < support_.size(); ++i) {
    const double whole = step.length * step.acceleration[i].squaredNorm() / inverse_mass_[i];
    const auto share = [&](double taken) { return taken > 0 ? std::min(taken / whole, 1.0) : 0.0; };
    support_[i] = share(support_[i] + support_by_spheres_[i]);
    support_by_spheres_[i] = share(support_by_spheres_[i]);
  }
}

[[gnu::always_inline]] inline ImpulseSolver::Sides ImpulseSolver::load(int batch) const {
  const auto &first = batches_.spheres_of(batch), &second = batches_.others_of(batch);
  return {load_fours([&](int lane) { return change_[first[lane]].velocity.data(); }),
          load_fours([&](int lane) { return change_[first[lane]].turning.data(); }),
          load_fours([&](int lane) { return change_[second[lane]].velocity.data(); }),
          load_fours([&](int lane) { return change_[second[lane]].turning.data(); })};
}

// Applies impulses to both sides and stores their motions. The normal parts do not turn spheres.
[[gnu::always_inline]] inline void ImpulseSolver::apply(Sides& sides, int batch,
                                                        const FloatLanes& along_normal,
                                                        const FloatLaneVec3& tangential) {
  const FloatLaneVec3& normal = lanes_[batch].normal;
  const FloatLaneVec3 impulse = along_normal * normal + tangential;
  const FloatLaneVec3 turn = normal.cross(tangential);
  for (int k = 0; k < 3; ++k) {
    sides.velocity[k] += sides.velocity[3] * impulse[k];
    sides.turning[k] -= sides.turning[3] * turn[k];
    sides.other_velocity[k] -= sides.other_velocity[3] * impulse[k];
    sides.other_turning[k] -= sides.other_turning[3] * turn[k];
  }
  const auto &first = batches_.spheres_of(batch), &second = batches_.others_of(batch);
  store_fours(sides.velocity, [&](int lane) { return change_[first[lane]].velocity.data(); });
  store_fours(sides.turning, [&](int lane) { return change_[first[lane]].turning.data(); });
  store_fours(sides.other_velocity,
              [&](int lane) { return change_[second[lane]].velocity.data(); });
  store_fours(sides.other_turning, [&](int lane) { return change_[second[lane]].turning.data(); });
}

// Corrects the normal impulses by `factor` times what would reach their targets, then solves for
// friction. A normal impulse does not change the slip, so one relative velocity serves both.
// Returns the lanes whose changes matter.
unsigned ImpulseSolver::solve(int batch, float factor, float small_change) {
  LaneRows& rows = lanes_[batch];
  Sides sides = load(batch);
  const auto vector = [](const std::array<FloatLanes, 4>& fours) {
    return FloatLaneVec3(fours[0], fours[1], fours[2]);
  };
  const FloatLaneVec3 turning = vector(sides.turning) + vector(sides.other_turning);
  const FloatLaneVec3 velocity = rows.approach +
                                 (vector(sides.velocity) - vector(sides.other_velocity)) -
                                 turning.cross(rows.normal);
  const FloatLanes speed = velocity.dot(rows.normal);
  const FloatLanes before = rows.impulse;
  rows.impulse = larger(0.0F, before + factor * rows.normal_mass * (rows.target - speed));
  const FloatLanes change = rows.impulse - before;
  const FloatLaneVec3 old = rows.tangential;
  rows.tangential -= rows.tangential_mass * (velocity - speed * rows.normal);
  const FloatLanes limit = rows.friction * rows.impulse, squared = rows.tangential.squaredNorm();
  rows.tangential *= choose(limit * limit < squared, limit / square_root(squared), 1.0F);
  const FloatLaneVec3 slide = rows.tangential - old;
  apply(sides, batch, change, slide);
  const FloatLanes least = small_change * rows.normal_mass,
                   slip = small_change * rows.tangential_mass;
  return bits_of((least < magnitude(change)) | (slip * slip < slide.squaredNorm()));
}

// Adds impulses to the motions of the sides of a contact. What one side gains, the other one loses.
void ImpulseSolver::push(const SphereContact& contact, const Vec3& normal, double along_normal,
                         const Vec3& tangential) {
  const int a = contact.sphere, b = contact.other;
  const Vec3 impulse = along_normal * normal + tangential;
  const Vec3 turn = normal.cross(tangential);
  velocity_[a] += inverse_mass_[a] * impulse;
  turning_[a] -= turning_share_[a] * turn;
  if (b < 0) return;
  velocity_[b] -= inverse_mass_[b] * impulse;
  turning_[b] -= turning_share_[b] * turn;
}

// Applies the impulses of the sweeps in double precision. Impulses of friction lose what rounding
// has added to them along the normal.
void ImpulseSolver::take_impulses(std::span<const SphereContact> contacts) {
  for (Row& row : rows_) {
    const SphereContact& contact = contacts[row.contact];
    const LaneRows& rows = lanes_of(row);
    const int lane = lane_of(row.place);
    row.impulse = unit_mass_ * rows.impulse.values[lane];
    row.tangential = unit_mass_ * get_lane(rows.tangential, lane);
    const Vec3 normal = row.normal_of(contact);
    row.tangential -= row.tangential.dot(normal) * normal;
    push(contact, normal, row.impulse, row.tangential);
  }
}

// Solves a row in double precision. Returns the change of the relative velocity (m/s) that its
// impulse makes.
double ImpulseSolver::solve_exactly(const SphereContact& contact, double target, Row& row) {
  const Vec3 velocity = velocity_at(contact, row), normal = row.normal_of(contact);
  const double speed = velocity.dot(normal), before = row.impulse;
  row.impulse = std::max(0.0, before + row.normal_mass * (target - speed));
  const Vec3 old = row.tangential;
  row.tangential -= row.tangential_mass * (velocity - speed * normal);
  const double limit = contact.friction * row.impulse, size = row.tangential.norm();
  if (size > limit) row.tangential *= limit / size;
  push(contact, normal, row.impulse - before, row.tangential - old);
  return std::max(std::abs(row.impulse - before) / row.normal_mass,
                  (row.tangential - old).norm() / row.tangential_mass);
}

// Notes how contacts move without impulses, if the energy of any may grow. Impulses that do not
// belong to an impact act evenly over the step, at its middle on average.
void ImpulseSolver::find_free_motions(std::span<const SphereContact> contacts,
                                      const ImpulseStep& step) {
  free_motions_.clear();
  if (std::ranges::none_of(rows_, &Row::parts)) return;
  for (const Row& row : rows_) {
    const SphereContact& contact = contacts[row.contact];
    Vec3 acceleration = step.acceleration[contact.sphere];
    if (contact.other >= 0) acceleration -= step.acceleration[contact.other];
    const Vec3 at_end = velocity_at(contact, row);
    free_motions_.push_back({at_end, at_end - (step.length - row.time) * acceleration});
  }
}

// Returns the work (J) of the impulse of a row, relative to obstacles. The sum over all rows is
// what impulses add to the energy of the spheres, that of their weight included: an impulse P at
// the time t of a step of length h adds P . (v + V) / 2 to the kinetic energy, with the velocities
// v without and V with all impulses at the end, and moves the sphere by P (h - t) / m.
ImpulseSolver::Work ImpulseSolver::work_of(std::span<const SphereContact> contacts, int row) const {
  const SphereContact& contact = contacts[rows_[row].contact];
  const Vec3 impulse = rows_[row].impulse * rows_[row].normal_of(contact) + rows_[row].tangential;
  const FreeMotion& free = free_motions_[row];
  const double before = impulse.dot(free.at_impulse),
               change = 0.5 * impulse.dot(velocity_at(contact, rows_[row]) - free.at_end);
  return {before + change, std::abs(before) + std::abs(change)};
}

// Returns the rows of the islands of spheres whose impulses do work, island by island. Spheres of
// an island are connected by rows, whether these have an impulse or not.
std::vector<int> ImpulseSolver::rows_with_gains(std::span<const SphereContact> contacts) {
  islands_.clear(static_cast<int>(velocity_.size()));
  for (const Row& row : rows_) {
    const SphereContact& contact = contacts[row.contact];
    if (contact.other >= 0) islands_.connect(contact.sphere, contact.other);
  }
  struct Island {
    Work work;
    bool parts = false;
  };
  std::vector<Island> islands(velocity_.size());
  const auto island_of = [&](int row) {
    return islands_.island_of(contacts[rows_[row].contact].sphere);
  };
  const auto row_count = static_cast<int>(rows_.size());
  for (int r = 0; r < row_count; ++r) {
    Island& island = islands[island_of(r)];
    const Work work = work_of(contacts, r);
    island.work.sum += work.sum;
    island.work.size += work.size;
    island.parts = island.parts || rows_[r].parts;
  }
  std::vector<int> rows;
  for (int r = 0; r < row_count; ++r) {
    const Island& island = islands[island_of(r)];
    if (island.parts && island.work.sum > rounding_share * island.work.size) rows.push_back(r);
  }
  std::ranges::stable_sort(rows, {}, island_of);
  return rows;
}

double ImpulseSolver::work_of(std::span<const SphereContact> contacts,
                              std::span<const int> rows) const {
  double sum = 0;
  for (const int r : rows) sum += work_of(contacts, r).sum;
  return sum;
}

// Solves for the impulses without restitution. Returns their work (J).
double ImpulseSolver::settle(std::span<const SphereContact> contacts, std::span<const int> rows) {
  double largest = 0;
  for (const int r : rows) largest = std::max(largest, std::abs(rows_[r].target));
  for (int sweep = 1;; ++sweep) {
    double change = 0;
    for (const int r : rows) {
      const double target = rows_[r].parts ? 0 : rows_[r].target;
      change = std::max(change, solve_exactly(contacts[rows_[r].contact], target, rows_[r]));
    }
    if (change > settled_share * largest && sweep % usual_settling_sweeps != 0) continue;
    const double work = work_of(contacts, rows);
    if (work < 0 || sweep >= most_settling_sweeps) return work;
  }
}

// Limits the energy of an island, whose impulses do work. Without restitution they usually do none.
// The work of impulses in between is a quadratic function of the share of restitution, and the
// share is the largest one for which the work is not positive. Where there is none, as little is
// gained as possible.
void ImpulseSolver::limit_energy(std::span<const SphereContact> contacts,
                                 std::span<const int> rows) {
  struct Before {
    double impulse;
    Vec3 tangential, velocity;
  };
  std::vector<Before> before;
  for (const int r : rows) {
    const Row& row = rows_[r];
    before.push_back({row.impulse, row.tangential, velocity_at(contacts[row.contact], row)});
  }
  const double with = work_of(contacts, rows), without = settle(contacts, rows);
  double square = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& row = rows_[rows[i]];
    const SphereContact& contact = contacts[row.contact];
    const Vec3 impulse = (before[i].impulse - row.impulse) * row.normal_of(contact) +
                         (before[i].tangential - row.tangential);
    square += 0.5 * impulse.dot(before[i].velocity - velocity_at(contact, row));
  }
  const double share = largest_share(without, with - without - square, square);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Row& row = rows_[rows[i]];
    const double along_normal = share * (before[i].impulse - row.impulse);
    const Vec3 tangential = share * (before[i].tangential - row.tangential);
    row.impulse += along_normal;
    row.tangential += tangential;
    push(contacts[row.contact], row.normal_of(contacts[row.contact]), along_normal, tangential);
  }
}

void ImpulseSolver::limit_energy(std::span<const SphereContact> contacts) {
  if (free_motions_.empty()) return;
  const std::vector<int> rows = rows_with_gains(contacts);
  const auto island_of = [&](int row) {
    return islands_.island_of(contacts[rows_[row].contact].sphere);
  };
  for (auto first = rows.begin(); first != rows.end();) {
    const auto last = std::find_if(first, rows.end(),
                                   [&](int row) { return island_of(row) != island_of(*first); });
    limit_energy(contacts, std::span(first, last));
    first = last;
  }
}

void ImpulseSolver::find_velocities(std::span<const SphereContact> contacts,
                                    const ImpulseStep& step, std::span<Vec3> velocity,
                                    std::span<Vec3> spin) {
  start(step, spin);
  make_rows(contacts, step);
  take_kept(contacts, step.length);
  for (int b = 0; b < batches_.count(); ++b) {
    Sides sides = load(b);
    apply(sides, b, lanes_[b].impulse, lanes_[b].tangential);
  }
  const auto small_change = static_cast<float>(small_change_share * step.resting_speed);
  for (int k = 0; k < most_velocity_sweeps; ++k) {
    const bool is_exact = k == 0 || k >= most_velocity_sweeps - last_exact_sweeps;
    const auto solve_batch = [&](int batch) {
      return solve(batch, is_exact ? 1 : velocity_relaxation, small_change);
    };
    if (!batches_.sweep(solve_batch, is_exact)) break;
    ++sweeps_;
  }
  find_free_motions(contacts, step);
  take_impulses(contacts);
  // A contact that meets no other one then has the impulse of Newton's law to its last digits.
  for (Row& row : rows_) solve_exactly(contacts[row.contact], row.target, row);
  limit_energy(contacts);
  keep(contacts, step);
  for (std::size_t i = 0; i < velocity.size(); ++i) {
    velocity[i] = velocity_[i];
    spin[i] = turning_[i] / radius_[i];
  }
}

// A sphere whose impulses P act at the times t moves by v h + a h^2/2 + sum of P/m (h - t). The
// impulses of contacts that rest act evenly, at h/2 on average.
void ImpulseSolver::find_displacements(const ImpulseStep& step, std::span<const Vec3> velocity,
                                       std::span<Vec3> mean) const {
  for (std::size_t i = 0; i < mean.size(); ++i) mean[i] = 0.5 * (step.velocity[i] + velocity[i]);
  for (const Row& row : rows_) {
    if (!row.is_impact) continue;
    const int sphere = batches_.spheres_of(batch_of(row.place))[lane_of(row.place)],
              other = batches_.others_of(batch_of(row.place))[lane_of(row.place)];
    const LaneRows& rows = lanes_of(row);
    const Vec3 impulse = row.impulse * get_lane(rows.normal, lane_of(row.place)) + row.tangential;
    const double share = 0.5 - row.time / step.length;
    mean[sphere] += share * inverse_mass_[sphere] * impulse;
    if (other != batches_.nobody()) mean[other] -= share * inverse_mass_[other] * impulse;
  }
}

void ImpulseSolver::find_kicks(std::span<const SphereContact> contacts,
                               std::vector<Kick>& kicks) const {
  kicks.clear();
  const auto add = [&](const Row& row, int sphere, const Vec3& impulse, const Vec3& turn) {
    const Vec3 velocity = inverse_mass_[sphere] * impulse,
               spin = turning_share_[sphere] / radius_[sphere] * turn;
    kicks.push_back(
        {sphere, row.time, {velocity[0], velocity[1], velocity[2]}, {spin[0], spin[1], spin[2]}});
  };
  for (const Row& row : rows_) {
    if (!row.is_impact || row.impulse == 0) continue;
    const SphereContact& contact = contacts[row.contact];
    const bool is_lone = impulse_count_[contact.sphere] == 1 &&
                         (contact.other < 0 || impulse_count_[contact.other] == 1);
    if (!is_lone) continue;
    const Vec3 impulse = row.impulse * row.normal_of(contact) + row.tangential;
    const Vec3 turn = -row.normal_of(contact).cross(row.tangential);
    add(row, contact.sphere, impulse, turn);
    if (contact.other >= 0) add(row, contact.other, -impulse, turn);
  }
}

void ImpulseSolver::forget() {
  kept_.clear();
  std::ranges::fill(support_, 0.0);
  std::ranges::fill(support_by_spheres_, 0.0);
}

void ImpulseSolver::transfer(StateArchive& archive) {
  archive(kept_, kept_length_, support_, support_by_spheres_, sweeps_);
}

}  // namespace weft::sim
