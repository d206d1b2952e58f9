#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "sim/case/case_text.h"
#include "sim/integrator/integrator_makers.h"
#include "sim/integrator/one_step_integrator.h"
#include "sim/integrator/verlet_steps.h"
#include "sim/motion/spectral_estimate.h"

namespace weft::sim {

namespace {

// Without a given step, the step is a chosen fraction of the longest stable step. It is chosen
// again if it exceeds `no_longer_safe` of the longest stable step. It is also chosen again outside
// the range of `too_short` to `too_long` times the chosen fraction. Otherwise it does not change,
// because every change breaks the symmetry in time that conserves the energy.
constexpr double too_long = 1.1, too_short = 0.7, no_longer_safe = 0.95;
// Relative changes of the tracked frequency between two checks. Above `large_change`, the frequency
// is checked twice as often; below `small_change`, half as often.
constexpr double large_change = 0.02, small_change = 0.005;
// Number of steps between two checks of shown_frequency(), if that is below `slow_share` of the
// highest stable frequency.
constexpr int steps_per_slow_check = 4;
constexpr double slow_share = 0.1;

class VerletIntegrator final : public OneStepIntegrator {
 public:
  VerletIntegrator(const Scene& scene, Dynamics& dynamics)
      : OneStepIntegrator(scene, dynamics),
        needs_velocities_(dynamics.has_damping() || dynamics.contact() != nullptr),
        before_acceleration_(dynamics.particle_count()),
        start_acceleration_(dynamics.particle_count()),
        end_acceleration_(dynamics.particle_count()) {}

  int last_order() const override { return 2; }
  void transfer(StateArchive& archive) override {
    transfer_steps(archive);
    bool is_tracked = tracker_.has_value();
    archive(is_tracked);
    if (is_tracked && !tracker_) tracker_.emplace(dynamics(), time(), state());
    if (is_tracked) tracker_->transfer(archive);
    archive(share_, chosen_step_, decay_, stiff_place_, steps_, next_check_, next_shown_check_,
            steps_per_check_, start_, end_, before_acceleration_, start_acceleration_,
            end_acceleration_);
  }

 private:
  // Refuses a given step that is unstable. Without a given step, chooses its length.
  std::optional<Failure> refusal() override {
    const TimeCase& options = scene().source.time;
    if (options.step) return refuse_unstable(*options.step);
    double rate = 0;
    if (dynamics().has_damping() || dynamics().contact() != nullptr) {
      rate = find_decay();
    }
    if (dynamics().contact() == nullptr) {
      tracker_.emplace(dynamics(), time(), state());
      rate = verlet_rate(tracker_->frequency(), decay_);
    }
    share_ = verlet_share(options.relative_tolerance);
    chosen_step_ = rate > 0 ? share_ * 2 / rate : 1 / options.frames_per_second;
    propose(chosen_step_);
    return std::nullopt;
  }
  std::optional<Failure> refuse_unstable(double step) {
    const SpectralEstimate fastest = estimate_spectrum(dynamics(), time(), state());
    const double limit = 2 / verlet_rate(fastest.frequency, fastest.decay);
    if (step <= limit) return std::nullopt;
    return Failure{Failure::Kind::unstable, time(), fastest.place,
                   "the step of " + number_text(step) +
                       " s is beyond the limit of stability of verlet at t = " +
                       rounded_text(time()) + " s, " + rounded_text(limit) +
                       " s: the motion is fastest at " + scene().describe_particle(fastest.place)};
  }

  // A step h is x1 = x + h (v + h/2 a), a1 = a(x1, v + h a), v1 = v + h/2 (a + a1). Forces that
  // depend on the velocity use its prediction at the end.
  Trouble attempt(double& end, std::span<double> y) override {
    if (!is_fixed() && chosen_step_ < scene().source.time.minimum_step) {
      set_place(tracker_ ? tracker_->place() : stiff_place_);
      return Trouble::unstable;
    }
    if (auto trouble = find_start_acceleration(); trouble != Trouble::none) return trouble;
    const double h = end - time();
    const std::size_t half = y.size() / 2;
    const double *x = state().data(), *v = x + half;
    double *x1 = y.data(), *v1 = x1 + half;
    const double* a = start_acceleration_[0].data();
    for (std::size_t i = 0; i < half; ++i) x1[i] = x[i] + h * (v[i] + h / 2 * a[i]);
    if (needs_velocities_) {
      for (std::size_t i = 0; i < half; ++i) v1[i] = v[i] + h * a[i];
    }
    if (auto fault = dynamics().acceleration(end, y, end_acceleration_)) return trouble_of(*fault);
    const double* a1 = end_acceleration_[0].data();
    for (std::size_t i = 0; i < half; ++i) v1[i] = v[i] + h / 2 * (a[i] + a1[i]);
    end_ = end;
    if (!is_fixed()) {
      follow_limit(h, y);
      propose(chosen_step_);
    }
    return Trouble::none;
  }

  // Finds the acceleration at the start of a step. Reuses the acceleration at the end of the last
  // step if it is known: a step then costs one evaluation of the forces.
  Trouble find_start_acceleration() {
    if (start_ == time()) return Trouble::none;
    if (end_ == time()) {
      before_acceleration_.swap(start_acceleration_);
      start_acceleration_.swap(end_acceleration_);
    } else if (auto fault = dynamics().acceleration(time(), state(), start_acceleration_)) {
      return trouble_of(*fault);
    }
    start_ = time();
    return Trouble::none;
  }

