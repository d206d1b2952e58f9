#include "sim/particles/displacement_solver.h"

#include <algorithm>
#include <cmath>

namespace weft::sim {

namespace {

// Fraction of a lacking gap that one step restores. Faster restoring would add energy.
constexpr double restored_share = 0.2;
// Most sweeps of one solution.
constexpr int most_displacement_sweeps = 120;
// A contact that lacks more than this fraction of its rest gap is corrected, and so are its
// neighbours.
constexpr double small_lack = 0.2;
// Factor of corrections. Above 1 they reach farther in a sweep.
constexpr double relaxation = 1.5;
// Fraction of the last step's corrections that a step begins with.
constexpr double kept_share = 0.8;

}  // namespace

double DisplacementSolver::rest_gap_of(const SphereContact& contact) const {
  return contact.other < 0 ? rest_gap_[contact.sphere]
                           : std::min(rest_gap_[contact.sphere], rest_gap_[contact.other]);
}

void DisplacementSolver::start(std::span<const SphereContact> contacts, double length,
                               std::span<const Vec3> mean) {
  length_ = length;
  batches_.clear(static_cast<int>(mean.size()));
  lanes_.clear();
  spheres_.resize(mean.size() + 1);
  for (std::size_t i = 0; i < mean.size(); ++i) spheres_[i] = {mean[i], inverse_mass_[i]};
  rows_.clear();
  for (const SphereContact& contact : contacts) rows_.push_back({contact.key(), add_row(contact)});
  take_kept();
}

void DisplacementSolver::add(std::span<const SphereContact> contacts) {
  for (const SphereContact& contact : contacts) add_row(contact);
}

// Returns the place of the contact in the batches.
int DisplacementSolver::add_row(const SphereContact& contact) {
  const double rest = rest_gap_of(contact), gap = contact.gap;
  const double target = gap < rest ? gap + restored_share * (rest - gap) : rest;
  double least = (target - gap) / length_;
  if (contact.other < 0) least += contact.normal.dot(contact.drive);
  const int place = batches_.add(contact.sphere, contact.other);
  lanes_.resize(static_cast<std::size_t>(batches_.count()) * registers_per_batch,
                {LaneVec3::Constant(0.0), 0.0, 0.0, 0.0});
  LaneRows& rows = lanes_[register_of(place)];
  const int lane = lane_of(place);
  set_lane(rows.normal, lane, contact.normal);
  rows.least.values[lane] = least;
  rows.rest.values[lane] = rest;
  return place;
}

// Begins with most of the last step's corrections: where velocities have not converged, contacts
// lack as much again. The sweeps take back what is too much.
void DisplacementSolver::take_kept() {
  const double scale = kept_share * length_ / kept_length_;
  const auto key_of = [&](std::size_t row) { return rows_[row].key; };
  match_kept(kept_, rows_.size(), key_of, [&](std::size_t row, const KeptMultiplier& kept) {
    const int place = rows_[row].place, lane = lane_of(place);
    LaneRows& rows = lanes_[register_of(place)];
    rows.multiplier.values[lane] = scale * kept.multiplier;
    const Vec3 change = scale * kept.multiplier * get_lane(rows.normal, lane);
    Sphere &a = spheres_[*batches_.spheres(place)], &b = spheres_[*batches_.others(place)];
    a.mean += a.mobility * change;
    b.mean -= b.mobility * change;
  });
}

void DisplacementSolver::keep() {
  kept_.clear();
  kept_length_ = length_;
  for (const Row& row : rows_) {
    const double multiplier = lanes_[register_of(row.place)].multiplier.values[lane_of(row.place)];
    if (multiplier > 0) kept_.push_back({row.key, multiplier});
  }
}

void DisplacementSolver::transfer(StateArchive& archive) { archive(kept_, kept_length_); }

bool DisplacementSolver::fix(int sphere) {
  Sphere& fixed = spheres_[sphere];
  if (fixed.mobility == 0) return false;
  fixed = {Vec3::Zero(), 0};
  batches_.touch(sphere);
  return true;
}

// Returns the lanes in which the displacements have changed by an amount that matters.
unsigned DisplacementSolver::solve(int index) {
  const auto side = [&](const int* spheres) {
    return [this, spheres](int lane) -> Vec3& { return spheres_[spheres[lane]].mean; };
  };
  const auto first = side(batches_.spheres(first_place(index)));
  const auto second = side(batches_.others(first_place(index)));
  LaneRows& rows = lanes_[index];
  LaneRecords a = load_records(first), b = load_records(second);
  const Lanes mobility = a.number + b.number;
  const Lanes lack = rows.least - rows.normal.dot(a.vector - b.vector);
  const Lanes before = rows.multiplier;
  rows.multiplier =
      choose(0.0 < mobility, larger(0.0, before + relaxation * lack / mobility), before);
  const Lanes change = rows.multiplier - before;
  a.vector += a.number * change * rows.normal;
  b.vector -= b.number * change * rows.normal;
  store_records(a, first);
  store_records(b, second);
  return bits_of(small_lack * rows.rest < magnitude(change) * mobility * length_);
}

void DisplacementSolver::correct() {
  const auto solve_rows = [&](int batch) {
    return solve_batch(batch, [&](int index) { return solve(index); });
  };
  int sweeps = 0;
  while (sweeps < most_displacement_sweeps && batches_.sweep(solve_rows)) ++sweeps;
}

}  // namespace weft::sim
