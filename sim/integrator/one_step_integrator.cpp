#include "sim/integrator/one_step_integrator.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "sim/case/case_text.h"
#include "sim/case/time_methods.h"
#include "sim/integrator/settled_frame.h"

namespace weft::sim {

namespace {

// Largest number of steps of one length before twice the length is tried again. A failed step costs
// more than several successful ones.
constexpr int longest_patience = 16;

// Largest growth per accepted step after surfaces stood in the way of a step of chosen length. The
// error test would double the step at once, while the surfaces are still there.
constexpr double growth_after_veto = 1.2;

// Vetoes are counted over `veto_window` accepted steps; more than `most_vetoes` of them end the
// run. With steps of given length, more than `many_vetoes` end it, too, if the window has advanced
// by less than two steps. Where motions limit steps, these are two mean steps within the limits.
constexpr int veto_window = 200;
constexpr int most_vetoes = 100, many_vetoes = 8;

}  // namespace

OneStepIntegrator::OneStepIntegrator(const Scene& scene, Dynamics& dynamics)
    : scene_(scene),
      dynamics_(dynamics),
      motion_limits_(scene, dynamics),
      step_(traits_of(scene.source.time.method).finds_equilibria()
                ? std::optional(1 / scene.source.time.frames_per_second)
                : scene.source.time.step),
      size_(step_.value_or(1 / scene.source.time.frames_per_second)),
      state_(dynamics.initial_state()),
      other_state_(state_) {
  if (dynamics.contact() == nullptr) return;
  dynamics.expand(0, state_, position_, scratch_velocity_);
  previous_position_ = trial_position_ = interpolated_ = position_;
}

double OneStepIntegrator::grid_time() const {
  const double time = static_cast<double>(completed_steps_ + 1) * *step_;
  // The load ends at the whole, and the time at the duration.
  if (!traits_of(scene_.source.time.method).finds_equilibria()) return time;
  return std::min(static_cast<double>(completed_steps_ + 1) / scene_.source.time.frames_per_second,
                  scene_.source.time.duration);
}

std::optional<double> OneStepIntegrator::latest_end(double wanted) {
  const auto end = motion_limits_.latest_end(time_, wanted, state_);
  if (!end) stopped_ = motion_limits_.failure(time_);
  return end;
}

// Returns the end of the next try (s); nothing where motions leave no room for a step.
std::optional<double> OneStepIntegrator::next_time() {
  const double wanted = wanted_time();
  if (!motion_limits_.apply()) return wanted;
  const auto end = latest_end(wanted);
  if (end) allowed_ = *end - time_;
  return end;
}

// Times of the grid are exact multiples, however they are reached.
double OneStepIntegrator::wanted_time() const {
  if (!is_fixed()) {
    const auto longest = scene_.source.time.maximum_step;
    const double size = std::min(size_, longest_after_veto_);
    return time_ + (longest ? std::min(size, *longest) : size);
  }
  const double grid = grid_time();
  // A try goes all the way to the next time of the grid if it would leave less than half a step.
  return time_ + 1.5 * size_ > grid ? grid : time_ + size_;
}

std::optional<Failure> OneStepIntegrator::step() {
  fault_.reset();
  place_ = -1;
  stopped_.reset();
  if (counts_.steps == 0) {
    if (auto reason = refusal()) return reason;
  }
  for (;;) {
    dynamics_.begin_step(time_);
    const auto next = next_time();
    if (!next) return stopped_;
    double end = *next;
    has_previous_ = false;
    Trouble trouble = attempt(end, other_state_);
    if (trouble == Trouble::none) trouble = check_path(end);
    if (trouble == Trouble::none) {
      accept(end);
      return too_many_vetoes();
    }
    if (stopped_) return stopped_;
    count(trouble);
    // After a failed error test, the method has already proposed the next length.
    if (trouble != Trouble::error_too_large) size_ = (end - time_) / 2;
    if (trouble == Trouble::surfaces) longest_after_veto_ = size_;
    successes_ = 0;
    patience_ = std::min(2 * patience_, longest_patience);
    if (size_ < scene_.source.time.minimum_step) return failure(trouble);
    if (should_stop()) return stopped_;
  }
}

OneStepIntegrator::Trouble OneStepIntegrator::check_path(double time) {
  if (dynamics_.contact() == nullptr) return Trouble::none;
  dynamics_.expand(time, other_state_, trial_position_, scratch_velocity_);
  if (checks_its_own_path()) return Trouble::none;
  const auto fault = dynamics_.check_path(time_, position_, time, trial_position_);
  if (!fault) return Trouble::none;
  fault_ = fault;
  return fault->kind == ContactFault::Kind::not_finite ? Trouble::not_finite : Trouble::surfaces;
}

void OneStepIntegrator::accept(double time) {
  previous_time_ = time_;
  time_ = time;
  state_.swap(other_state_);
  has_previous_ = true;
  previous_position_.swap(position_);
  position_.swap(trial_position_);
  ++counts_.steps;
  if (motion_limits_.apply()) {
    window_allowed_ += allowed_;
    dynamics_.place_pins(time, state_);
    if (motion_limits_.has_event_at(time)) pass_event(motion_limits_.jumps_at(time));
  }
  longest_after_veto_ *= growth_after_veto;
  if (!is_fixed()) return;
  if (time == grid_time()) ++completed_steps_;
  if (++successes_ < patience_) return;
  successes_ = 0;
  if (size_ == *step_) patience_ = 1;
  size_ = std::min(2 * size_, *step_);
}

void OneStepIntegrator::count(Trouble trouble) {
  switch (trouble) {
    case Trouble::error_too_large:
      ++counts_.error_test_failures;
      break;
    case Trouble::surfaces:
      ++counts_.vetoed_steps;
      last_veto_ = fault_;
      break;
    default:
      ++counts_.convergence_failures;
  }
}

// A healthy run hardly ever cuts a step because of contact. One that keeps doing so advances ever
// more slowly and never ends. The message names the last fault, although this step found a way past
// it.
std::optional<Failure> OneStepIntegrator::too_many_vetoes() {
  if (counts_.steps % veto_window != 0) return std::nullopt;
  const std::int64_t recent = counts_.vetoed_steps - vetoes_before_window_;
  const double advance = time_ - window_start_;
  const double enough =
      motion_limits_.apply() ? 2 * window_allowed_ / veto_window : 2 * step_.value_or(0);
  window_allowed_ = 0;
  vetoes_before_window_ = counts_.vetoed_steps;
  window_start_ = time_;
  const bool creeps = is_fixed() && recent > many_vetoes && advance < enough;
  if (!creeps && recent <= most_vetoes) return std::nullopt;
  return Failure{
      Failure::Kind::too_many_cuts, time_, last_veto_ ? last_veto_->nodes[0] : -1,
      number_text(static_cast<double>(recent)) + " steps had to be cut in the last " +
          number_text(veto_window) + " to keep surfaces apart at t = " + rounded_text(time_) +
          " s" + (last_veto_ ? ": " + last_veto_->describe(scene_) : "") +
          " (time.step is too long or contact.stiffness too small for this impact, or a prescribed "
          "motion leaves no room)"};
}

Failure OneStepIntegrator::failure(Trouble trouble) const {
  struct Words {
    Failure::Kind kind;
    const char *before, *after;  // the length of the shortest step
  };
  const auto words = [&]() -> Words {
    switch (trouble) {
      case Trouble::surfaces:
        return {Failure::Kind::surfaces, "no step down to ", " keeps the surfaces apart"};
      case Trouble::error_too_large:
        return {Failure::Kind::error_tolerance, "no step down to ", " meets the error tolerance"};
      case Trouble::unstable:
        return {Failure::Kind::unstable, "no step down to ", " is stable"};
      case Trouble::not_finite:
        return {Failure::Kind::not_finite, "the forces cannot be evaluated with any step down to ",
                ""};
      default:
        return {Failure::Kind::newton,
                "the Newton iteration does not converge with any step down to ", ""};
    }
  }();
  int particle = place_;
  std::string where;
  if (fault_) {
    particle = fault_->nodes[0];
    where = ": " + fault_->describe(scene_);
  } else if (place_ >= 0) {
    where =
        trouble == Trouble::unstable ? ": the motion is fastest at " : ": the error is largest at ";
    where += scene_.describe_particle(place_);
  }
  return {words.kind, time_, particle,
          words.before + number_text(scene_.source.time.minimum_step) + " s (time.minimum_step)" +
              words.after + " at t = " + rounded_text(time_) + " s" + where};
}

void OneStepIntegrator::restart(double time, std::span<const double> y) {
  time_ = previous_time_ = time;
  std::copy(y.begin(), y.end(), state_.begin());
  dynamics_.place_pins(time, state_);
  has_previous_ = false;
  if (step_) {
    // The times of the grid stay: the next one is the first that is worth a step.
    const double share = (time + scene_.source.time.minimum_step) / *step_;
    completed_steps_ = static_cast<std::int64_t>(std::floor(share));
  }
  if (dynamics_.contact() != nullptr) dynamics_.expand(time, state_, position_, scratch_velocity_);
  ++counts_.restarts;
  forget();
}

void OneStepIntegrator::transfer_steps(StateArchive& archive) {
  archive(time_, previous_time_, size_, longest_after_veto_, completed_steps_, successes_,
          patience_, state_, other_state_, has_previous_, position_, previous_position_, counts_,
          last_veto_, vetoes_before_window_, window_start_, window_allowed_);
}

std::optional<Failure> OneStepIntegrator::state_at(double time, std::span<double> y) const {
  assert(time >= previous_time_ && time <= time_ && y.size() == state_.size());
  const double h = time_ - previous_time_;
  if (!has_previous_) {
    assert(time == time_);
    std::copy(state_.begin(), state_.end(), y.begin());
    return std::nullopt;
  }
  const double s = (time - previous_time_) / h;
  const std::size_t half = y.size() / 2;
  for (std::size_t i = 0; i < half; ++i) {
    const double x0 = other_state_[i], x1 = state_[i];
    const double v0 = other_state_[half + i], v1 = state_[half + i];
    y[i] = (1 - s) * (1 - s) * ((1 + 2 * s) * x0 + s * h * v0) +
           s * s * ((3 - 2 * s) * x1 - (1 - s) * h * v1);
    y[half + i] =
        6 * s * (1 - s) * (x1 - x0) / h + (1 - s) * (1 - 3 * s) * v0 + s * (3 * s - 2) * v1;
  }
  return settle_frame(dynamics_, time, s,
                      {other_state_, state_, previous_position_, previous_time_}, y, interpolated_,
                      scratch_velocity_);
}

}  // namespace weft::sim
