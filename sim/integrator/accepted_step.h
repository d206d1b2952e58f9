// The last accepted step, and the trial of the next one.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sim/base/failure.h"
#include "sim/base/state_archive.h"
#include "sim/motion/dynamics.h"

namespace weft::sim {

// States (6 * particles) at both ends of the last accepted step. With contact, positions of all
// particles go with them, between which paths are checked.
class AcceptedStep {
 public:
  // Begins at t = 0 with the initial state of the scene, without a step. `dynamics` must outlive
  // it.
  explicit AcceptedStep(Dynamics& dynamics);

  double time() const { return time_; }              // s, of the end
  double start_time() const { return start_time_; }  // s
  std::span<const double> state() const { return state_; }
  std::span<const double> start_state() const { return other_state_; }
  // All particles at time(); empty without contact.
  const std::vector<Vec3>& positions() const { return positions_; }
  // False before the first step, after restart() and from begin_trial() to accept(): the state at
  // the start is then unknown.
  bool has_start() const { return has_start_; }

  // Begins a try of the next step. Returns the room for its end, which is that of the start.
  std::span<double> begin_trial();
  // Finds the positions of a trial state `y`. Nothing to do without contact.
  void place_trial(double time, std::span<const double> y);
  // Checks the straight path from positions() to those of the trial. Precondition: contact is on.
  std::optional<ContactFault> check_trial_path(double time);
  // Takes the trial as the last accepted step. Precondition: begin_trial() and place_trial().
  void accept(double time);

  // Puts the state of time() in order at prescribed particles.
  void place_pins() { dynamics_.place_pins(time_, state_); }
  // Replaces the state and the time, and forgets the step.
  void restart(double time, std::span<const double> y);

  // Judges `y`, interpolated at `time` within the step, by settle_frame(). Precondition:
  // has_start().
  [[nodiscard]] std::optional<Failure> settle(double time, std::span<double> y) const;

  void transfer(StateArchive& archive) {
    archive(time_, start_time_, state_, other_state_, has_start_, positions_, start_positions_);
  }

 private:
  Dynamics& dynamics_;
  double time_ = 0, start_time_ = 0;
  bool has_start_ = false;
  // The other state is that at the start and, from begin_trial() on, the end of the trial.
  std::vector<double> state_, other_state_;
  std::vector<Vec3> positions_, start_positions_;
  mutable std::vector<Vec3> trial_positions_, scratch_velocity_;  // scratch between steps
};

}  // namespace weft::sim
