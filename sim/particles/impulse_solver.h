// Velocities and displacements of rigid spheres in contact, during one step.
#pragma once

#include <span>
#include <vector>

#include "sim/base/state_archive.h"
#include "sim/particles/row_batches.h"
#include "sim/particles/sphere_contact.h"
#include "sim/particles/sphere_lanes.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// The data of a step that both solutions share. Lists have one entry per sphere.
struct ImpulseStep {
  double length = 0;                   // s
  double resting_speed = 0;            // m/s; spheres that would part more slowly rest instead
  std::span<const Vec3> velocity;      // m/s, at the start
  std::span<const Vec3> acceleration;  // m/s^2, of a free sphere, constant during the step
};

// Solves for the impulses of contacts by projected Gauss-Seidel sweeps over batches of contacts
// without common spheres (row_batches.h). The order of the contacts determines the batches, so the
// result depends neither on threads nor on the length of vector registers.
//
// Between impacts a sphere moves freely, x(t) = x + v t + a t^2/2. If a contact closes at the time
// t within the step at the speed u, its normal impulse makes the sides part at e u at that time,
// which is Newton's law of restitution with the coefficient e. The heights of a lone bouncing
// sphere are therefore exact for any length of steps. A contact that rests takes up the weight.
// Friction is limited to Coulomb's cone.
class ImpulseSolver {
 public:
  // The scene must outlive the solver.
  explicit ImpulseSolver(const Scene& scene);

  // Gaps (m) at which contacts rest, by sphere. They absorb what sweeps leave undone.
  std::span<const double> rest_gaps() const { return rest_gap_; }
  // Inverse masses (1/kg), by sphere.
  std::span<const double> inverse_masses() const { return inverse_mass_; }
  // Sets `velocity` (m/s) and `spin` (rad/s) to those at the end of the step. `spin` is that at the
  // start on entry. Contacts must be sorted by key. Starts from the impulses of the last call for
  // contacts that go on.
  void find_velocities(std::span<const SphereContact> contacts, const ImpulseStep& step,
                       std::span<Vec3> velocity, std::span<Vec3> spin);
  // Sets `mean` (m/s) to the displacement of each sphere that its velocities and impacts imply,
  // divided by the length of the step. `velocity` is the result of find_velocities(), which must
  // have come before.
  void find_displacements(const ImpulseStep& step, std::span<const Vec3> velocity,
                          std::span<Vec3> mean) const;
  // Returns the moment of inertia (kg m^2) of a sphere about its centre, 0 if it does not spin.
  double inertia(int sphere) const { return inertia_[sphere]; }
  // Forgets the impulses of the last step.
  void forget() { kept_.clear(); }
  void transfer(StateArchive& archive);
  // Returns the number of sweeps over velocities so far.
  std::int64_t sweeps() const { return sweeps_; }

 private:
  // The motion of a sphere, on a cache line of its own.
  struct alignas(64) Motion {
    Vec3 velocity;         // m/s
    double mass_share;     // 1/kg, inverse mass
    Vec3 turning;          // m/s, radius times spin
    double turning_share;  // 1/kg, squared radius over moment of inertia, or 0
  };
  // A contact that takes part.
  struct Row {
    int contact = 0;    // index in the list of contacts
    int place = 0;      // in the batches
    double target = 0;  // m/s, least normal velocity at the end
    bool is_impact = false;
    double impact_time = 0;  // s, within the step
  };
  // Rows that are solved at once. Lanes without a row are zero.
  struct LaneRows {
    LaneVec3 normal;
    Lanes normal_mass, tangential_mass;  // kg
    Lanes friction;
    LaneVec3 drive;       // m/s
    Lanes target;         // m/s
    Lanes impulse;        // kg m/s, along the normal
    LaneVec3 tangential;  // kg m/s, impulse of friction
  };
  // The motions of the two spheres of each lane.
  struct Sides {
    LaneRecords velocity, turning, other_velocity, other_turning;
  };
  // An impulse that the next step starts from.
  struct KeptImpulse {
    ContactKey key;
    double normal;
    std::array<double, 3> tangential;
  };

  void start(const ImpulseStep& step, std::span<const Vec3> spin);
  void make_rows(std::span<const SphereContact> contacts, const ImpulseStep& step);
  bool set_target(const SphereContact& contact, const ImpulseStep& step, Row& row) const;
  void take_kept(std::span<const SphereContact> contacts, double length);
  void keep(std::span<const SphereContact> contacts, double length);
  void add_row(const SphereContact& contact, Row& row);
  LaneRows& lanes_of(const Row& row) { return lanes_[register_of(row.place)]; }
  const LaneRows& lanes_of(const Row& row) const { return lanes_[register_of(row.place)]; }
  Sides load(int index) const;
  void apply(Sides& sides, int index, const Lanes& along_normal, const LaneVec3& tangential);
  unsigned solve(int index, double small_change);
  double least_gap(const SphereContact& contact) const;

  std::vector<double> radius_, inverse_mass_, inverse_inertia_, inertia_, rest_gap_;
  std::vector<Motion> motion_;  // by sphere; the last one is that of no sphere and stays at rest
  std::vector<Row> rows_;       // in the order of the contacts
  RowBatches batches_;
  std::vector<LaneRows> lanes_;  // registers_per_batch to each batch
  std::vector<KeptImpulse> kept_;
  double kept_length_ = 0;  // s, length of the step of kept_
  std::int64_t sweeps_ = 0;
};

}  // namespace weft::sim
