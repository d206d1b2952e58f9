#include "sim/integrator/accepted_step.h"

#include <algorithm>

#include "sim/integrator/settled_frame.h"

namespace weft::sim {

AcceptedStep::AcceptedStep(Dynamics& dynamics)
    : dynamics_(dynamics), state_(dynamics.initial_state()), other_state_(state_) {
  place_trial(0, state_);
  positions_ = start_positions_ = trial_positions_;
}

std::span<double> AcceptedStep::begin_trial() {
  has_start_ = false;
  return other_state_;
}

void AcceptedStep::place_trial(double time, std::span<const double> y) {
  if (dynamics_.contact() == nullptr) return;
  dynamics_.expand(time, y, trial_positions_, scratch_velocity_);
}

std::optional<ContactFault> AcceptedStep::check_trial_path(double time) {
  return dynamics_.check_path(time_, positions_, time, trial_positions_);
}

void AcceptedStep::accept(double time) {
  start_time_ = time_;
  time_ = time;
  state_.swap(other_state_);
  start_positions_.swap(positions_);
  positions_.swap(trial_positions_);
  has_start_ = true;
  dynamics_.accept_history(time_, state_);
}

void AcceptedStep::restart(double time, std::span<const double> y) {
  time_ = start_time_ = time;
  has_start_ = false;
  std::copy(y.begin(), y.end(), state_.begin());
  place_pins();
  place_trial(time, state_);
  positions_.swap(trial_positions_);
  dynamics_.restart_history(time_, state_);
}

void AcceptedStep::interpolate(double time, std::span<double> y, int order) const {
  const double h = time_ - start_time_;
  const double s = (time - start_time_) / h;
  const std::size_t half = y.size() / 2;
  for (std::size_t i = 0; i < half; ++i) {
    const double x0 = other_state_[i], x1 = state_[i];
    const double v0 = other_state_[half + i], v1 = state_[half + i];
    y[i] = (1 - s) * (1 - s) * ((1 + 2 * s) * x0 + s * h * v0) +
           s * s * ((3 - 2 * s) * x1 - (1 - s) * h * v1);
    y[half + i] = order == 1 ? (1 - s) * v0 + s * v1
                             : 6 * s * (1 - s) * (x1 - x0) / h + (1 - s) * (1 - 3 * s) * v0 +
                                   s * (3 * s - 2) * v1;
  }
}

std::optional<Failure> AcceptedStep::settle(double time, std::span<double> y) const {
  const double part = (time - start_time_) / (time_ - start_time_);
  return settle_frame(dynamics_, time, part, {other_state_, state_, start_positions_, start_time_},
                      y, trial_positions_, scratch_velocity_);
}

}  // namespace weft::sim
