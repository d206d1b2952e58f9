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
#include "sim/forces/crease_history.h"
#include "sim/forces/force.h"
#include "sim/forces/varying_numbers.h"
#include "sim/matrix/tiled_matrix.h"
#include "sim/motion/mass_operator.h"
#include "sim/scene/scene.h"
#include "sim/scene/time_curve.h"

namespace weft::sim {

// The state of an integrator: positions (m) of the dynamic particles, then their velocities (m/s).
// Dynamics overrides the entries of moving pins by their prescribed values before it evaluates
// forces. Integrators still advance these entries with the prescribed rates, so that error control
// covers them. Entries of pins at rest do not change.
struct StateView {
  std::span<const Vec3> position;
  std::span<const Vec3> velocity;
  // Views an array of 6 * particles doubles as a state.
  static StateView of(std::span<const double> y);
};

struct Energies {
  double kinetic = 0;                // J
  double gravitational = 0;          // J, zero at the origin of the axes
  double contact = 0;                // J
  double constraints = 0;            // energy of forces with is_constraint(), part of `elastic` (J)
  std::optional<double> dissipated;  // by creases so far (J), not in total(); empty: none yields
  std::vector<std::pair<std::string, double>> elastic;  // name and energy (J) of each force
  double total() const;
};

// Scalars that summarise a state.
struct StateSummary {
  Energies energies;
  // Smallest gap (m) of the contact pairs in reach. Empty without pairs.
  std::optional<double> smallest_gap;
  int sleeping_bodies = 0;
};

// The forces (N) on the dynamic particles of a state, split by origin. Lists have one entry per
// dynamic particle unless stated.
struct ForceParts {
  // All forces except those of contact and pins: elasticity, air, loads, clamps, ties, sliding
  // supports, gravity and mass damping.
  std::vector<Vec3> own;
  // Contact forces along the normals (contact damping included), and friction forces. Zero without
  // contact.
  std::vector<Vec3> contact, friction;
  // Forces that pins exert on held particles, including the inertia of these particles.
  std::vector<Vec3> support;
  // For each body of the scene, the wrench of its contact forces on the dynamic particles. Zero for
  // dynamic bodies.
  std::vector<Wrench> obstacles;
  std::vector<OuterForce> outer;  // forces of the clamps, ties and sliding supports
};

// The arguments of an assembly of K and D. A second assembly from the same arguments gives the same
// bits of K and D.
struct Linearisation {
  double time = 0, step_start = 0;  // s
  std::vector<double> state;
  Definiteness definiteness = Definiteness::exact;
  double gamma = 0;  // gamma (s) of a joined assembly; 0 if K and D are separate
  std::optional<double> load;
  double hardness = 1;
  CreaseHistory::Creases creases;
  Anchors anchors;
};

// Evaluates forces and their derivatives at states that the caller holds. Keeps the results of the
// last evaluation: the matrices K and D, the contact pairs, and the candidate pairs of the broad
// phase.
class Dynamics {
 public:
  Dynamics(const Scene& scene, Statistics& statistics)
      : Dynamics(scene, statistics, make_forces(scene)) {}
  // Uses `forces` instead of the scene's forces. Contact, gravity and mass damping still act.
  Dynamics(const Scene& scene, Statistics& statistics, std::vector<std::unique_ptr<Force>> forces);
  // Uses `search` as the broad phase of contact instead of choosing one.
  Dynamics(const Scene& scene, Statistics& statistics, ChosenSearch search)
      : Dynamics(scene, statistics, make_forces(scene), std::move(search)) {}

  const Scene& scene() const { return scene_; }
  int particle_count() const { return scene_.dynamic_particles; }
  int threads() const { return threads_; }
  // Returns the mass matrix M. Shells have their consistent mass. Searches for equilibria use
  // lumped masses instead.
  const MassOperator& mass() const { return mass_; }
  MassOperator& mass() { return mass_; }
  Statistics& statistics() { return statistics_; }
  const Statistics& statistics() const { return statistics_; }
  // Returns the work of one evaluation of the forces, in the unit of work_of() (work.h).
  double evaluation_work() const;
  std::size_t state_size() const { return 6 * static_cast<std::size_t>(scene_.dynamic_particles); }
  std::vector<double> initial_state() const;

  // Computes y' at (t, y). Returns the fault if y' does not exist: two surfaces have no gap, or a
  // value is not finite.
  [[nodiscard]] std::optional<ContactFault> rate(double time, std::span<const double> y,
                                                 std::span<double> rate);

  // Computes the second half of y': the acceleration (m/s^2) of each dynamic particle. Returns a
  // fault as rate() does.
  [[nodiscard]] std::optional<ContactFault> acceleration(double time, std::span<const double> y,
                                                         std::span<Vec3> acceleration);

