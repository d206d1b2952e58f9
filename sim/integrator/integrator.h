// The interface of all methods of time integration, and make_integrator(), which chooses one.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sim/base/failure.h"
#include "sim/base/state_archive.h"
#include "sim/base/statistics.h"
#include "sim/motion/dynamics.h"

namespace weft::sim {

// A point on a path of equilibria.
struct PathPoint {
  double load_factor = 1;  // factor of the applied loads
  // Number of negative eigenvalues of the tangent stiffness; the equilibrium is unstable if > 0.
  int negative_directions = 0;
};

// Contact of methods that find their contacts themselves, in the last step.
struct OwnContact {
  std::int64_t pairs = 0;              // contacts in reach
  std::optional<double> smallest_gap;  // m; empty without contacts
};

// Integrates from t = 0 and the scene's initial state. With contact on, every step is checked along
// its path. A step that might let surfaces touch or cross is not accepted.
class Integrator {
 public:
  Integrator() = default;
  virtual ~Integrator() = default;
  Integrator(const Integrator&) = delete;
  Integrator& operator=(const Integrator&) = delete;

  // Takes one step. On failure the state remains that of the last accepted step.
  [[nodiscard]] virtual std::optional<Failure> step() = 0;
  virtual double time() const = 0;       // time reached (s)
  virtual double last_step() const = 0;  // length of the last step (s)
  virtual int last_order() const = 0;
  virtual std::span<const double> state() const = 0;  // positions and velocities at time()
  // Writes the state interpolated at `time` (s) within the last step; after a failed step only
  // time() is allowed. With contact, the straight path from the start of the step to this state is
  // checked. If surfaces might touch on it, the linear interpolation between the ends of the step
  // replaces the state. Returns a failure if surfaces might cross on the path to the replacement.
  [[nodiscard]] virtual std::optional<Failure> state_at(double time, std::span<double> y) const = 0;
  virtual IntegratorCounts counts() const = 0;
  // Continues from the state `y` at `time`, without the method's history. Until the next step,
  // state_at() allows only `time`.
  virtual void restart(double time, std::span<const double> y) = 0;
  // Writes or reads all data that determine the bits of later steps. Methods whose history SUNDIALS
  // keeps (TimeMethodTraits::has_hidden_history()) write their state without it, and restart after
  // reading.
  virtual void transfer(StateArchive& archive) = 0;
  // A function that one-step methods call between the trials of a step, within long trials and
  // within the linear solves of implicit stages, because a step may take long. If it returns a
  // failure, step() fails with that failure. An empty function never stops a step.
  using ReasonToStop = std::function<std::optional<Failure>()>;
  void set_reason_to_stop(ReasonToStop reason) { reason_to_stop_ = std::move(reason); }
  // Tells the method that the energy has risen unfed. It may solve the equations of the next steps
  // more exactly.
  virtual void tighten() {}
  // Describes the kind of steps that the method has chosen by itself. The text is empty if the
  // method has one kind of steps.
  virtual std::string decision() const { return {}; }
  // True if the run has reached an end that the case sets before time.duration, such as the largest
  // load factor of a path.
  virtual bool has_ended() const { return false; }
  // Returns the contact of the last step, or null for methods whose contact Dynamics evaluates.
  virtual const OwnContact* own_contact() const { return nullptr; }
  // Returns the angular velocities (rad/s) of all spheres at `time` (s), within the last step, for
  // methods that keep them apart from the state.
  virtual std::vector<Vec3> spins_at(double /*time*/) const { return {}; }
  // Returns the kinetic energy (J) of these spins.
  virtual double spin_energy_at(double /*time*/) const { return 0; }
  // Returns the point at time() on the path of equilibria. Returns nothing for methods that do not
  // factorise the tangent stiffness.
  virtual std::optional<PathPoint> path_point() const { return std::nullopt; }

 protected:
  std::optional<Failure> reason_to_stop() const {
    return reason_to_stop_ ? reason_to_stop_() : std::nullopt;
  }

 private:
  ReasonToStop reason_to_stop_;
};

// Returns the failure of a frame at `time` (s) in which surfaces cannot be kept apart because of
// `fault`.
Failure frame_failure(const Scene& scene, const ContactFault& fault, double time);

// Returns the integrator of `time.method`, from the table in integrator.cpp. `scene` and `dynamics`
// must outlive the integrator.
std::unique_ptr<Integrator> make_integrator(const Scene& scene, Dynamics& dynamics);

}  // namespace weft::sim
