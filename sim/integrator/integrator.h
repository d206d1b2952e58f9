// The interface of all methods of time integration, and make_integrator(), which chooses one.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "sim/base/failure.h"
#include "sim/base/state_archive.h"
#include "sim/base/statistics.h"
#include "sim/motion/dynamics.h"

namespace weft::sim {

// A point on a path of equilibria.
struct PathPoint {
  double load_factor = 1;       // factor of the applied loads
  int negative_directions = 0;  // of the tangent stiffness; unstable if > 0
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
  virtual double time() const = 0;       // s, reached so far
  virtual double last_step() const = 0;  // s
  virtual int last_order() const = 0;
  virtual std::span<const double> state() const = 0;  // at time()
  // Writes the state interpolated at `time` (s) within the last step; after a failed step only
  // time() is allowed. With contact, if surfaces might touch on the path to the interpolated state,
  // the linear interpolation of the step replaces it. Returns a failure if surfaces might touch on
  // the path to that state too, with prescribed points at their places at `time`.
  [[nodiscard]] virtual std::optional<Failure> state_at(double time, std::span<double> y) const = 0;
  virtual IntegratorCounts counts() const = 0;
  // Continues from the state `y` at `time`, without the method's history. Until the next step,
  // state_at() allows only `time`.
  virtual void restart(double time, std::span<const double> y) = 0;
  // Writes or reads all data that determine the bits of later steps. Methods whose history another
  // library keeps do nothing and return false.
  [[nodiscard]] virtual bool transfer(StateArchive& /*archive*/) { return false; }
  // Sets a function that one-step methods call between the trials of a step, since a step may take
  // many trials. If it returns a failure, step() fails with it. May be empty.
  using ReasonToStop = std::function<std::optional<Failure>()>;
  void set_reason_to_stop(ReasonToStop reason) { reason_to_stop_ = std::move(reason); }
  // Describes the choices that the method has made by itself so far; empty if it makes none.
  virtual std::string decision() const { return {}; }
  // True if the run has reached an end that the case sets before time.duration, such as the largest
  // load factor of a path.
  virtual bool has_ended() const { return false; }
  // Returns the point of the path at time(), or nothing for methods that do not factorise the
  // tangent stiffness.
  virtual std::optional<PathPoint> path_point() const { return std::nullopt; }

 protected:
  std::optional<Failure> reason_to_stop() const {
    return reason_to_stop_ ? reason_to_stop_() : std::nullopt;
  }

 private:
  ReasonToStop reason_to_stop_;
};

// Returns the failure of a frame at `time` (s) that cannot keep surfaces apart because of `fault`.
Failure frame_failure(const Scene& scene, const ContactFault& fault, double time);

// Returns the integrator of `time.method`, from the table of integrator.cpp (one line per method).
// Both arguments must outlive it.
std::unique_ptr<Integrator> make_integrator(const Scene& scene, Dynamics& dynamics);

}  // namespace weft::sim
