// Simulates a case. A program drives the simulation step by step or by periods of time.
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
  // Called after every accepted step, unless the check of its energy fails.
  virtual void after_step(const Simulation& simulation) = 0;
  // Called when the simulation makes a choice by itself. `text` describes the choice.
  virtual void after_decision(const std::string& /*text*/) {}
  // Called at a checkpoint, before the step that follows it. `state` is the result of
  // Simulation::renew().
  virtual void at_checkpoint(const std::string& /*state*/) {}
};

// A simulation of a scene from t = 0. The method chooses its steps. step() computes the next step.
// advance() ends at a given time and interpolates the state at that time. Both take the same steps,
// so a case gives the same bits however it is driven.
//
// The energy after a step is checked against the energy put in (sim/motion/energy_watch.h).
// Explicit methods, cvode and arkode are checked at every eighth step and at steps that reach the
// time of a frame. If wind, loads, prescribed motion or varying gravity can do work, every step is
// checked. Searches for equilibria are checked under some loads only.
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
  // Takes one step of the method. If a checkpoint is due (output.checkpoint_every), calls renew()
  // before, and then at_checkpoint() of the observers. After a failure of Kind::energy, the state
  // is that of the failed step. After any other failure, it is that of the last good step. No step
  // can follow a failure.
  [[nodiscard]] std::optional<Failure> step();
  // Advances by `seconds`. Throws std::invalid_argument unless `seconds` is positive and finite.
  // Fails like step(), and also if no interpolated state keeps surfaces apart; time() is then the
  // end of the last good step. Searches for equilibria stop at time.duration or at has_ended(), and
  // cannot advance beyond.
  [[nodiscard]] std::optional<Failure> advance(double seconds);

  // position() and velocity() return one vector (m, m/s) per particle of a body or obstacle. There
  // is one particle per texel in the order of bsi::Atlas. Texels joined at a seam are one particle.
  // Both throw std::invalid_argument, with the nearest name, for a name that is not in the case.
  std::vector<Vec3> position(std::string_view body) const;
  std::vector<Vec3> velocity(std::string_view body) const;
  // Sets the velocities (m/s) of the free vertices of a body at time(). Pinned vertices keep their
  // velocities. The method restarts without its history, and after_decision() of observers is
  // called. Throws std::invalid_argument for a wrong name or count, for a body whose motion is
  // wholly prescribed, and for numbers that are not finite.
  void set_velocity(std::string_view body, std::span<const Vec3> velocity);

  // save() returns the simulation as bytes. After restore(), another simulation of the same case
  // continues with the same bits, in the same build on the same machine. The table [compute],
  // time.duration and output.frame_times of the two cases may differ. save() throws
  // std::invalid_argument for methods whose history SUNDIALS keeps (cvode, arkode). restore()
  // throws it for bytes of another case or build; the state of the simulation is then undefined.
  // The cost of restore() is that of the constructor.
  std::string save() const;
  void restore(std::string_view bytes);
  // checkpoint() is save() for all methods: those whose history SUNDIALS keeps are saved without
  // it, and restart after restore().
  std::string checkpoint() const;
  // Makes a checkpoint, restores this simulation from it, and returns it. From now on, the
  // simulation has the same bits and counts as any other that is restored from these bytes.
  std::string renew();

  // True if the run has reached an end that the case sets before time.duration.
  bool has_ended() const;

  IntegratorCounts counts() const;
  const Statistics& statistics() const;
  // Returns the energies (J) after the last step.
  const Energies& energies() const;
  // contact_pairs() returns the number of feature pairs in reach, and smallest_gap() their smallest
  // gap (m). Both hold for the last force evaluation of the last step. Pairs without an awake body
  // do not count.
  std::size_t contact_pairs() const;
  std::optional<double> smallest_gap() const;
  // Returns the choices that the method has made by itself so far. The text is empty if it makes no
  // choices.
  std::string decision() const;
  // Returns the device of the contact search and the reason for this device. The text is empty
  // without contact.
  std::string compute() const;
  // Adds an observer, which must outlive the simulation.
  void add_observer(StepObserver& observer);
  // Sets a function that one-step methods call during long steps. step() also calls it after a
  // checkpoint. If it returns a failure, the step ends with that failure.
  void set_reason_to_stop(std::function<std::optional<Failure>()> reason);

  // Returns the scene. All states number particles as the scene does (StateView,
  // sim/motion/dynamics.h).
  const Scene& scene() const;
  Dynamics& dynamics() const;
  // Returns the dynamics of all bodies, sleeping bodies included. Held vertices are those that pins
  // hold at the end of the last step. Particles are numbered as in scene().
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