  // Computes the net force (N) on each dynamic particle, including contact, gravity and mass
  // damping. The force on a held particle is the load that its support carries. Returns a fault as
  // rate() does.
  [[nodiscard]] std::optional<ContactFault> net_forces(double time, std::span<const double> y,
                                                       std::span<Vec3> force);
  // Computes the applied load (N) on each dynamic particle: all forces with Force::is_load() at the
  // present load factor, plus the full weight if `with_gravity`.
  void applied_loads(double time, std::span<const double> y, bool with_gravity,
                     std::span<Vec3> force);
  // Multiplies all forces with Force::is_load() by `factor` from now on.
  void set_load_factor(double factor);
  // True if a force has Force::is_load().
  bool has_loads() const;

  // Assembles K = -dF/dx and D = -dF/dv of all forces except contact. D includes mass damping. D is
  // zero if a load is set (set_load()). Contact keeps its own matrices, which belong to the last
  // evaluation of contact.
  void assemble(double time, std::span<const double> y,
                Definiteness definiteness = Definiteness::exact);
  // Assembles for a single gamma and a single right-hand side, in half the memory. stiffness()
  // becomes K + D / gamma, and no damping matrix is stored. `residual` (m, by particle) is -b_x,
  // with b_x the right-hand side for positions. The assembly also computes damping_product() = D
  // residual. Then gamma K b_x = gamma stiffness() b_x + damping_product(). Precondition: no load
  // is set, and the hardness is 1.
  void assemble_joined(double time, std::span<const double> y, Definiteness definiteness,
                       double gamma, std::span<const Vec3> residual);
  // Returns the arguments of the last assembly.
  const Linearisation& linearisation() const { return linearisation_; }
  // Repeats an assembly from its arguments, and evaluates contact and its matrices at the same
  // state. Sets the load, the hardness and the step start to those of that assembly. The residual
  // of a joined assembly is not kept: damping_product() becomes zero.
  void assemble_again(const Linearisation& place);
  // Returns D times the residual of the last assembly (N s), one entry per dynamic particle. The
  // result is empty if that assembly was not joined or there is no damping.
  std::span<const Vec3> damping_product() const { return damping_product_; }
  // Sets the load of an equilibrium. From now on, gravity is multiplied by `load`, and all
  // particles, pins and obstacles count as at rest.
  void set_load(double load) { load_ = load; }
  // Returns the load that was set, or 1.
  double load() const { return load_.value_or(1); }
  // From now on, leaves the springs of sliding supports out of K and D, or puts them back.
  void leave_out_supports(bool are_left_out) { supports_are_left_out_ = are_left_out; }
  // Multiplies the forces with Force::is_membrane() and their derivatives by `hardness` from now
  // on. A hardness below 1 softens bodies in searches for equilibria.
  void set_hardness(double hardness) { hardness_ = hardness; }
  const BlockMatrix& stiffness() const { return stiffness_; }
  // Returns the matrix D of the last assemble(). Precondition: has_damping(), and the last assembly
  // was not joined.
  const BlockMatrix& damping() const { return damping_; }
  bool has_damping() const { return has_damping_ && damping_product_.empty(); }
  const Contact* contact() const { return contact_ ? &*contact_ : nullptr; }
  Contact* contact() { return contact_ ? &*contact_ : nullptr; }

  // True if a prescribed motion moves particles of dynamic bodies.
  bool pins_move() const { return pins_move_; }
  // Announces a step that starts at `time`. If a prescribed velocity or a curve jumps at the end of
  // the step, evaluations after `time` use the value before the jump. Without this call,
  // evaluations at a jump use the value after it.
  void begin_step(double time) { step_start_ = time; }
  double step_start() const { return step_start_; }
  // Returns the instant at which varying coefficients are taken for forces at `time` (s). If `time`
  // lies within a step, jumps within time.minimum_step after the start of the step count as passed,
  // and later jumps do not. Otherwise jumps within time.minimum_step after `time` count as passed.
  Instant instant(double time) const {
    const double within = is_before_jump(time) ? step_start_ : time;
    return {time, within + scene_.source.time.minimum_step};
  }
  // Writes the positions and velocities of moving pins at `time` to y. At a jump, writes the values
  // after the jump.
  void place_pins(double time, std::span<double> y) const;
  // At t = 0, and where the velocity of a sliding support jumps, sets the velocities of y that
  // supports hold to those after the jump. Searches for equilibria have no velocities.
  void match_supports(double time, std::span<double> y) const;
  // Adds factor * y' to the entries of moving pins in y. Other entries keep their values.
  void advance_pins(double time, double factor, std::span<double> y) const;
  // Checks that surfaces provably stay apart on the path from `start` to `end`, which are positions
  // (m) of all particles, as expand() writes them. Free particles move on straight lines, and
  // prescribed particles on their prescribed paths. Returns the first fault found, or nothing if
  // the proof succeeds. Precondition: contact is on.
  [[nodiscard]] std::optional<ContactFault> check_path(double start_time,
                                                       std::span<const Vec3> start, double end_time,
                                                       std::span<const Vec3> end);
  // Checks as check_path() does, but with prescribed particles on straight lines too. If `gap` is
  // false, only crossings are faults (Contact::check_crossing).
  [[nodiscard]] std::optional<ContactFault> check_straight_path(double start_time,
                                                                std::span<const Vec3> start,
                                                                double end_time,
                                                                std::span<const Vec3> end,
                                                                bool gap);

