// Simulates a case. The command, pilots, benchmarks and C++ programs all drive this class, so all
// of them compute the same bits.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/failure.h"
#include "sim/base/statistics.h"
#include "sim/base/vectors.h"

namespace weft::sim {

struct Scene;
struct Energies;
struct StateSummary;
class Dynamics;
class Integrator;
class Simulation;

// An observer of every step, such as a recorder or a live view. Observers are called in the order
// in which they were added. They must not change the simulation.
class StepObserver {
 public:
  virtual ~StepObserver() = default;
  // Called after every step that is accepted and whose energy is not found wrong.
  virtual void after_step(const Simulation& simulation) = 0;
  // Called with a description when the simulation makes a choice by itself.
  virtual void after_decision(const std::string& /*text*/) {}
};

// A simulation of a scene from t = 0. The method chooses its steps. step() computes the next step.
// advance() ends at a given time and interpolates the state there. Neither changes the steps, so a
// case gives the same bits however it is driven.
//
// Steps are checked for energy that nothing has put in (sim/motion/energy_watch.h). Explicit
// methods are checked at every eighth step and before every frame. If wind, prescribed motion or
// varying gravity can do work, every step is checked.
//
// The constructors throw CaseError if the scene cannot be simulated. One thread may use a
// simulation at a time. Different simulations may run side by side.
class Simulation {
 public:
  // The scene must outlive the simulation.
  explicit Simulation(const Scene& scene);
  // Takes ownership of the scene.
  explicit Simulation(std::unique_ptr<const Scene> scene);
  ~Simulation();
  Simulation(Simulation&&) noexcept;

  // Returns the time (s) of position(), velocity() and state().
  double time() const;
  // Takes one step of the method. A failure of Kind::energy leaves the state of the step found
  // wrong. Any other failure leaves the state of the last good step. No step can follow a failure.
  [[nodiscard]] std::optional<Failure> step();
  // Advances by `seconds`. Throws std::invalid_argument unless `seconds` is positive and finite.
  // Fails like step(), and also if no interpolated state keeps surfaces apart; time() is then the
  // end of the last good step. `static` stops at time.duration or at has_ended(), and cannot
  // advance beyond.
  [[nodiscard]] std::optional<Failure> advance(double seconds);

  // Return the positions (m) and velocities (m/s) of a body or obstacle, by particle. There is one
  // particle per texel in the order of bsi::Atlas; texels joined at a seam are one particle. Throw
  // std::invalid_argument, with the nearest name, for a name that is not in the case.
  std::vector<Vec3> position(std::string_view body) const;
  std::vector<Vec3> velocity(std::string_view body) const;
  // Sets the velocities (m/s) of the free vertices of a body at time(). Pinned vertices keep
  // theirs. The method restarts without its history, and observers are told. Throws
  // std::invalid_argument for a wrong name or count, for a body whose motion is wholly prescribed,
  // and for numbers that are not finite.
  void set_velocity(std::string_view body, std::span<const Vec3> velocity);

  // Save and restore the simulation as bytes. Another simulation of the same case, in the same
  // build on the same machine, continues from these with the same bits. Throw std::invalid_argument
  // for methods whose history SUNDIALS keeps (cvode, arkode). restore() also throws it for bytes of
  // another case or build; the simulation's state is then undefined.
  std::string save() const;
  void restore(std::string_view bytes);

  // True if the run has reached an end that the case sets before time.duration.
  bool has_ended() const;

  IntegratorCounts counts() const;
  const Statistics& statistics() const;
  // Returns the energies (J) after the last step.
  const Energies& energies() const;
  // Return the number of feature pairs in reach, and their smallest gap (m), in the last force
  // evaluation of the last step. Pairs without an awake body do not count.
  std::size_t contact_pairs() const;
  std::optional<double> smallest_gap() const;
  // Returns the choices that the method has made by itself so far; empty if it makes none.
  std::string decision() const;
  // Returns the device of the contact search and the reason for it; empty without contact.
  std::string compute() const;
  // Adds an observer, which must outlive the simulation.
  void add_observer(StepObserver& observer);
  // Sets a function that is called during long steps. If it returns a failure, the step ends with
  // it.
  void set_reason_to_stop(std::function<std::optional<Failure>()> reason);

  // The functions below are for callers that know the method. States are arrays as described at
  // StateView (sim/motion/dynamics.h).
  const Scene& scene() const;
  Dynamics& dynamics() const;
  // Returns the dynamics of all bodies, even of sleeping ones, with the vertices that pins hold at
  // the end of the last step. Particles are numbered as in the scene.
  Dynamics& dynamics_with_pins() const;
  const Integrator& integrator() const;
  std::span<const double> state() const;
  // Writes the state at `time` (s), within the last step, to `y`. Fails if that state does not keep
  // surfaces apart.
  [[nodiscard]] std::optional<Failure> state_at(double time, std::span<double> y) const;
  // Summarises the state `y` at `time` (s), within the last step. Evaluates contact.
  StateSummary summary_of(double time, std::span<const double> y) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::sim
