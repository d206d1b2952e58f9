// A case in motion: what the command, pilots, benchmarks and C++ programs all drive, so that all of
// them compute the same bits.
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
class Dynamics;
class Integrator;
class Simulation;

// Whoever wants to see every state: a recorder, a live view. Observers are called in the order in
// which they were added, and change nothing.
class StepObserver {
 public:
  virtual ~StepObserver() = default;
  // After every step of the method that is found good.
  virtual void after_step(const Simulation& simulation) = 0;
  // When the simulation decides something by itself, in words.
  virtual void after_decision(const std::string& /*text*/) {}
};

// Starts at t = 0. Methods choose their own steps: step() goes to the end of the next one, and
// advance() to a time within the last one, where the state is interpolated. Neither changes what
// the other computes: the same case gives the same bits however it is driven. Every step is watched
// for energy that nothing put in (sim/motion/energy_watch.h).
//
// Throws CaseError where the scene cannot be simulated. One thread at a time; any number of
// simulations side by side.
class Simulation {
 public:
  // The scene must outlive it.
  explicit Simulation(const Scene& scene);
  // Owns the scene.
  explicit Simulation(std::unique_ptr<const Scene> scene);
  ~Simulation();
  Simulation(Simulation&&) noexcept;

  // The time (s) that position(), velocity() and state() are of.
  double time() const;
  // Takes one step of the method. After a failure of Kind::energy the state is that of the step
  // found wrong, after any other that of the last good step; no step can follow.
  [[nodiscard]] std::optional<Failure> step();
  // Goes `seconds` (> 0) on. Fails as step() does, and where no interpolated state keeps surfaces
  // apart; time() is then that of the last good step. `static` ends at time.duration: beyond it
  // there is nothing to go to.
  [[nodiscard]] std::optional<Failure> advance(double seconds);

  // Vertices of a body or obstacle by particle (one a texel, but for seams, in the order of
  // bsi::Atlas), m and m/s. Throw std::invalid_argument, with the nearest name, for a name that is
  // not in the case.
  std::vector<Vec3> position(std::string_view body) const;
  std::vector<Vec3> velocity(std::string_view body) const;
  // Gives the free vertices of a body new velocities at time(), which stay to be computed at pinned
  // ones. The method starts anew from here, without its history of earlier steps, and tells
  // observers so. Throws std::invalid_argument for a name or a count that is not the case's, for
  // what is wholly prescribed, and for numbers that are not finite.
  void set_velocity(std::string_view body, std::span<const Vec3> velocity);

  // Bytes from which another simulation of the same case, in a process of the same build on the
  // same machine, goes on with the same bits. Throw std::invalid_argument for methods whose history
  // SUNDIALS keeps (cvode, arkode), and for bytes of another case or of another build; a simulation
  // whose restore() has thrown has no defined state.
  std::string save() const;
  void restore(std::string_view bytes);

  IntegratorCounts counts() const;
  const Statistics& statistics() const;
  // Energies after the last step, J.
  const Energies& energies() const;
  // Pairs of features in reach, and the smallest of their gaps (m), in the last evaluation of the
  // forces in the last step.
  std::size_t contact_pairs() const;
  std::optional<double> smallest_gap() const;
  // Describes what the method has decided by itself so far; empty where there is nothing to decide.
  std::string decision() const;
  // Describes what the contact search runs on, and why; empty without contact.
  std::string compute() const;
  // The observer must outlive the simulation.
  void add_observer(StepObserver& observer);
  // A function that is asked during long steps: a failure that it returns ends the step.
  void set_reason_to_stop(std::function<std::optional<Failure>()> reason);

  // The rest is for those who know the method: states are arrays of StateView
  // (sim/motion/dynamics.h).
  const Scene& scene() const;
  Dynamics& dynamics() const;
  const Integrator& integrator() const;
  std::span<const double> state() const;
  // Writes the state at a time within the last step.
  [[nodiscard]] std::optional<Failure> state_at(double time, std::span<double> y) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::sim
