// The equations of motion: y = (x, v), x' = v, M v' = forces.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sim/base/statistics.h"
#include "sim/contact/contact.h"
#include "sim/forces/force.h"
#include "sim/forces/varying_numbers.h"
#include "sim/matrix/block_matrix.h"
#include "sim/motion/mass_operator.h"
#include "sim/scene/scene.h"
#include "sim/scene/time_curve.h"

namespace weft::sim {

// A state as the integrator holds it: positions (m), then velocities (m/s) of the dynamic
// particles. Forces compute the positions of pinned particles from the time and never read them
// here. Moving pinned particles advance here with their prescribed rates, so that a method's error
// control sees them; those at rest do not change.
struct StateView {
  std::span<const Vec3> position;
  std::span<const Vec3> velocity;
  // Views an array of 6 * particles doubles as a state.
  static StateView of(std::span<const double> y);
};

struct Energies {
  double kinetic = 0;                                   // J
  double gravitational = 0;                             // J, zero at the origin
  double contact = 0;                                   // J
  double constraints = 0;                               // J, part of `elastic`
  std::vector<std::pair<std::string, double>> elastic;  // by force, J
  double total() const;
};

// The numbers that a frame records of a state.
struct StateSummary {
  Energies energies;
  std::optional<double> smallest_gap;  // m, of the pairs in reach
  int sleeping_bodies = 0;
};

// The forces of a state in parts, N, by dynamic particle.
struct ForceParts {
  std::vector<Vec3> own;  // of their bodies, air, gravity and mass damping
  // Contact forces along the normals (contact damping included), and friction forces. Zero without
  // contact.
  std::vector<Vec3> contact, friction;
  std::vector<Vec3> support;  // exerted by pins, with the inertia of what they hold
  // Contact forces of each body of the scene that is not dynamic; zero for others.
  std::vector<Wrench> obstacles;
  std::vector<OuterForce> outer;  // of clamps and ties
};

// The arguments of an assembly of K and D, from which they can be assembled again with the same
// bits.
struct Linearisation {
  double time = 0, step_start = 0;  // s
  std::vector<double> state;
  Definiteness definiteness = Definiteness::exact;
  double gamma = 0;  // s, of a joined assembly; 0: K and D are separate
  std::optional<double> load;
  double hardness = 1;
};

// Evaluates forces and their derivatives at states that the caller holds. It keeps only the results
// of the last evaluation: the matrices K and D, the pairs in contact, and the candidates among
// which these were found.
class Dynamics {
 public:
  Dynamics(const Scene& scene, Statistics& statistics)
      : Dynamics(scene, statistics, make_forces(scene)) {}
  // Uses these forces instead of those of the scene; contact and mass damping are added.
  Dynamics(const Scene& scene, Statistics& statistics, std::vector<std::unique_ptr<Force>> forces);
  // With contact, which searches by `search`.
  Dynamics(const Scene& scene, Statistics& statistics, ChosenSearch search)
      : Dynamics(scene, statistics, make_forces(scene), std::move(search)) {}

  const Scene& scene() const { return scene_; }
  int particle_count() const { return scene_.dynamic_particles; }
  int threads() const { return threads_; }
  // M, with the consistent mass of shells in motion; equilibria have lumped masses.
  const MassOperator& mass() const { return mass_; }
  MassOperator& mass() { return mass_; }
  Statistics& statistics() { return statistics_; }
  const Statistics& statistics() const { return statistics_; }
  // Work of one evaluation of the forces, in the unit of work.h.
  double evaluation_work() const;
  std::size_t state_size() const { return 6 * static_cast<std::size_t>(scene_.dynamic_particles); }
  std::vector<double> initial_state() const;

  // Computes y' at (t, y). Returns the fault if y' does not exist: two surfaces have no gap, or a
  // value is not finite.
  [[nodiscard]] std::optional<ContactFault> rate(double time, std::span<const double> y,
                                                 std::span<double> rate);

  // Computes the second half of y': accelerations, m/s^2, by particle.
  [[nodiscard]] std::optional<ContactFault> acceleration(double time, std::span<const double> y,
                                                         std::span<Vec3> acceleration);

  // Computes the net forces of a state with contact and gravity, N, by dynamic particle. Those on
  // held particles are what their supports carry. Returns the fault as rate() does.
  [[nodiscard]] std::optional<ContactFault> net_forces(double time, std::span<const double> y,
                                                       std::span<Vec3> force);
  // Computes the applied loads of a state, N, by dynamic particle: those of Force::is_load() at the
  // present load factor and, if asked for, gravity in full.
  void applied_loads(double time, std::span<const double> y, bool with_gravity,
                     std::span<Vec3> force);
  // Sets the factor of all forces that are loads.
  void set_load_factor(double factor);
  // True if one of the forces is a load.
  bool has_loads() const;

