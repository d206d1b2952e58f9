// Displacements of rigid spheres that keep them apart during one step.
#pragma once

#include <span>
#include <vector>

#include "sim/base/state_archive.h"
#include "sim/particles/float_lanes.h"
#include "sim/particles/row_batches.h"
#include "sim/particles/sphere_contact.h"

namespace weft::sim {

// Corrects the displacements of a step until gap + n . (displacement of both sides) is at least the
// rest gap for all contacts, by over-relaxed projected Gauss-Seidel sweeps over batches of contacts
// whose spheres have changed (row_batches.h). A gap that is smaller at the start of the step gets
// back a fifth of what it lacks.
// A correction moves both sides by amounts inverse to their masses. Corrections are in single
// precision: what rounding leaves is far below a rest gap, and overlaps are looked for afterwards.
// The sides of a contact are convex, so this keeps them apart wherever the sweeps have converged.
// The order of the contacts determines the batches, so the result depends neither on threads nor on
// the length of vector registers.
//
// start(), then any number of add(), fix() and correct(), then keep().
class DisplacementSolver {
 public:
  // `rest_gap` (m) and `inverse_mass` (1/kg) are by sphere and must outlive the solver.
  DisplacementSolver(std::span<const double> rest_gap, std::span<const double> inverse_mass)
      : rest_gap_(rest_gap), inverse_mass_(inverse_mass) {}

  // Begins a step of `length` (s). `mean` (m/s) is the displacement of each sphere, divided by the
  // length. Contacts must be sorted by key. Begins with corrections in proportion to those of the
  // last keep().
  void start(std::span<const SphereContact> contacts, double length, std::span<const Vec3> mean);
  // Adds contacts that were missed.
  void add(std::span<const SphereContact> contacts);
  // Lets a sphere stay where it is from now on. Returns false if it does already.
  bool fix(int sphere);
  // Sweeps until no gap lacks more than a share of the rest gap, or until a number of sweeps.
  void correct();
  // Changes velocities (m/s, by sphere) such that corrections change no energy in a field of
  // gravity (m/s^2). A sphere that an obstacle has lifted loses as much energy of its motion along
  // the normal of the contact, relative to the obstacle, and one that an obstacle has pushed down
  // gains as much. A sphere that stays where it is pays for the fall that it did not make with its
  // motion along that way. What a slow sphere lacks is not taken. Corrections between spheres that
  // both move leave their centre of mass where it is, and change no energy.
  void keep_energy(const Vec3& gravity, std::span<Vec3> velocity) const;
  // Keeps the corrections of the contacts given to start() for the next step.
  void keep();
  // Forgets the corrections of the last step.
  void forget() { kept_.clear(); }
  void transfer(StateArchive& archive);
  // Returns the displacement divided by the length of the step (m/s).
  Vec3 mean(int sphere) const {
    const Correction& correction = corrections_[sphere];
    if (correction.mobility == 0) return Vec3::Zero();
    const auto& [x, y, z] = correction.mean;
    return mean_[sphere] + Vec3(x, y, z);
  }

 private:
  struct alignas(16) Correction {
    std::array<float, 3> mean{};  // m/s
    float mobility = 0;           // 1/kg, 0 if the sphere stays where it is
  };
  // Contacts that are solved at once. Lanes without a contact are zero.
  struct LaneRows {
    FloatLaneVec3 normal;
    FloatLanes least;       // m/s, least normal component of the relative correction
    FloatLanes small;       // m/s, change of that component which does not matter
    FloatLanes multiplier;  // kg m/s, correction along the normal
  };

  // A correction that the next step begins with.
  struct KeptMultiplier {
    ContactKey key;
    double multiplier;
  };
  // A contact that was given to start().
  struct Row {
    ContactKey key;
    int place;  // in the batches
  };

  // A contact with an obstacle.
  struct Support {
    int place;  // in the batches
    Vec3 normal, drive;
  };

  double rest_gap_of(const SphereContact& contact) const;
  int add_row(const SphereContact& contact);
  void take_kept();
  unsigned solve(int batch, float factor);

  std::span<const double> rest_gap_, inverse_mass_;
  double length_ = 0;                    // s
  std::vector<Vec3> mean_;               // m/s, by sphere, without corrections
  std::vector<Correction> corrections_;  // the last one is that of no sphere
  RowBatches batches_;
  std::vector<LaneRows> lanes_;  // by batch
  std::vector<Row> rows_;
  std::vector<Support> supports_;
  std::vector<int> fixed_;  // spheres that stay where they are
  std::vector<KeptMultiplier> kept_;
  double kept_length_ = 0;  // s, length of the step of kept_
};

}  // namespace weft::sim
