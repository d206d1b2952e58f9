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
// Factor of corrections. Above 1 they reach farther in a sweep. The first sweep solves each contact
// exactly, which is all that a lone one needs.
constexpr float displacement_relaxation = 1.5F;
// Fraction of the last step's corrections that a step begins with.
constexpr double kept_share = 0.8;

// Takes an energy per mass (m^2/s^2) from the motion along a unit vector relative to `drive`, or
// adds it if it is negative. The motion does not turn round.
void take_energy(const Vec3& direction, const Vec3& drive, double energy, Vec3& velocity) {
  const double speed = direction.dot(velocity - drive);
  const double left = std::sqrt(std::max(0.0, speed * speed - 2 * energy));
  velocity += (std::copysign(left, speed) - speed) * direction;
}

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
  mean_.assign(mean.begin(), mean.end());
  corrections_.assign(mean.size() + 1, {});
  for (std::size_t i = 0; i < mean.size(); ++i)
    corrections_[i].mobility = static_cast<float>(inverse_mass_[i]);
  rows_.clear();
  supports_.clear();
  fixed_.clear();
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
  double least = (target - gap) / length_ - contact.normal.dot(mean_[contact.sphere]);
  least += contact.normal.dot(contact.other < 0 ? contact.drive : mean_[contact.other]);
  const int place = batches_.add(contact.sphere, contact.other);
  if (batches_.count() > static_cast<int>(lanes_.size()))
    lanes_.push_back({FloatLaneVec3::Constant(0.0F), 0.0F, 0.0F, 0.0F});
  LaneRows& rows = lanes_[batch_of(place)];
  const int lane = lane_of(place);
  set_lane(rows.normal, lane, contact.normal);
  rows.least.values[lane] = static_cast<float>(least);
  rows.small.values[lane] = static_cast<float>(small_lack * rest / length_);
  if (contact.other < 0) supports_.push_back({place, contact.normal, contact.drive});
  return place;
}

// Begins with most of the last step's corrections: where velocities have not converged, contacts
// lack as much again. The sweeps take back what is too much. Corrections (m/s) of a much shorter
// step say nothing about this one: they restored gaps in a short time.
void DisplacementSolver::take_kept() {
  const double growth = length_ / kept_length_;
  const double scale = kept_share * std::min(growth, 1 / growth);
  const auto key_of = [&](std::size_t row) { return rows_[row].key; };
  match_kept(kept_, rows_.size(), key_of, [&](std::size_t row, const KeptMultiplier& kept) {
    const int place = rows_[row].place, lane = lane_of(place);
    const auto multiplier = static_cast<float>(scale * kept.multiplier);
    LaneRows& rows = lanes_[batch_of(place)];
    rows.multiplier.values[lane] = multiplier;
    Correction &a = corrections_[batches_.spheres_of(batch_of(place))[lane]],
               &b = corrections_[batches_.others_of(batch_of(place))[lane]];
    for (int k = 0; k < 3; ++k) {
      const float change = multiplier * rows.normal[k].values[lane];
      a.mean[k] += a.mobility * change;
      b.mean[k] -= b.mobility * change;
    }
  });
}

void DisplacementSolver::keep() {
  kept_.clear();
  kept_length_ = length_;
  for (const Row& row : rows_) {
    const double multiplier = lanes_[batch_of(row.place)].multiplier.values[lane_of(row.place)];
    if (multiplier > 0) kept_.push_back({row.key, multiplier});
  }
}

void DisplacementSolver::transfer(StateArchive& archive) { archive(kept_, kept_length_); }

bool DisplacementSolver::fix(int sphere) {
  Correction& fixed = corrections_[sphere];
  if (fixed.mobility == 0) return false;
  fixed.mobility = 0;
  fixed_.push_back(sphere);
  for (int k = 0; k < 3; ++k) fixed.mean[k] = static_cast<float>(-mean_[sphere][k]);
  batches_.touch(sphere);
  return true;
}

void DisplacementSolver::keep_energy(const Vec3& gravity, std::span<Vec3> velocity) const {
  // Energies per mass. Spheres get what they are owed before they pay.
  const auto settle = [&](bool pays) {
    for (const Support& support : supports_) {
      const int batch = batch_of(support.place), lane = lane_of(support.place);
      const int sphere = batches_.spheres_of(batch)[lane];
      const double way =
          length_ * corrections_[sphere].mobility * lanes_[batch].multiplier.values[lane];
      const double gain = -way * support.normal.dot(gravity);
      if (pays ? gain > 0 : gain < 0)
        take_energy(support.normal, support.drive, gain, velocity[sphere]);
    }
  };
  settle(false);
  settle(true);
  for (const int sphere : fixed_) {
    const double gain = length_ * mean_[sphere].dot(gravity);
    take_energy(mean_[sphere].normalized(), Vec3::Zero(), gain, velocity[sphere]);
  }
}

// Returns the lanes in which the displacements have changed by an amount that matters.
unsigned DisplacementSolver::solve(int batch, float factor) {
  const auto side = [&](const std::array<int, RowBatches::width>& spheres) {
    return [this, &spheres](int lane) { return corrections_[spheres[lane]].mean.data(); };
  };
  const auto first = side(batches_.spheres_of(batch)), second = side(batches_.others_of(batch));
  LaneRows& rows = lanes_[batch];
  std::array<FloatLanes, 4> a = load_fours(first), b = load_fours(second);
  const FloatLanes mobility = a[3] + b[3];
  const FloatLaneVec3 apart(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
  const FloatLanes lack = rows.least - rows.normal.dot(apart);
  const FloatLanes before = rows.multiplier;
  rows.multiplier =
      choose(FloatLanes(0.0F) < mobility, larger(0.0F, before + factor * lack / mobility), before);
  const FloatLanes change = rows.multiplier - before;
  for (int k = 0; k < 3; ++k) {
    a[k] += a[3] * change * rows.normal[k];
    b[k] -= b[3] * change * rows.normal[k];
  }
  store_fours(a, first);
  store_fours(b, second);
  return bits_of(rows.small < magnitude(change) * mobility);
}

void DisplacementSolver::correct() {
  for (int sweep = 0; sweep < most_displacement_sweeps; ++sweep) {
    const float factor = sweep == 0 ? 1 : displacement_relaxation;
    if (!batches_.sweep([&](int batch) { return solve(batch, factor); })) return;
  }
}

}  // namespace weft::sim