  // Stores K = -dF/dx and D = -dF/dv of all forces except contact. Contact keeps its own matrices,
  // which are always those of the last rate(). Mass damping is part of D.
  void assemble(double time, std::span<const double> y,
                Definiteness definiteness = Definiteness::exact);
  // Assembles for one gamma and one right side, in half the memory. The stiffness becomes K + D /
  // gamma, without a separate damping matrix. `residual` (m, by particle) is minus the b_x of the
  // system to be solved. With damping_product() = D residual, gamma K b_x = gamma stiffness b_x +
  // damping_product.
  void assemble_joined(double time, std::span<const double> y, Definiteness definiteness,
                       double gamma, std::span<const Vec3> residual);
  // The arguments of the last assembly.
  const Linearisation& linearisation() const { return linearisation_; }
  // Repeats an assembly from its arguments, contact included.
  void assemble_again(const Linearisation& place);
  // D times the residual of the last assembly (N s, by particle). Empty if that was not joined, or
  // if there is no D.
  std::span<const Vec3> damping_product() const { return damping_product_; }
  // Sets the load of an equilibrium: from now on particles are at rest, and gravity is this
  // fraction of the scene's.
  void set_load(double load) { load_ = load; }
  // Sets the fraction of their stiffness that membranes and springs have from now on. Searches for
  // equilibria start with softened bodies.
  void set_hardness(double hardness) { hardness_ = hardness; }
  const BlockMatrix& stiffness() const { return stiffness_; }
  // Precondition: has_damping(), that is, D exists and is not joined to the stiffness.
  const BlockMatrix& damping() const { return damping_; }
  bool has_damping() const { return has_damping_ && damping_product_.empty(); }
  const Contact* contact() const { return contact_ ? &*contact_ : nullptr; }
  Contact* contact() { return contact_ ? &*contact_ : nullptr; }

  // True if a pin of a dynamic body moves.
  bool pins_move() const { return pins_move_; }
  // Announces a step that starts at `time`. If a prescribed velocity or a curve jumps at the end of
  // the step, all times after its start have the value before the jump. Without this call, all
  // times have the value after it.
  void begin_step(double time) { step_start_ = time; }
  double step_start() const { return step_start_; }
  // The instant at which forces at a time are evaluated. A jump within the shortest step counts as
  // passed, as for MotionLimits.
  Instant instant(double time) const {
    const double within = is_before_jump(time) ? step_start_ : time;
    return {time, within + scene_.source.time.minimum_step};
  }
  // Sets positions and velocities of moving pins in y, after any jump.
  void place_pins(double time, std::span<double> y) const;
  // Adds factor * rate(time) to y, for moving pins alone.
  void advance_pins(double time, double factor, std::span<double> y) const;
  // Checks that every pair of surfaces is certain to keep apart from `start` at one time to `end`
  // at a later one (positions of all particles, m, as expand() leaves them). Free particles move on
  // straight paths, prescribed ones on their own. Returns what stands in the way, if anything does.
  // Precondition: contact is on.
  [[nodiscard]] std::optional<ContactFault> check_path(double start_time,
                                                       std::span<const Vec3> start, double end_time,
                                                       std::span<const Vec3> end);
  // Checks the path with prescribed particles on straight lines too. Without `gap`, surfaces need
  // only not meet (Contact::check_crossing).
  [[nodiscard]] std::optional<ContactFault> check_straight_path(double start_time,
                                                                std::span<const Vec3> start,
                                                                double end_time,
                                                                std::span<const Vec3> end,
                                                                bool gap);

  // Writes positions and velocities of all particles, prescribed ones included. Entries of moving
  // obstacles stay as they are. Both lists must be empty or come from an earlier call: obstacles at
  // rest are written only once.
  void expand(double time, std::span<const double> y, std::vector<Vec3>& position,
              std::vector<Vec3>& velocity) const;
  // Writes the same, moving obstacles included: O(their particles).
  void expand_all(double time, std::span<const double> y, std::vector<Vec3>& position,
                  std::vector<Vec3>& velocity) const;
  std::vector<std::string> force_names() const;
  // Computes the energies at (t, y). With contact, it evaluates contact anew.
  Energies energies(double time, std::span<const double> y);
  // Computes the energies at (t, y), but takes that of contact from the last rate(), whose state is
  // within a step's tolerance of y.
  Energies energies_at_last_rate(double time, std::span<const double> y);
  // Power (W) of external forces on the free particles, positive if wind drives them, plus the
  // power that moving points outside the state put into forces. Without prescribed motion it costs
  // one evaluation of those forces alone.
  double external_power(double time, std::span<const double> y);
  bool has_external_forces() const;
  // Gravity (m/s^2) at a time, on the side of a jump that begin_step() implies.
  Vec3 gravity(double time) const { return gravity_curve_.at(instant(time)); }
  // True if gravity, friction or a coefficient of a force varies in time.
  bool varies() const { return varies_; }
  // Forces (N) on all particles, prescribed ones and obstacles included: contact, which is
  // evaluated anew, and the forces of the bodies, but neither gravity, mass damping nor external
  // ones. Those on moving pins of shells include the inertia of the free particles that the mass
  // couples to them. Not counted in the statistics' force evaluations. `loaded` are the particles of obstacles
  // on which there are forces, in order. Both lists must be empty or come from an earlier call.
  void find_forces_on_all(double time, std::span<const double> y, std::vector<Vec3>& force,
                          std::vector<int>& loaded);
  // Computes the parts of the forces at (t, y). Contact is evaluated anew. Lists are resized. Not
  // counted in the statistics' force evaluations. Cost: an evaluation of the forces.
  void find_force_parts(double time, std::span<const double> y, ForceParts& parts);
  // Finds the largest l / L - 1 over the edges of all bodies. `particle` is the first end of that
  // edge, as triangles list it; of equal edges the first counts.
  struct LargestStretch {
    double value = 0;
    int particle = 0;
  };
  LargestStretch find_largest_stretch(std::span<const Vec3> position) const;
  double largest_stretch(std::span<const Vec3> position) const {
    return find_largest_stretch(position).value;
  }

