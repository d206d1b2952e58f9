// A simulation of a case. The command, pilots, benchmarks and C++ programs all drive this class, so
// all of them compute the same bits.
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

// An observer of every state, such as a recorder or a live view. Observers are called in the order
// in which they were added, and change nothing.
class StepObserver {
 public:
  virtual ~StepObserver() = default;
  // Called after every step that is accepted and judged good.
  virtual void after_step(const Simulation& simulation) = 0;
  // Called, with a description, when the simulation makes a choice by itself.
  virtual void after_decision(const std::string& /*text*/) {}
};

// A simulation of a scene from t = 0. Methods choose their own steps. step() goes to the end of the
// next step, advance() to a time within the last one, where the state is interpolated. Neither
// changes what the other computes: the same case gives the same bits however it is driven.
//
// Steps are checked for energy that nothing put in (sim/motion/energy_watch.h). Explicit steps
// without wind and prescribed motion are checked only at every eighth step, before every frame and
// from time.duration on.
//
// Throws CaseError if the scene cannot be simulated. One thread at a time; any number of
// simulations side by side.
class Simulation {
 public:
  // The scene must outlive it.
  explicit Simulation(const Scene& scene);
  // Owns the scene.
  explicit Simulation(std::unique_ptr<const Scene> scene);
  ~Simulation();
  Simulation(Simulation&&) noexcept;

  // The time (s) of position(), velocity() and state().
  double time() const;
  // Takes one step of the method. After a failure of Kind::energy, the state is that of the step
  // found wrong; after any other failure, that of the last good step. No step can follow a failure.
  [[nodiscard]] std::optional<Failure> step();
  // Advances by `seconds`. Throws std::invalid_argument unless these are positive and finite. Fails
  // as step() does, and if no interpolated state keeps surfaces apart; time() is then that of the
  // last good step. `static` ends at time.duration, or at has_ended(), and cannot advance beyond
  // it.
  [[nodiscard]] std::optional<Failure> advance(double seconds);

  // Positions (m) and velocities (m/s) of the vertices of a body or obstacle, by particle: one per
  // texel in the order of bsi::Atlas, where texels joined at a seam are one. Throw
  // std::invalid_argument, with the nearest name, for a name that is not in the case.
  std::vector<Vec3> position(std::string_view body) const;
  std::vector<Vec3> velocity(std::string_view body) const;
  // Gives the free vertices of a body new velocities at time(); pinned vertices keep theirs. The
  // method restarts here without its history of earlier steps, and observers are told so. Throws
  // std::invalid_argument for a wrong name or count, for a body whose motion is wholly prescribed,
  // and for numbers that are not finite.
  void set_velocity(std::string_view body, std::span<const Vec3> velocity);

  // Save and restore the simulation as bytes. Another simulation of the same case, in the same
  // build on the same machine, continues from them with the same bits. Throw std::invalid_argument
  // for methods whose history SUNDIALS keeps (cvode, arkode), and for bytes of another case or
  // build. After restore() throws, the simulation's state is undefined.
  std::string save() const;
  void restore(std::string_view bytes);

  // True if the run has reached an end that the case sets before time.duration.
  bool has_ended() const;

  IntegratorCounts counts() const;
  const Statistics& statistics() const;
  // Energies after the last step, J.
  const Energies& energies() const;
  // Pairs of features in reach, and their smallest gap (m), in the last force evaluation of the
  // last step. Pairs without an awake body do not count.
  std::size_t contact_pairs() const;
  std::optional<double> smallest_gap() const;
  // Describes the choices that the method has made by itself so far; empty if it makes none.
  std::string decision() const;
  // Describes the device of the contact search and the reason for it; empty without contact.
  std::string compute() const;
  // The observer must outlive the simulation.
  void add_observer(StepObserver& observer);
  // Sets a function that is called during long steps; a failure that it returns ends the step.
  void set_reason_to_stop(std::function<std::optional<Failure>()> reason);

  // The functions below are for callers that know the method; states are arrays as of StateView
  // (sim/motion/dynamics.h).
  const Scene& scene() const;
  Dynamics& dynamics() const;
  // The dynamics of all bodies, also of those that sleep, with the vertices that pins hold at the
  // end of the last step. Particles are numbered as in the scene.
  Dynamics& dynamics_with_pins() const;
  const Integrator& integrator() const;
  std::span<const double> state() const;
  // Writes the state at a time within the last step into `y`.
  [[nodiscard]] std::optional<Failure> state_at(double time, std::span<double> y) const;
  // Summarises a state at a time within the last step. Evaluates contact.
  StateSummary summary_of(double time, std::span<const double> y) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::sim