  // Adapts the step to the stiffness: stretched cloth vibrates faster. Does nothing with contact.
  // `y` is the state at the end of the step. A vibration that the tracker misses is found in the
  // motion itself once it has grown.
  void follow_limit(double h, std::span<const double> y) {
    if (!tracker_) return;
    ++steps_;
    const bool is_even = std::abs(h - last_step()) < 1e-6 * h;
    if (is_even && steps_ >= next_shown_check_ && check_shown_frequency(h) > no_longer_safe) {
      tracker_->track_direction_of(end_acceleration_);
      check_tracked_frequency(y);
    } else if (steps_ >= next_check_) {
      check_tracked_frequency(y);
    }
  }

  // Returns shown_frequency() as a fraction of the highest stable frequency. A low frequency is
  // checked less often: an unstable vibration grows by a small factor per step and needs several
  // steps to matter.
  double check_shown_frequency(double h) {
    const double share = verlet_rate(shown_frequency(h), decay_) * chosen_step_ / 2;
    next_shown_check_ = steps_ + (share < slow_share ? steps_per_slow_check : 1);
    return share;
  }

  // Updates the tracked frequency, and the number of steps until the next check from its change.
  void check_tracked_frequency(std::span<const double> y) {
    const double before = tracker_->frequency();
    tracker_->follow(end_, y, end_acceleration_);
    const double now = tracker_->frequency(), change = std::abs(now / before - 1);
    if (change > large_change) steps_per_check_ = std::max(1, steps_per_check_ / 2);
    if (change < small_change)
      steps_per_check_ = std::min(2 * steps_per_check_, most_verlet_steps_per_check);
    next_check_ = steps_ + steps_per_check_;
    keep_share(verlet_rate(now, decay_));
  }

  void keep_share(double rate) {
    if (!(rate > 0)) return;
    const double limit = 2 / rate, share = chosen_step_ / limit;
    if (share > std::min(too_long * share_, no_longer_safe) || share < too_short * share_)
      chosen_step_ = share_ * limit;
  }

  // Returns the frequency (rad/s) from the Rayleigh quotient of the acceleration: a1 - 2 a + a_-1 =
  // -h^2 M^-1 K a. In linear undamped motion, it does not exceed the highest frequency of the
  // bodies. It approaches that frequency once an unstable vibration dominates the motion.
  double shown_frequency(double h) const {
    const VibrationProducts seen = dynamics().mass().vibration(
        before_acceleration_, start_acceleration_, end_acceleration_, dynamics().threads());
    return seen.bent > 0 ? std::sqrt(seen.bent / seen.all) / h : 0;
  }

  void forget() override { start_ = end_ = -1; }
  // After a jump of a curve, the acceleration at the start of the next step differs from the one at
  // the end of the last step. Differences across the jump show no vibration.
  void pass_event(bool jumps) override {
    if (!dynamics().varies()) return;
    if (jumps) {
      forget();
      next_shown_check_ = std::max(next_shown_check_, steps_ + 2);
    }
    if (is_fixed()) return;
    const double rate = find_decay();
    keep_share(tracker_ ? verlet_rate(tracker_->frequency(), decay_) : rate);
    propose(chosen_step_);
  }

  // Sets decay_ and stiff_place_, and returns verlet_rate() of the present frequency and decay_.
  // Until the next corner of a curve, damping is strongest now or at that corner, so decay_ is the
  // larger of these two decays.
  double find_decay() {
    dynamics().begin_step(time());
    SpectralEstimate fastest = estimate_spectrum(dynamics(), time(), state());
    const double end = next_event();
    if (dynamics().varies() && std::isfinite(end)) {
      const SpectralEstimate later = estimate_spectrum(dynamics(), end, state());
      if (later.stiffest() > fastest.stiffest()) fastest.place = later.place;
      fastest.decay = std::max(fastest.decay, later.decay);
    }
    decay_ = fastest.decay;
    stiff_place_ = fastest.place;
    return verlet_rate(fastest.frequency, fastest.decay);
  }

  Trouble trouble_of(const ContactFault& fault) {
    set_fault(fault);
    return sim::trouble_of(fault);
  }

  bool needs_velocities_;  // true if forces may depend on velocities

  double share_ = 0;        // chosen fraction of the longest stable step
  double chosen_step_ = 0;  // length (s) of chosen steps
  double decay_ = 0;        // fastest decay (1/s), from find_decay()
  int stiff_place_ = -1;    // particle that moves most in the fastest motion, from find_decay()
  std::optional<FrequencyTracker> tracker_;
  std::int64_t steps_ = 0, next_check_ = 1, next_shown_check_ = 0;
  int steps_per_check_ = 1;

  // Times (s) of start_acceleration_ and end_acceleration_; -1: unknown.
  double start_ = -1, end_ = -1;
  // Accelerations (m/s^2) at three successive times: the start of the last step, and both ends of
  // the present one.
  std::vector<Vec3> before_acceleration_, start_acceleration_, end_acceleration_;
};

}  // namespace

std::unique_ptr<Integrator> make_verlet_integrator(const Scene& scene, Dynamics& dynamics) {
  return std::make_unique<VerletIntegrator>(scene, dynamics);
}

}  // namespace weft::sim