 private:
  Dynamics(const Scene& scene, Statistics& statistics, std::vector<std::unique_ptr<Force>> forces,
           ChosenSearch search);
  // Returns the state of the dynamic particles, with held ones in their prescribed places, and
  // calls set_time(). Valid as long as y and until the next call.
  Kinematics kinematics(double time, std::span<const double> y);
  void add_forces(const Kinematics& state, std::span<Vec3> force);
  // Sets `force` to the forces of all arrays and of contact.
  std::optional<ContactFault> sum_forces(double time, const Kinematics& state,
                                         std::span<Vec3> force);
  ContactFault fault_of_first_not_finite(std::span<const Vec3> vectors) const;
  void add_mass_damping();
  // Gives everything that varies its value at this time; costs nothing if nothing does.
  void set_time(double time);
  // Turns forces (N) into accelerations (m/s^2), which are zero for held particles. Returns true if
  // all are finite.
  bool divide_by_mass(double time, const Kinematics& state, std::span<Vec3> force);
  // The same with the consistent mass of shells. Forces include weight and mass damping.
  void solve_for_accelerations(double time, std::span<Vec3> force);
  // Adds the weight and mass damping (N) of a state to the forces.
  void add_weight_and_damping(const Kinematics& state, std::span<Vec3> force) const;
  void add_mass_damping(const Derivatives& into);
  void find_forces_of_pins(double time, ForceParts& parts);
  void subtract_coupled_inertia(double time, const Kinematics& state, std::span<Vec3> force);
  void assemble(double time, std::span<const double> y, Definiteness definiteness,
                const Derivatives& into);
  void note_place(double time, std::span<const double> y, Definiteness definiteness, double gamma);
  bool is_before_jump(double time) const { return time > step_start_; }
  template <class Visit>
  void visit_moving_pins(const Visit& visit) const;
  bool is_moving_obstacle(const PrescribedMotion& held) const {
    return held.moves && !held.particles.empty() && held.particles[0] >= scene_.dynamic_particles;
  }
  PathStray path_stray(double from, double to);
  std::optional<ContactFault> evaluate_contact(double time);
  // Positions with the poses that go with them.
  struct Placing {
    std::vector<Vec3> position;
    std::vector<RigidPose> poses;
  };
  PlacedParticles placed(double time, std::span<const Vec3> position, Placing& placing) const;

  void find_accelerations_of_pins(double time, std::span<Vec3> acceleration) const;

  const Scene& scene_;
  Statistics& statistics_;
  int threads_ = 1;
  MassOperator mass_;
  std::vector<std::unique_ptr<Force>> forces_;
  bool pins_move_ = false;
  std::vector<int> held_;  // dynamic particles that are pinned
  std::optional<Contact> contact_;
  BlockMatrix stiffness_;
  bool has_damping_ = false;
  BlockMatrix damping_;  // made on first use; excludes damping_product_
  std::vector<Vec3> damping_product_;
  Linearisation linearisation_;
  std::optional<double> load_;
  double hardness_ = 1;
  TimeCurve<Vec3> gravity_curve_;
  TimeCurve<double> friction_curve_;
  VaryingNumbers mass_damping_curves_;  // of runs of particles
  bool varies_ = false;
  Vec3 gravity_;                           // m/s^2, at the time set
  std::vector<double> mass_damping_;       // 1/s, by particle; empty where there is none
  std::vector<Vec3> coupled_;              // scratch: accelerations of pins of shells
  std::vector<Vec3> position_, velocity_;  // of all particles, if the state's own do not suffice
  std::vector<RigidPose> poses_;           // of the obstacles that move
  Placing path_start_, path_end_;          // of a path, where obstacles move
  double step_start_ = std::numeric_limits<double>::infinity();  // s
  std::vector<double> body_stray_, particle_stray_;              // m
};

}  // namespace weft::sim
