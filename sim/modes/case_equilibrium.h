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

// How a state is found.
struct EquilibriumOptions {
  // Takes the shape at t = 0 as it is, under the loads of that time, in equilibrium or not.
  bool start_shape = false;
  // The factor of the loads: of each [[load]], and of gravity with static.scale_gravity. A path of
  // loads (static.loading = "arc_length") is then not followed. Empty: the loads of the case.
  std::optional<double> load_factor;
  std::function<void(double time)> progress;  // called after every step of the search; may be empty
};

// The equilibrium of a case under the loads and with the moving pins of time.duration, whatever its
// time.method. It is searched for as time.method = "static" does, in one step if nothing varies or
// moves in time, and else through the frames of the case. The end of a path of loads counts if the
// case follows one. A start shape that is in balance is taken as it is: a body that nothing holds
// then needs no other equilibrium.
class CaseEquilibrium {
 public:
  // Throws CaseError as build_scene() and check_initial_state() do, and for a pin that takes hold
  // or lets go in time. A tie holds, whatever its break_force.
  CaseEquilibrium(const Case& source, EquilibriumOptions options);
  ~CaseEquilibrium();

  // Searches. After a failure, the state is that of the last good step.
  [[nodiscard]] std::optional<Failure> find();

  const Scene& scene() const { return *scene_; }
  Simulation& simulation() { return simulation_; }
  Dynamics& dynamics() const { return simulation_.dynamics(); }
  double time() const { return time_; }  // s
  // Positions and velocities, which are zero (sim/motion/dynamics.h).
  std::span<const double> state() const { return state_; }
  // Norm of the forces on free particles over that of the loads and of the forces on held ones; 0
  // if there are none.
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
