#include "sim/integrator/one_step_integrator.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "sim/case/time_methods.h"

namespace weft::sim {

namespace {

// Largest number of successful steps of one length that a step of twice the length may require. A
// failed iteration costs more than several successful ones. A failed step with a given number of
// corrections costs no more than another one.
constexpr int longest_patience = 16, longest_patience_by_number = 2;

// After a veto, the bound of chosen steps grows by this factor per accepted step. The error test
// alone would allow growth at once, while the surfaces are still close.
constexpr double growth_after_veto = 1.2;

// More than `most_vetoes_per_window` vetoes in a window end the run. On a grid, more than
// `many_vetoes` vetoes end it too if the window advances by less than two grid steps or, if motions
// limit steps, by less than twice the mean length that they allowed.
constexpr int most_vetoes_per_window = 100, many_vetoes = 8;

// True if it is a state or path that is refused, whatever its error.
bool is_veto(StepTrouble trouble) {
  return trouble == StepTrouble::surfaces || trouble == StepTrouble::overstretched;
}

// Returns what limits a step after a trial that failed by `trouble`. After a failed error test, the
// error of the accepted trial tells more.
std::optional<StepLimit> limit_of(StepTrouble trouble) {
  if (is_veto(trouble)) return StepLimit::surfaces;
  if (trouble == StepTrouble::error_too_large) return std::nullopt;
  return StepLimit::convergence;
}

// Length (s) of the first step that is tried under error control.
constexpr double first_trial = 1.0 / 60;

}  // namespace

OneStepIntegrator::OneStepIntegrator(const Scene& scene, Dynamics& dynamics)
    : scene_(scene),
      dynamics_(dynamics),
      motion_limits_(scene, dynamics),
      step_(traits_of(scene.source.time.method).finds_equilibria()
                ? std::optional(1 / scene.source.time.frames_per_second)
                : scene.source.time.step),
      accepted_(dynamics),
      short_steps_(scene.source.time),
      size_(step_.value_or(first_trial)) {}

double OneStepIntegrator::grid_time() const {
  const double time = static_cast<double>(completed_steps_ + 1) * *step_;
  // A search for equilibria ends exactly at the duration.
  if (!traits_of(scene_.source.time.method).finds_equilibria()) return time;
  return std::min(static_cast<double>(completed_steps_ + 1) / scene_.source.time.frames_per_second,
                  scene_.source.time.duration);
}

std::optional<double> OneStepIntegrator::latest_end(double wanted) {
  const auto end = motion_limits_.latest_end(time(), wanted, state());
  if (!end) stopped_ = motion_limits_.failure(time());
  return end;
}

// Returns the end of the next trial (s), or nothing if motions allow no step.
std::optional<double> OneStepIntegrator::next_time() {
  const double wanted = wanted_time();
  if (!motion_limits_.apply()) return wanted;
  const auto end = latest_end(wanted);
  if (end) allowed_ = *end - time();
  return end;
}

// Returns the end (s) of the next trial if no motion limits it.
double OneStepIntegrator::wanted_time() const {
  if (!is_fixed()) {
    const auto longest = scene_.source.time.maximum_step;
    const double size = std::min(size_, longest_after_veto_);
    return time() + (longest ? std::min(size, *longest) : size);
  }
  const double grid = grid_time();
  // A trial extends to the next grid time if less than half its own length would remain.
  return time() + 1.5 * size_ > grid ? grid : time() + size_;
}

std::optional<Failure> OneStepIntegrator::step() {
  fault_.reset();
  place_ = -1;
  stopped_.reset();
  if (counts_.steps == 0) {
    if (auto reason = refusal()) return reason;
  }
  if (motion_limits_.apply()) accepted_.match_supports();
  std::optional<StepLimit> failed;  // cause of the last failed trial
  for (;;) {
    dynamics_.begin_step(time());
    const auto next = next_time();
    if (!next) return stopped_;
    double end = *next;
    const std::span<double> y = accepted_.begin_trial();
    limit_ = StepLimit::given;
    Trouble trouble = attempt(end, y);
    if (trouble == Trouble::none) trouble = check_path(end, y);
    if (trouble == Trouble::none) {
      if (failed) limit_ = *failed;
      accept(end);
      return too_many_vetoes();
    }
    if (stopped_) return stopped_;
    count(trouble);
    failed = limit_of(trouble);
    // After a failed error test, the method has already proposed the next length.
    if (trouble != Trouble::error_too_large) size_ = (end - time()) / 2;
    if (is_veto(trouble)) longest_after_veto_ = size_;
    successes_ = 0;
    patience_ = std::min(2 * patience_, scene_.source.time.newton > 0 ? longest_patience_by_number
                                                                      : longest_patience);
    if (size_ < shortest_step()) return final_failure(trouble);
    if (should_stop()) return stopped_;
  }
}

Failure OneStepIntegrator::final_failure(Trouble trouble) const {
  // Explicit steps are unstable beyond a frequency, and equilibria press surfaces by right.
  const bool has_other_cause =
      trouble == Trouble::unstable || traits_of(scene_.source.time.method).finds_equilibria();
  const std::optional<ContactFault> pressed =
      has_other_cause ? std::nullopt : pressed_surfaces(dynamics_, time(), state());
  return shortest_step_failure(trouble_with(pressed, trouble),
                               {.time = time(),
                                .fault = pressed ? pressed : fault_,
                                .particle = place_,
                                .may_be_short = short_steps_.are_allowed()},
                               scene_);
}

OneStepIntegrator::Trouble OneStepIntegrator::check_path(double time, std::span<const double> y) {
  auto fault = dynamics_.check_limits(time, y);
  if (!fault && dynamics_.contact() == nullptr) return Trouble::none;
  if (!fault) {
    accepted_.place_trial(time, y);
    if (checks_its_own_path()) return Trouble::none;
    fault = accepted_.check_trial_path(time);
  }
  if (!fault) return Trouble::none;
  fault_ = fault;
  return trouble_of(*fault);
}

void OneStepIntegrator::accept(double time) {
  accepted_.accept(time);
  short_steps_.note(last_step());
  ++counts_.steps;
  counts_.census.add(last_step(), limit_);
  if (motion_limits_.apply()) {
    window_allowed_ += allowed_;
    accepted_.place_pins();
    // Short steps may end near an event that has been passed.
    if (motion_limits_.has_event_at(time) && !motion_limits_.has_event_at(accepted_.start_time()))
      pass_event(motion_limits_.jumps_at(time));
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
    case Trouble::overstretched:
      ++counts_.vetoed_steps;
      veto_window_.add_veto(fault_);
      break;
    default:
      ++counts_.convergence_failures;
  }
}

std::optional<Failure> OneStepIntegrator::too_many_vetoes() {
  const auto recent = veto_window_.add_step();
  if (!recent) return std::nullopt;
  const double advance = time() - window_start_;
  const double enough =
      motion_limits_.apply() ? 2 * window_allowed_ / VetoWindow::length : 2 * step_.value_or(0);
  window_allowed_ = 0;
  window_start_ = time();
  const bool is_too_slow = is_fixed() && *recent > many_vetoes && advance < enough;
  if (!is_too_slow && *recent <= most_vetoes_per_window) return std::nullopt;
  return veto_window_.failure(
      *recent, time(), "time.step is too long or contact.stiffness too small for this impact",
      scene_);
}

void OneStepIntegrator::restart(double time, std::span<const double> y) {
  accepted_.restart(time, y);
  if (step_) {
    // The times of the grid do not change. The next one is more than a minimum step away.
    const double share = (time + scene_.source.time.minimum_step) / *step_;
    completed_steps_ = static_cast<std::int64_t>(std::floor(share));
  }
  ++counts_.restarts;
  forget();
}

void OneStepIntegrator::transfer_steps(StateArchive& archive) {
  accepted_.transfer(archive);
  veto_window_.transfer(archive);
  short_steps_.transfer(archive);
  archive(size_, longest_after_veto_, completed_steps_, successes_, patience_, counts_,
          window_start_, window_allowed_);
}

std::optional<Failure> OneStepIntegrator::state_at(double time, std::span<double> y) const {
  assert(time >= accepted_.start_time() && time <= accepted_.time() && y.size() == state().size());
  if (!accepted_.has_start()) {
    assert(time == accepted_.time());
    std::copy(state().begin(), state().end(), y.begin());
    return std::nullopt;
  }
  accepted_.interpolate(time, y, last_order());
  // The end of a step was checked with the step, whose path need not be straight.
  if (time == this->time()) return std::nullopt;
  return accepted_.settle(time, y);
}

}  // namespace weft::sim
