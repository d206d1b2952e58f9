// The last accepted step, and the trial of the next one.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sim/base/failure.h"
#include "sim/base/state_archive.h"
#include "sim/motion/dynamics.h"

namespace weft::sim {

// Holds the state (6 * dynamic particles doubles) at the end of the last accepted step and, if
// has_start(), at its start. With contact, also holds the positions of all particles at these
// times, for path checks.
class AcceptedStep {
 public:
  // Begins at t = 0 with the scene's initial state and no step. `dynamics` must outlive the object.
  explicit AcceptedStep(Dynamics& dynamics);

  double time() const { return time_; }              // end of the step (s)
  double start_time() const { return start_time_; }  // start of the step (s)
  std::span<const double> state() const { return state_; }
  std::span<const double> start_state() const { return other_state_; }
  // Returns the positions of all particles at time(), as Dynamics::expand() writes them; empty
  // without contact.
  const std::vector<Vec3>& positions() const { return positions_; }
  // True if start_state() is known. False before the first step, after restart(), and from
  // begin_trial() to accept().
  bool has_start() const { return has_start_; }

  // Begins a trial of the next step. Returns the storage of start_state(), which is to receive the
  // end state of the trial.
  std::span<double> begin_trial();
  // Computes the positions of all particles in the trial state `y` at `time` (s). Does nothing
  // without contact.
  void place_trial(double time, std::span<const double> y);
  // Returns Dynamics::gap_change_since_evaluation() of the positions of place_trial(), for the step
  // from positions().
  double trial_gap_change(double closing_factor) const {
    return dynamics_.gap_change_since_evaluation(positions_, trial_positions_, closing_factor);
  }
  // Checks the path from positions() to the positions of place_trial() by Dynamics::check_path().
  // Precondition: contact is on.
  std::optional<ContactFault> check_trial_path(double time);
  // Makes the trial the last accepted step. Precondition: begin_trial() and, with contact,
  // place_trial() have been called.
  void accept(double time);

  // Writes the positions and velocities of moving pins at time() to state().
  void place_pins() { dynamics_.place_pins(time_, state_); }
  // Applies Dynamics::match_supports() to state(). To be called at the start of a step: state()
  // also ends the last step, within which frames are interpolated.
  void match_supports() { dynamics_.match_supports(time_, state_); }
  // Continues from the state `y` at `time` (s), without a last step.
  void restart(double time, std::span<const double> y);

  // Writes the state at `time` (s) within the step to `y`, of a method of this order. Positions
  // follow the cubic that matches positions and velocities at both ends of the step. Velocities are
  // its derivative or, for order 1, change evenly: a step of backward Euler moves by h v_1, so that
  // the derivative passes v_1 by a quarter of the change. Precondition: has_start().
  void interpolate(double time, std::span<double> y, int order) const;
  // Applies settle_frame() to `y`, the state interpolated at `time` within the step. Precondition:
  // has_start().
  [[nodiscard]] std::optional<Failure> settle(double time, std::span<double> y) const;

  void transfer(StateArchive& archive) {
    archive(time_, start_time_, state_, other_state_, has_start_, positions_, start_positions_);
    dynamics_.transfer_history(archive);
  }

 private:
  Dynamics& dynamics_;
  double time_ = 0, start_time_ = 0;
  bool has_start_ = false;
  // other_state_ holds the state at the start of the step. From begin_trial() to accept(), it holds
  // the state of the trial instead.
  std::vector<double> state_, other_state_;
  std::vector<Vec3> positions_, start_positions_;
  // Positions and velocities of the trial. settle() uses them as scratch.
  mutable std::vector<Vec3> trial_positions_, scratch_velocity_;
};

}  // namespace weft::sim
