#include "sim/integrator/one_step_integrator.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "sim/case/case_text.h"

namespace weft::sim {

OneStepIntegrator::OneStepIntegrator(const Scene& scene, Dynamics& dynamics)
    : scene_(scene),
      dynamics_(dynamics),
      step_(scene.source.time.method == TimeMethod::static_loads
                ? std::optional(1 / scene.source.time.frames_per_second)
                : scene.source.time.step),
      size_(step_.value_or(1 / scene.source.time.frames_per_second)),
      state_(dynamics.initial_state()),
      previous_state_(state_),
      trial_(state_) {
  dynamics.expand(0, state_, position_, scratch_velocity_);
  previous_position_ = trial_position_ = interpolated_ = position_;
}

double OneStepIntegrator::grid_time() const {
  const double time = static_cast<double>(completed_steps_ + 1) * *step_;
  // There is no load beyond the whole.
  if (scene_.source.time.method != TimeMethod::static_loads) return time;
  return std::min(static_cast<double>(completed_steps_ + 1) / scene_.source.time.frames_per_second,
                  scene_.source.time.duration);
}

// The end of the next try. Times of the grid are exact multiples, however they are reached.
double OneStepIntegrator::next_time() const {
  if (!is_fixed()) {
    const auto longest = scene_.source.time.maximum_step;
    return time_ + (longest ? std::min(size_, *longest) : size_);
  }
  const double grid = grid_time();
  // What would be left of the step must not be a sliver.
  return time_ + 1.5 * size_ > grid ? grid : time_ + size_;
}

std::optional<std::string> OneStepIntegrator::step() {
  fault_.reset();
  place_ = -1;
  if (counts_.steps == 0) {
    if (auto reason = refusal()) return reason;
  }
  for (;;) {
    double end = next_time();
    std::copy(state_.begin(), state_.end(), trial_.begin());
    Trouble trouble = attempt(end, trial_);
    if (trouble == Trouble::none) trouble = check_path(end);
    if (trouble == Trouble::none) {
      accept(end);
      return std::nullopt;
    }
    count(trouble);
    // An error test has proposed a length.
    if (trouble != Trouble::error_too_large) size_ = (end - time_) / 2;
    if (size_ < scene_.source.time.minimum_step) return failure(trouble);
  }
}

OneStepIntegrator::Trouble OneStepIntegrator::check_path(double time) {
  dynamics_.expand(time, trial_, trial_position_, scratch_velocity_);
  if (dynamics_.contact() == nullptr || checks_its_own_path()) return Trouble::none;
  const auto fault = dynamics_.contact()->check_path(position_, trial_position_);
  if (!fault) return Trouble::none;
  fault_ = fault;
  return fault->kind == ContactFault::Kind::not_finite ? Trouble::not_finite : Trouble::surfaces;
}

void OneStepIntegrator::accept(double time) {
  previous_time_ = time_;
  time_ = time;
  previous_state_.swap(state_);
  state_.swap(trial_);
  previous_position_.swap(position_);
  position_.swap(trial_position_);
  ++counts_.steps;
  if (!is_fixed()) return;
  if (time == grid_time()) ++completed_steps_;
  size_ = std::min(2 * size_, *step_);
}

void OneStepIntegrator::count(Trouble trouble) {
  switch (trouble) {
    case Trouble::error_too_large:
      ++counts_.error_test_failures;
      break;
    case Trouble::surfaces:
      ++counts_.vetoed_steps;
      break;
    default:
      ++counts_.convergence_failures;
  }
}

std::string OneStepIntegrator::failure(Trouble trouble) const {
  const std::string shortest =
      number_text(scene_.source.time.minimum_step) + " s (time.minimum_step)";
  const std::string at = " at t = " + number_text(time_) + " s";
  std::string where;
  if (fault_) {
    where = ": " + fault_->describe(scene_);
  } else if (place_ >= 0) {
    where = ": the error is largest at " + scene_.describe_particle(place_);
  }
  switch (trouble) {
    case Trouble::surfaces:
      return "no step down to " + shortest + " keeps the surfaces apart" + at + where;
    case Trouble::error_too_large:
      return "no step down to " + shortest + " meets the error tolerance" + at + where;
    case Trouble::not_finite:
      return "the forces cannot be evaluated with any step down to " + shortest + at + where;
    default:
      return "the Newton iteration does not converge with any step down to " + shortest + at +
             where;
  }
}

void OneStepIntegrator::state_at(double time, std::span<double> y) const {
  assert(time >= previous_time_ && time <= time_ && y.size() == state_.size());
  const double h = time_ - previous_time_;
  if (h == 0) {
    std::copy(state_.begin(), state_.end(), y.begin());
    return;
  }
  const double s = (time - previous_time_) / h;
  const std::size_t half = y.size() / 2;
  for (std::size_t i = 0; i < half; ++i) {
    const double x0 = previous_state_[i], x1 = state_[i];
    const double v0 = previous_state_[half + i], v1 = state_[half + i];
    y[i] = (1 - s) * (1 - s) * ((1 + 2 * s) * x0 + s * h * v0) +
           s * s * ((3 - 2 * s) * x1 - (1 - s) * h * v1);
    y[half + i] =
        6 * s * (1 - s) * (x1 - x0) / h + (1 - s) * (1 - 3 * s) * v0 + s * (3 * s - 2) * v1;
  }
  if (dynamics_.contact() == nullptr) return;
  dynamics_.expand(time, y, interpolated_, scratch_velocity_);
  if (!dynamics_.contact()->check_path(previous_position_, interpolated_)) return;
  for (std::size_t i = 0; i < y.size(); ++i) y[i] = (1 - s) * previous_state_[i] + s * state_[i];
}

}  // namespace weft::sim
