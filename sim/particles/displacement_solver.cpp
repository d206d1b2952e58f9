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
  queue_.clear(static_cast<int>(mean.size()));
  for (std::size_t i = 0; i < mean.size(); ++i) spheres_[i] = {mean[i], inverse_mass_[i]};
  rows_.clear();
  add(contacts);
}

void DisplacementSolver::add(std::span<const SphereContact> contacts) {
  for (const SphereContact& contact : contacts) {
    const double rest = rest_gap_of(contact), gap = contact.gap;
    const double target = gap < rest ? gap + restored_share * (rest - gap) : rest;
    Row row{.normal = contact.normal,
            .least = (target - gap) / length_,
            .rest = rest,
            .sphere = contact.sphere,
            .other = contact.other};
    if (contact.other < 0) row.least += contact.normal.dot(contact.drive);
    rows_.push_back(row);
    queue_.add(row.sphere, row.other);
  }
}

bool DisplacementSolver::fix(int sphere) {
  Sphere& fixed = spheres_[sphere];
  if (fixed.mobility == 0) return false;
  fixed = {Vec3::Zero(), 0};
  queue_.push_rows_of(sphere);
  return true;
}

// Returns true if the displacements have changed by an amount that matters.
bool DisplacementSolver::solve(Row& row) {
  Sphere& a = spheres_[row.sphere];
  Sphere* const b = row.other < 0 ? nullptr : &spheres_[row.other];
  double speed = row.normal.dot(a.mean), mobility = a.mobility;
  if (b != nullptr) {
    speed -= row.normal.dot(b->mean);
    mobility += b->mobility;
  }
  const double lack = row.least - speed;
  if (lack <= 0 && row.multiplier == 0) return false;
  if (mobility == 0) return false;
  const double before = row.multiplier;
  row.multiplier = std::max(0.0, before + relaxation * lack / mobility);
  const double change = row.multiplier - before;
  a.mean += a.mobility * change * row.normal;
  if (b != nullptr) b->mean -= b->mobility * change * row.normal;
  return std::abs(change) * mobility * length_ > small_lack * row.rest;
}

void DisplacementSolver::correct() {
  for (int sweep = 0; sweep < most_displacement_sweeps; ++sweep) {
    const bool is_any = queue_.sweep([&](int index) {
      const Row& row = rows_[index];
      if (!solve(rows_[index])) return;
      queue_.push_rows_of(row.sphere);
      if (row.other >= 0) queue_.push_rows_of(row.other);
      queue_.remove(index);
    });
    if (!is_any) return;
  }
}

}  // namespace weft::sim
