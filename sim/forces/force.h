// The interface of every force: an array of stencils, with one virtual call per array.
#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "sim/matrix/block_matrix.h"

namespace weft::sim {

struct Scene;
struct Instant;
class CreaseHistory;

// Positions and velocities of every particle of the dynamic bodies (m, m/s).
struct Kinematics {
  std::span<const Vec3> position;
  std::span<const Vec3> velocity;
};

// The form of derivatives. Exact ones may have directions of negative stiffness, for example under
// compression. The semi-definite form leaves out terms that cause these, which long fixed steps may
// require. It is exact where nothing is compressed or bent out of its plane.
enum class Definiteness { exact, semi_definite };

// Targets to which forces add K = -dF/dx (N/m) and D = -dF/dv (N s/m). Either K and D have one
// matrix each, or they are joined for one gamma: `stiffness` receives K + D / gamma, and `product`
// receives D along.
struct Derivatives {
  BlockMatrix& stiffness;
  BlockMatrix* damping = nullptr;  // null: joined
  double inverse_gamma = 0;        // 1/s; used only if joined, like the next two
  std::span<const Vec3> along = {};
  std::span<Vec3> product = {};

  bool is_joined() const { return damping == nullptr; }
};

// A force (N) that a clamp, a sliding support or a tie exerts on the simulated particles, at a
// place (m).
struct OuterForce {
  enum class By { clamp, tied_body, tie };
  By by = By::clamp;
  int body = -1;  // index into Scene::bodies: the held body; for By::tied_body the body that pulls
  int pin = -1;   // of a clamp or support, in the list of its body
  int tie = -1;   // for By::tie: number of the tie
  Vec3 place{0, 0, 0}, force{0, 0, 0};
};

class Force {
 public:
  virtual ~Force() = default;
  // Returns NAME of the energy of the force in the trajectory: /series/energy_NAME.
  virtual std::string_view name() const = 0;
  // True if the force resists stretching of the surface.
  virtual bool is_membrane() const { return false; }
  // True if the force depends on velocities. It then adds to D.
  virtual bool has_damping() const = 0;
  // True if the force exchanges energy with the outside of the simulation, for example with air.
  virtual bool is_external() const { return false; }
  // True if the force is an applied load, which analyses of load paths and of buckling scale.
  virtual bool is_load() const { return false; }
  // Multiplies an applied load by `factor` from now on; 1 before the first call.
  virtual void set_load_factor(double /*factor*/) {}
  // True if the force consists of stiff springs that replace a constraint. Position errors within
  // the tolerance give such springs much energy, which never becomes motion.
  virtual bool is_constraint() const { return false; }
  // True if coefficients of the force vary in time.
  virtual bool varies() const { return false; }
  // Sets varying coefficients to their values at `now`, for all evaluations until the next call. If
  // varies(), must be called before the first evaluation.
  virtual void set_time(const Instant& /*now*/) {}
  // Returns the cost of one evaluation of all forces if this is the most expensive of them, in the
  // unit of sim/motion/work.h. The constants come from measured times.
  virtual double evaluation_work() const = 0;
  virtual double energy(const Kinematics& state, int threads) = 0;  // J
  // True if the force has moving points outside the state, such as those to which vertices are
  // tied.
  virtual bool has_moving_points() const { return false; }
  // True if there are states in which no accepted step may end.
  virtual bool has_limits() const { return false; }
  // Returns a particle at which the state is not allowed, or -1.
  virtual int find_beyond_limit(std::span<const Vec3> /*position*/) const { return -1; }
  // From now on the plastic state of bending is that of `creases`, which must outlive the force.
  virtual void use_creases(CreaseHistory& /*creases*/) {}
  // Sets `into`.advanced() of its triangles to the creases that follow from a state.
  virtual void advance_creases(const Kinematics& /*state*/, CreaseHistory& /*into*/,
                               int /*threads*/) {}
  // Returns the energy (J) that creases have dissipated up to this state.
  virtual double dissipated(const Kinematics& /*state*/, int /*threads*/) { return 0; }
  // Appends the forces that clamps, supports and ties exert on particles.
  virtual void list_outer_forces(const Kinematics& /*state*/, std::vector<OuterForce>& /*all*/) {}
  // Returns the power (W) that moving points put into the force's energy.
  virtual double power_of_moving_points(const Kinematics& /*state*/) { return 0; }
  // Adds forces (N) to `force`, which has one entry per dynamic particle.
  virtual void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) = 0;
  // Adds to neighbours[i] the particles that the derivatives couple to particle i.
  virtual void add_couplings(std::vector<std::vector<int>>& neighbours) const = 0;
  // Must be called once before add_derivatives(), with the pattern of the matrices.
  virtual void attach(const BlockPattern& pattern) = 0;
  virtual void add_derivatives(const Kinematics& state, const Derivatives& into,
                               Definiteness definiteness, int threads) = 0;
};

// Returns every force that the scene needs. The table in force.cpp has one line per force. Arrays
// that would be empty are left out.
std::vector<std::unique_ptr<Force>> make_forces(const Scene& scene);

}  // namespace weft::sim