  // Calls Contact::add_stops() for the path of check_path(). Precondition: contact is on.
  [[nodiscard]] std::optional<ContactFault> add_stops(double start_time,
                                                      std::span<const Vec3> start, double end_time,
                                                      std::span<const Vec3> end, double gamma,
                                                      std::span<const Vec3> velocity,
                                                      std::span<const Mat3> diagonal, int* added);

  // Returns Contact::largest_relative_gap_change() from the last evaluation of the forces to these
  // positions (m) of all particles at the same time. `start` has their positions at the start of
  // the step. Precondition: contact is on.
  double gap_change_since_evaluation(std::span<const Vec3> start, std::span<const Vec3> position,
                                     double closing_factor) const {
    return contact_->largest_relative_gap_change(start, position_, position, closing_factor);
  }

  // True if a force has states in which no accepted step may end.
  bool has_limits() const { return has_limits_; }
  // Returns a fault if the state must not be accepted: a membrane exceeds its strain_limit. Costs
  // nothing without has_limits(). States that are allowed form a convex set, pins apart.
  [[nodiscard]] std::optional<ContactFault> check_limits(double time, std::span<const double> y);

  // True if bending may yield.
  bool has_creases() const { return creases_ != nullptr; }
  // The history of a run is what advances with accepted steps alone: creases, and the anchors of
  // contacts. share_history() uses the history of `other`, whose scene is made from the same case.
  void share_history(const Dynamics& other);
  // Advances the history to an accepted state. With anchors, evaluates contact there.
  void accept_history(double time, std::span<const double> y);
  // Takes the history to a state from which the run goes on: within the last step, at its end or
  // later.
  void restart_history(double time, std::span<const double> y);
  // Writes or reads the history.
  void transfer_history(StateArchive& archive);
  // Returns the creases that follow from a state, by triangle of a body; empty if it does not
  // yield.
  CreaseHistory::Creases creases_of(double time, std::span<const double> y, int body);

  // Writes positions and velocities of all particles at (time, y), prescribed ones included.
  // Entries of moving obstacles keep their values. Precondition: both lists are empty or come from
  // an earlier call.
  void expand(double time, std::span<const double> y, std::vector<Vec3>& position,
              std::vector<Vec3>& velocity) const;
  // Does expand() and also writes the entries of moving obstacles. O(particles).
  void expand_all(double time, std::span<const double> y, std::vector<Vec3>& position,
                  std::vector<Vec3>& velocity) const;
  std::vector<std::string> force_names() const;
  // Returns sum_i mass_i x_i (kg m) over the dynamic particles that have weight. `position` (m) has
  // one entry per dynamic particle, or one per particle.
  Vec3 moment_of_weight(std::span<const Vec3> position) const;
  // Computes the energies at (t, y). Evaluates contact at this state.
  Energies energies(double time, std::span<const double> y);
  // Computes the energies at (t, y) with the contact energy of the last rate(). Precondition: the
  // state of that rate() is within a step's tolerance of y.
  Energies energies_at_last_rate(double time, std::span<const double> y);
  // Returns the power (W) of external forces on the free particles, positive if wind drives them.
  // Includes the power that forces receive from their moving points
  // (Force::power_of_moving_points()). Cost: one evaluation of the external forces.
  double external_power(double time, std::span<const double> y);
  // Returns the power (W) that seams supply because they close.
  double power_of_closing_seams(double time, std::span<const double> y);
  bool has_external_forces() const;
  // True if a force has points outside the state that move.
  bool has_moving_points() const;
  // Returns gravity (m/s^2) at instant(time).
  Vec3 gravity(double time) const { return gravity_curve_.at(instant(time)); }
  // True if gravity, friction, mass damping, or a coefficient or moving point of a force varies in
  // time.
  bool varies() const { return varies_; }
  // Computes the forces (N) on all particles, prescribed ones and obstacles included. Contact is
  // evaluated anew; gravity, mass damping and external forces are left out. The force on a moving
  // pin of a shell includes the inertia of the free particles that M couples to the pin. `loaded`
  // lists, in order, the particles of obstacles on which forces act. The call does not count as a
  // force evaluation in the statistics. Precondition: both lists are empty or come from an earlier
  // call.
  void find_forces_on_all(double time, std::span<const double> y, std::vector<Vec3>& force,
                          std::vector<int>& loaded);
  // Splits the forces at (t, y) by origin, with contact evaluated anew, and resizes the lists of
  // `parts`. The call does not count as a force evaluation in the statistics. Cost: one evaluation
  // of the forces.
  void find_force_parts(double time, std::span<const double> y, ForceParts& parts);
  // The largest stretch l / L - 1 of an edge of a dynamic body, with the present length l and the
  // rest length L. Edges of shells are those between the points of its image. `particle` is a
  // vertex of that edge, or the particle whose image point is one.
  struct LargestStretch {
    double value = 0;
    int particle = 0;
  };
  LargestStretch find_largest_stretch(std::span<const Vec3> position) const;
  double largest_stretch(std::span<const Vec3> position) const {
    return find_largest_stretch(position).value;
  }
  // Returns the largest distance (m) of an image point of a dynamic body from its place at the
  // start. `position` has one entry per dynamic particle (m).
  double largest_displacement(std::span<const Vec3> position) const;

