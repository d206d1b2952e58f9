// The interface of forces on particles. One virtual call evaluates a force on all its stencils.
#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "sim/matrix/tiled_matrix.h"

namespace weft::sim {

struct Scene;
struct Instant;
class CreaseHistory;

// Positions (m) and velocities (m/s) of all particles of the dynamic bodies.
struct Kinematics {
  std::span<const Vec3> position;
  std::span<const Vec3> velocity;
};

// The form of the stiffness matrix K. The exact form may be indefinite, for example under
// compression. The semi-definite form leaves out or replaces the terms that can make it indefinite.
enum class Definiteness { exact, semi_definite };

// Matrices to which forces add K = -dF/dx (N/m) and D = -dF/dv (N s/m). K and D may be joined, with
// a time gamma (s): `stiffness` then receives K + D / gamma, and `product` receives D times
// `along`.
struct Derivatives {
  BlockMatrix& stiffness;
  BlockMatrix* damping = nullptr;  // null if K and D are joined
  double inverse_gamma = 0;        // 1 / gamma, 1/s; zero unless joined
  std::span<const Vec3> along = {};
  std::span<Vec3> product = {};

  bool is_joined() const { return damping == nullptr; }
};

// A force (N) on particles, with the point (m) where it acts. By::clamp: a clamp or a sliding
// support exerts it. By::tie: a tie exerts it on the vertex that it ties. By::tied_body: a body
// that is not simulated exerts it through the spring of a tie.
struct OuterForce {
  enum class By { clamp, tied_body, tie };
  By by = By::clamp;
  int body = -1;  // index into Scene::bodies: the clamped, supported or pulling body
  int pin = -1;   // By::clamp: index of the pin in the body's list
  int tie = -1;   // By::tie: Tie::number
  Vec3 place{0, 0, 0}, force{0, 0, 0};
};

class Force {
 public:
  virtual ~Force() = default;
  // Returns the force's name. The trajectory has the force's energy as /series/energy_NAME.
  virtual std::string_view name() const = 0;
  // True for membranes made of triangles or of springs.
  virtual bool is_membrane() const { return false; }
  // True if the force depends on velocities at any time. Only then does it add to D.
  virtual bool has_damping() const = 0;
  // True for drag and applied loads, which exchange energy with the outside of the simulation and
  // store none.
  virtual bool is_external() const { return false; }
  // True if the force is an applied load.
  virtual bool is_load() const { return false; }
  // Sets the factor by which an applied load is multiplied from now on. The factor is 1 before the
  // first call. Other forces ignore it.
  virtual void set_load_factor(double /*factor*/) {}
  // True if the force replaces a constraint, by stiff springs or a barrier. Position errors within
  // the tolerance, or a step that ends deep in the barrier, give such a force much energy.
  virtual bool is_constraint() const { return false; }
  // True if coefficients or moving points of the force vary in time.
  virtual bool varies() const { return false; }
  // Sets coefficients and moving points to their values at `now`, which remain until the next call.
  // If varies(), this must be called before the first evaluation.
  virtual void set_time(const Instant& /*now*/) {}
  // Returns the work of one evaluation of all forces of a scene in which this force is the most
  // expensive. The unit is that of work_of() in sim/motion/work.h. The values come from measured
  // times.
  virtual double evaluation_work() const = 0;
  virtual double energy(const Kinematics& state, int threads) = 0;  // J
  // True if the force attaches to moving points that are not part of the state, such as points of a
  // moving obstacle.
  virtual bool has_moving_points() const { return false; }
  // True if there are states in which no accepted step may end.
  virtual bool has_limits() const { return false; }
  // Returns a particle at which the state is not allowed, or -1.
  virtual int find_beyond_limit(std::span<const Vec3> /*position*/) const { return -1; }
  // Makes `creases` the plastic state of bending. It must outlive the force.
  virtual void use_creases(CreaseHistory& /*creases*/) {}
  // Sets `into`.advanced() of the force's triangles to the creases that follow from a state.
  virtual void advance_creases(const Kinematics& /*state*/, CreaseHistory& /*into*/,
                               int /*threads*/) {}
  // Returns the energy (J) that creases have dissipated up to this state.
  virtual double dissipated(const Kinematics& /*state*/, int /*threads*/) { return 0; }
  // Appends the forces of clamps, sliding supports, seams and ties to `all`.
  virtual void list_outer_forces(const Kinematics& /*state*/, std::vector<OuterForce>& /*all*/) {}
  // Returns the power (W) that the motion of the force's moving points supplies to the simulation.
  virtual double power_of_moving_points(const Kinematics& /*state*/) { return 0; }
  // Returns the part of it that springs supply because their rest length shrinks.
  virtual double power_of_closing_seams(const Kinematics& /*state*/) { return 0; }
  // Adds forces (N) to `force`, which has one entry per dynamic particle.
  virtual void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) = 0;
  // Adds to neighbours[i] the particles that the derivatives couple to particle i. A particle may
  // be added more than once.
  virtual void add_couplings(std::vector<std::vector<int>>& neighbours) const = 0;
  // Prepares add_derivatives() for matrices with this pattern. Must be called before
  // add_derivatives().
  virtual void attach(const BlockPattern& pattern) = 0;
  virtual void add_derivatives(const Kinematics& state, const Derivatives& into,
                               Definiteness definiteness, int threads) = 0;
  // True for the springs of sliding supports.
  virtual bool is_support() const { return false; }
};

// Returns the forces of a scene. A maker in force_arrays.h that returns null adds no force.
std::vector<std::unique_ptr<Force>> make_forces(const Scene& scene);

}  // namespace weft::sim
