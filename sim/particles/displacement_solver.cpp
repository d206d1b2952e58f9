#include "sim/particles/displacement_solver.h"

#include <algorithm>
#include <cmath>

namespace weft::sim {

namespace {

// Fraction of a lacking gap that one step restores. Faster restoring would add energy.
constexpr double restored_share = 0.2;
// Most sweeps of one solution.
constexpr int most_displacement_sweeps = 30;
// A contact that lacks more than this fraction of its rest gap is corrected, and so are its
// neighbours.
constexpr double small_lack = 0.2;
// Factor of corrections. Above 1 they reach farther in a sweep.
constexpr double relaxation = 1.5;

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
  add(contacts);
}

void DisplacementSolver::add(std::span<const SphereContact> contacts) {
  for (const SphereContact& contact : contacts) {
    const double rest = rest_gap_of(contact), gap = contact.gap;
    const double target = gap < rest ? gap + restored_share * (rest - gap) : rest;
    double least = (target - gap) / length_;
    if (contact.other < 0) least += contact.normal.dot(contact.drive);
    const int place = batches_.add(contact.sphere, contact.other);
    lanes_.resize(static_cast<std::size_t>(batches_.count()) * registers_per_batch,
                  {LaneVec3::Constant(0.0), 0.0, 0.0, 0.0});
    LaneRows& rows = lanes_[place / materials::lane_count];
    const int lane = place % materials::lane_count;
    set_lane(rows.normal, lane, contact.normal);
    rows.least.values[lane] = least;
    rows.rest.values[lane] = rest;
  }
}

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
  const auto first = side(batches_.spheres(index * materials::lane_count));
  const auto second = side(batches_.others(index * materials::lane_count));
  LaneRows& rows = lanes_[index];
  LaneRecords a = load_records(first), b = load_records(second);
  const Lanes mobility = a.number + b.number;
  const Lanes lack = rows.least - rows.normal.dot(a.vector - b.vector);
  const Lanes before = rows.multiplier;
  rows.multiplier = choose(0.0 < mobility, larger(0.0, before + relaxation * lack / mobility), before);
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
