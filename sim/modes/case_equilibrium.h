// The state of a case about which its modes are computed.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sim/simulation/simulation.h"

namespace weft::sim {

struct Case;

// Throws CaseError, placed at the first group of particles, if the case has any.
void refuse_particles(const Case& source);

// Options of CaseEquilibrium.
struct EquilibriumOptions {
  // Uses the shape at t = 0 under the loads of that time, without a search for an equilibrium.
  bool start_shape = false;
  // Factor of each [[load]], and of gravity with static.scale_gravity. If empty, the loads are
  // those of the case. If set, no path of loads (static.loading = "arc_length") is followed.
  std::optional<double> load_factor;
  std::function<void(double time)> progress;  // called after every step of the search; may be empty
};

// The equilibrium of a case at time.duration, under the loads and with the moving pins of that
// time, for any time.method. The method of the search is time.method = "static". If the case
// follows a path of loads, the equilibrium is the end of the path. Otherwise the search steps
// through the frames of the case, or has a single frame if nothing varies or moves in time. A start
// shape in balance is then accepted without a step, because a body that nothing holds has no
// isolated equilibrium.
class CaseEquilibrium {
 public:
  // Throws CaseError as build_scene() and check_initial_state() do, and for a pin that takes hold
  // or lets go in time. Ties do not break, whatever their break_force.
  CaseEquilibrium(const Case& source, EquilibriumOptions options);
  ~CaseEquilibrium();

  // Searches for the equilibrium. After a failure, state() is the state after the last successful
  // step.
  [[nodiscard]] std::optional<Failure> find();

  const Scene& scene() const { return *scene_; }
  Simulation& simulation() { return simulation_; }
  Dynamics& dynamics() const { return simulation_.dynamics(); }
  double time() const { return time_; }  // s
  // Returns positions, then velocities (StateView). The velocities are zero.
  std::span<const double> state() const { return state_; }
  // Returns the norm of the forces on free particles, divided by the norm of the loads and of the
  // forces on held particles. The result is 0 if no net force acts on free particles. It is
  // infinite if the forces cannot be evaluated, or if net forces act without loads and held
  // particles. Cost: one evaluation of the forces.
  double imbalance();

 private:
  void apply_load_factor();
  std::vector<double> start_at(double time) const;
  bool starts_in_balance(double time, std::span<const double> y);

  EquilibriumOptions options_;
  std::unique_ptr<const Scene> scene_;
  Simulation simulation_;
  double time_ = 0;
  std::vector<double> state_;
};

}  // namespace weft::sim
