// The equations of motion: y = (x, v), x' = v, M v' = forces.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sim/contact/contact.h"
#include "sim/forces/block_matrix.h"
#include "sim/forces/force.h"
#include "sim/scene/scene.h"
#include "sim/statistics.h"

namespace weft::sim {

// A state as the integrator holds it: positions (m), then velocities (m/s) of the dynamic
// particles. Where pinned ones are is known from the time alone: forces never take it from here.
// Moving ones are carried along with their prescribed rates, so that a method's error control
// sees what they do; those at rest unchanged.
struct StateView {
  std::span<const Vec3> position;
  std::span<const Vec3> velocity;
  // Of an array of 6 * particles doubles.
  static StateView of(std::span<const double> y);
};

struct Energies {
  double kinetic = 0;                                   // J
  double gravitational = 0;                             // J, zero at the origin
  double contact = 0;                                   // J
  std::vector<std::pair<std::string, double>> elastic;  // by force, J
  double total() const;
};

// Evaluates forces and their derivatives at states that the caller holds. Of its own it keeps what
// was evaluated last: the matrices K and D, the pairs in contact, and the surfaces they were found
// between.
class Dynamics {
 public:
  Dynamics(const Scene& scene, Statistics& statistics);

  const Scene& scene() const { return scene_; }
  int particle_count() const { return scene_.dynamic_particles; }
  int threads() const { return threads_; }
  Statistics& statistics() { return statistics_; }
  std::size_t state_size() const { return 6 * static_cast<std::size_t>(scene_.dynamic_particles); }
  std::vector<double> initial_state() const;

  // y' at (t, y). Returns why it has none: two surfaces without a gap, or a value that is not
  // finite.
  [[nodiscard]] std::optional<ContactFault> rate(double time, std::span<const double> y,
                                                 std::span<double> rate);

  // The second half of it, m/s^2 by particle.
  [[nodiscard]] std::optional<ContactFault> acceleration(double time, std::span<const double> y,
                                                         std::span<Vec3> acceleration);

  // Stores K = -dF/dx and D = -dF/dv of all forces but contact, whose own matrices are always those
  // of the last rate(). Mass damping is part of D.
  void assemble(double time, std::span<const double> y,
                Definiteness definiteness = Definiteness::exact);
  // The same for one gamma and right side, in half of the memory: K + D / gamma as the stiffness,
  // no damping, and D times `residual` (m, by particle), minus the b_x of the system to be solved:
  // with it gamma K b_x = gamma stiffness b_x + damping_product.
  void assemble_joined(double time, std::span<const double> y, Definiteness definiteness,
                       double gamma, std::span<const Vec3> residual);
  // Of the last assembly; empty where that was not a joined one, or there is no D.
  std::span<const Vec3> damping_product() const { return damping_product_; }
  // From now on, forces are those of particles at rest, and gravity is this part of the scene's:
  // for equilibria.
  void set_load(double load) { load_ = load; }
  // From now on, membranes and springs have this part of their stiffness: on the way to equilibria.
  void set_hardness(double hardness) { hardness_ = hardness; }
  const BlockMatrix& stiffness() const { return stiffness_; }
  // Only where there is some, and it is not joined to the stiffness.
  const BlockMatrix& damping() const { return damping_; }
  bool has_damping() const { return has_damping_ && damping_product_.empty(); }
  const Contact* contact() const { return contact_ ? &*contact_ : nullptr; }
  Contact* contact() { return contact_ ? &*contact_ : nullptr; }

  // Does a pin of a dynamic body move?
  bool pins_move() const { return pins_move_; }
  // The step to come starts at this time: where a prescribed velocity jumps, later times have the
  // one before the jump, which the step ends at. Without, all times have the one after.
  void begin_step(double time) { step_start_ = time; }
  double step_start() const { return step_start_; }
  // Puts moving pins where they are after any jump.
  void place_pins(double time, std::span<double> y) const;
  // y += factor rate(time), of moving pins alone.
  void advance_pins(double time, double factor, std::span<double> y) const;
  // Is every pair of surfaces certain to keep apart from `start` at one time to `end` at a later
  // one (positions of all particles), free particles on straight paths and prescribed ones on their
  // own? With contact.
  [[nodiscard]] std::optional<ContactFault> check_path(double start_time,
                                                       std::span<const Vec3> start, double end_time,
                                                       std::span<const Vec3> end);

  // Positions and velocities of all particles, prescribed ones put where they belong. Both lists
  // must be empty or come from an earlier call: obstacles at rest are written once, however many
  // they are.
  void expand(double time, std::span<const double> y, std::vector<Vec3>& position,
              std::vector<Vec3>& velocity) const;
  std::vector<std::string> force_names() const;
  // Evaluates contact anew where it is on.
  Energies energies(double time, std::span<const double> y);
  // The same with the contact energy of the last rate(), which a step leaves within its tolerance
  // of y.
  Energies energies_at_last_rate(double time, std::span<const double> y);
  // Power (W) of drag on the free particles: positive where wind drives them. Without prescribed
  // motion it costs one evaluation of drag alone.
  double drag_power(double time, std::span<const double> y);
  bool has_drag() const { return drag_ != nullptr; }
  // Forces (N) on all particles, prescribed ones and obstacles included: contact, which is
  // evaluated anew, and the forces of the bodies, but neither gravity, mass damping nor drag. Not
  // counted in the statistics' force evaluations.
  void find_forces_on_all(double time, std::span<const double> y, std::vector<Vec3>& force);
  // Largest l / L - 1 over the edges of all bodies.
  double largest_stretch(std::span<const Vec3> position) const;

 private:
  // Of the dynamic particles, held ones where they belong; valid as long as y and until the next.
  Kinematics kinematics(double time, std::span<const double> y);
  void add_forces(const Kinematics& state, std::span<Vec3> force);
  // Makes forces accelerations, zero where particles are held; whether they are finite.
  bool divide_by_mass(const Kinematics& state, std::span<Vec3> force) const;
  void assemble(double time, std::span<const double> y, Definiteness definiteness,
                const Derivatives& into);
  bool is_before_jump(double time) const { return time > step_start_; }
  template <class Visit>
  void visit_moving_pins(const Visit& visit) const;
  PathStray path_stray(double from, double to);

  const Scene& scene_;
  Statistics& statistics_;
  int threads_ = 1;
  std::vector<std::unique_ptr<Force>> forces_;
  Force* drag_ = nullptr;  // of these; null without
  bool pins_move_ = false;
  std::vector<int> held_;  // dynamic particles that are pinned
  std::optional<Contact> contact_;
  BlockMatrix stiffness_;
  bool has_damping_ = false;
  BlockMatrix damping_;  // made when first wanted; never together with the product
  std::vector<Vec3> damping_product_;
  std::optional<double> load_;
  double hardness_ = 1;
  std::vector<double> mass_damping_;       // 1/s, by particle; empty where there is none
  std::vector<Vec3> position_, velocity_;  // of all, where the state does not do
  double step_start_ = std::numeric_limits<double>::infinity();  // s
  std::vector<double> body_stray_, particle_stray_;              // m
};

}  // namespace weft::sim
