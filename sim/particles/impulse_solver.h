// Velocities and displacements of rigid spheres in contact, during one step.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/base/islands.h"
#include "sim/base/state_archive.h"
#include "sim/particles/float_lanes.h"
#include "sim/particles/row_batches.h"
#include "sim/particles/sphere_contact.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// The data of a step that both solutions share. Lists have one entry per sphere.
struct ImpulseStep {
  double length = 0;                   // s
  double resting_speed = 0;            // m/s; spheres that would part more slowly rest instead
  std::span<const Vec3> velocity;      // m/s, at the start
  std::span<const Vec3> acceleration;  // m/s^2, of a free sphere, constant during the step
};

// The change of the motion of one sphere by an impact.
struct Kick {
  std::int64_t sphere = 0;
  double time = 0;                   // s, from the start of the step
  std::array<double, 3> velocity{};  // m/s, change
  std::array<double, 3> spin{};      // rad/s, change
};

// Solves for the impulses of contacts by projected Gauss-Seidel sweeps over batches of contacts
// without common spheres (row_batches.h). The order of the contacts determines the batches, so the
// result depends neither on threads nor on the length of vector registers. Sweeps are in single
// precision. A last one is in double precision, and momentum is conserved to rounding.
//
// Between impacts a sphere moves freely, x(t) = x + v t + a t^2/2. If a contact closes at the time
// t within the step at the speed u, its normal impulse makes the sides part at e u at that time,
// which is Newton's law of restitution with the coefficient e. The heights of a lone bouncing
// sphere are therefore exact for any length of steps. A contact that rests takes up the weight.
// Friction is limited to Coulomb's cone. Newton's law can add energy where several impacts meet, or
// impacts and friction. Spheres that are connected by contacts then have the largest share of their
// restitution, the same for all, with which their impulses together do no work
// (docs/decisions/0098).
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
  // Lists what impacts do in the last solution, to each sphere, where no other contact of their
  // spheres has an impulse: those that answer each other do not act in the order of their times.
  // `contacts` are those that find_velocities() had.
  void find_kicks(std::span<const SphereContact> contacts, std::vector<Kick>& kicks) const;
  // Returns the moment of inertia (kg m^2) of a sphere about its centre, 0 if it does not spin.
  double inertia(int sphere) const { return inertia_[sphere]; }
  // Forgets the impulses of the last step, and what rests.
  void forget();
  void transfer(StateArchive& archive);
  // Returns the number of sweeps over velocities so far.
  std::int64_t sweeps() const { return sweeps_; }

 private:
  // How far the sweeps have changed the motion of a sphere. Sweeps count masses in unit_mass_, so
  // that squared impulses of dust do not underflow.
  struct alignas(32) Change {
    std::array<float, 3> velocity;  // m/s
    float mass_share;               // inverse mass
    std::array<float, 3> turning;   // m/s, radius times spin
    float turning_share;            // squared radius over moment of inertia, or 0
  };
  // A contact that takes part. Impulses are those after the sweeps.
  struct Row {
    int contact = 0;  // index in the list of contacts
    int place = 0;    // in the batches
    bool is_impact = false;
    bool parts = false;                           // true for an impact from which the sides rebound
    double time = 0;                              // s, within the step, when the impulse acts
    double target = 0;                            // m/s, least normal velocity at the end
    double normal_mass = 0, tangential_mass = 0;  // kg
    double impulse = 0;                           // kg m/s, along the normal
    Vec3 tangential{0, 0, 0};                     // kg m/s, impulse of friction

    // Returns the unit vector along which the impulse acts: not that of the start where the surface
    // rises before the sphere.
    Vec3 normal_of(const SphereContact& contact) const {
      return parts ? contact.normal : contact.rolling_normal();
    }
    // Returns the velocity (m/s) of an obstacle that the sphere meets, or that it stays on.
    const Vec3& drive_of(const SphereContact& contact) const {
      return is_impact ? contact.drive : contact.end_drive;
    }
  };
  // The rows of a batch. Masses and impulses are divided by unit_mass_. Lanes without a row are
  // zero.
  struct LaneRows {
    FloatLaneVec3 normal;
    FloatLanes normal_mass, tangential_mass;
    FloatLanes friction;
    FloatLaneVec3 approach;    // m/s, relative velocity of the sides without impulses
    FloatLanes target;         // m/s
    FloatLanes impulse;        // m/s, along the normal
    FloatLaneVec3 tangential;  // m/s, impulse of friction
  };
  // Changes of the two spheres of each lane.
  struct Sides {
    std::array<FloatLanes, 4> velocity, turning, other_velocity, other_turning;
  };
  // Relative velocities (m/s) without impulses: at the end of the step, and when the impulse of the
  // contact acts.
  struct FreeMotion {
    Vec3 at_end{0, 0, 0}, at_impulse{0, 0, 0};
  };
  // Work of impulses (J): positive and negative terms together, and their sizes.
  struct Work {
    double sum = 0, size = 0;
  };
  // An impulse that the next step starts from.
  struct KeptImpulse {
    ContactKey key;
    double normal;
    std::array<double, 3> tangential;
  };

  void start(const ImpulseStep& step, std::span<const Vec3> spin);
  void make_rows(std::span<const SphereContact> contacts, const ImpulseStep& step);
  double parting_acceleration(const SphereContact& contact, const ImpulseStep& step) const;
  double least_rebound(const SphereContact& contact, const ImpulseStep& step) const;
  bool set_target(const SphereContact& contact, const ImpulseStep& step, Row& row) const;
  void take_kept(std::span<const SphereContact> contacts, double length);
  void keep(std::span<const SphereContact> contacts, const ImpulseStep& step);
  void add_row(const SphereContact& contact, Row& row);
  Vec3 velocity_at(const SphereContact& contact, const Row& row) const;
  LaneRows& lanes_of(const Row& row) { return lanes_[batch_of(row.place)]; }
  const LaneRows& lanes_of(const Row& row) const { return lanes_[batch_of(row.place)]; }
  Sides load(int batch) const;
  void apply(Sides& sides, int batch, const FloatLanes& along_normal,
             const FloatLaneVec3& tangential);
  unsigned solve(int batch, float factor, float small_change);
  void take_impulses(std::span<const SphereContact> contacts);
  double solve_exactly(const SphereContact& contact, double target, Row& row);
  void find_free_motions(std::span<const SphereContact> contacts, const ImpulseStep& step);
  Work work_of(std::span<const SphereContact> contacts, int row) const;
  std::vector<int> rows_with_gains(std::span<const SphereContact> contacts);
  double work_of(std::span<const SphereContact> contacts, std::span<const int> rows) const;
  double settle(std::span<const SphereContact> contacts, std::span<const int> rows);
  void limit_energy(std::span<const SphereContact> contacts, std::span<const int> rows);
  void limit_energy(std::span<const SphereContact> contacts);
  void push(const SphereContact& contact, const Vec3& normal, double along_normal,
            const Vec3& tangential);
  double least_gap(const SphereContact& contact) const;

  std::vector<double> radius_, inverse_mass_, turning_share_, inertia_, rest_gap_;
  // The share of the acceleration of a free sphere that contacts at rest took up in the last step,
  // by sphere: all contacts, and those with other spheres.
  std::vector<double> support_, support_by_spheres_;
  std::vector<int> impulse_count_;        // contacts with an impulse in this step, by sphere
  double unit_mass_;                      // kg, that of the lightest sphere
  std::vector<Vec3> velocity_, turning_;  // m/s, by sphere, without impulses until take_impulses()
  std::vector<Change> change_;  // by sphere; the last one is that of no sphere and stays at rest
  std::vector<Row> rows_;       // in the order of the contacts
  RowBatches batches_;
  std::vector<LaneRows> lanes_;  // by batch
  // The motion of the sides of a contact without impulses, by row; empty if no row parts.
  std::vector<FreeMotion> free_motions_;
  Islands islands_;
  std::vector<KeptImpulse> kept_;
  double kept_length_ = 0;  // s, length of the step of kept_
  std::int64_t sweeps_ = 0;
};

}  // namespace weft::sim