 private:
  Dynamics(const Scene& scene, Statistics& statistics, std::vector<std::unique_ptr<Force>> forces,
           ChosenSearch search);
  // Calls set_time(), then returns the state of the dynamic particles, with held particles in their
  // prescribed positions. The views are valid until y is freed or changed, or until the next call.
  Kinematics kinematics(double time, std::span<const double> y);
  void add_forces(const Kinematics& state, std::span<Vec3> force);
  // Sets `force` to the sum (N) of all forces and contact, without weight and mass damping.
  std::optional<ContactFault> sum_forces(double time, const Kinematics& state,
                                         std::span<Vec3> force);
  ContactFault fault_of_first_not_finite(std::span<const Vec3> vectors) const;
  void add_mass_damping();
  // Sets gravity, friction, mass damping and varying forces to their values at `time`. Costs
  // nothing if none of them varies.
  void set_time(double time);
  void choose_history(double time);
  void accept_anchors(double time, std::span<const double> y);
  // Replaces forces (N) by accelerations (m/s^2), with weight and mass damping added. Accelerations
  // of held particles are zero. Returns true if all values are finite.
  bool divide_by_mass(double time, const Kinematics& state, std::span<Vec3> force);
  // Replaces forces (N) by accelerations (m/s^2), by means of the consistent mass of shells.
  // `force` must include weight and mass damping.
  void solve_for_accelerations(double time, std::span<Vec3> force);
  // Adds the weight and the mass damping (N) to the forces.
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
  // Positions of all particles and poses of the moving obstacles, at the same time.
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
  std::shared_ptr<CreaseHistory> creases_;  // null: no bending yields
  std::shared_ptr<AnchorHistory> anchors_;  // null: no contact is anchored
  bool has_limits_ = false;
  bool pins_move_ = false;
  bool supports_are_left_out_ = false;  // from matrices
  std::vector<int> held_;               // dynamic particles that are pinned
  std::optional<Contact> contact_;
  BlockMatrix stiffness_;
  bool has_damping_ = false;
  BlockMatrix damping_;  // allocated on first use; empty after a joined assembly
  std::vector<Vec3> damping_product_;
  Linearisation linearisation_;
  std::optional<double> load_;
  std::vector<SurfaceMap> image_maps_;  // map_to_image() of the dynamic bodies
  double hardness_ = 1;
  TimeCurve<Vec3> gravity_curve_;
  TimeCurve<double> friction_curve_;
  VaryingNumbers mass_damping_curves_;  // rates of mass damping, one run of particles per body
  bool varies_ = false;
  Vec3 gravity_;                      // gravity at the time of the last set_time() (m/s^2)
  std::vector<double> mass_damping_;  // rate (1/s) of each particle; empty without mass damping
  std::vector<Vec3> coupled_;         // scratch of solve_for_accelerations()
  std::vector<Vec3> position_, velocity_;  // results of expand() for all particles
  std::vector<RigidPose> poses_;           // poses of the moving obstacles
  Placing path_start_, path_end_;          // scratch of path checks
  double step_start_ = std::numeric_limits<double>::infinity();  // start of the present step (s)
  std::vector<double> body_stray_, particle_stray_;              // scratch of path_stray() (m)
};

}  // namespace weft::sim
