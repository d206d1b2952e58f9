#include <algorithm>
#include <cmath>
#include <vector>

#include "sim/case/case_text.h"
#include "sim/integrator/integrator_makers.h"
#include "sim/integrator/one_step_integrator.h"
#include "sim/integrator/spectral_estimate.h"

namespace weft::sim {

namespace {

// Without a given step: at the default relative_tolerance, a quarter of the longest stable step,
// which keeps the energy of an undamped sheet within one percent; its error goes as the square of
// the step, so steps go as the root of the tolerance, up to half of the longest.
constexpr double step_at_default = 0.25, longest_share = 0.5, default_tolerance = 1e-4;

class VerletIntegrator final : public OneStepIntegrator {
 public:
  VerletIntegrator(const Scene& scene, Dynamics& dynamics)
      : OneStepIntegrator(scene, dynamics),
        start_rate_(dynamics.state_size()),
        end_rate_(dynamics.state_size()) {}

  int last_order() const override { return 2; }

 private:
  // Oscillations grow where h omega > 2, damped ones where h d > 2.
  std::optional<std::string> refusal() override {
    const SpectralEstimate fastest = estimate_spectrum(dynamics(), 0, state());
    const double limit = 2 / fastest.stiffest();
    const TimeCase& options = scene().source.time;
    if (!options.step) {
      const double share =
          step_at_default * std::sqrt(options.relative_tolerance / default_tolerance);
      chosen_step_ = limit * std::min(share, longest_share);
      propose(chosen_step_);
      return std::nullopt;
    }
    if (*options.step <= limit) return std::nullopt;
    return "the step of " + number_text(*options.step) +
           " s is beyond the limit of stability of verlet at t = 0 s, " + number_text(limit) +
           " s: the motion is fastest at " + scene().describe_particle(fastest.place);
  }

  // v+ = v + h/2 a, x1 = x + h v+, a1 = a(x1, v+ + h/2 a), v1 = v+ + h/2 a1: forces that depend on
  // the velocity take the one that is expected at the end.
  Trouble attempt(double& end, std::span<double> y) override {
    if (auto trouble = find_start_rate(y); trouble != Trouble::none) return trouble;
    const double h = end - time();
    const std::size_t half = y.size() / 2;
    const std::span<double> x = y.first(half), v = y.last(half);
    const double* a = start_rate_.data() + half;
    for (std::size_t i = 0; i < half; ++i) {
      x[i] += h * (v[i] + h / 2 * a[i]);
      v[i] += h * a[i];
    }
    if (auto fault = dynamics().rate(end, y, end_rate_)) return trouble_of(*fault);
    const double* a1 = end_rate_.data() + half;
    for (std::size_t i = 0; i < half; ++i) v[i] += h / 2 * (a1[i] - a[i]);
    end_ = end;
    if (!is_fixed()) propose(chosen_step_);
    return Trouble::none;
  }

  // That of the end of the step before, so that a step costs one evaluation.
  Trouble find_start_rate(std::span<const double> y) {
    if (start_ == time()) return Trouble::none;
    if (end_ == time()) {
      start_rate_.swap(end_rate_);
    } else if (auto fault = dynamics().rate(time(), y, start_rate_)) {
      return trouble_of(*fault);
    }
    start_ = time();
    return Trouble::none;
  }

  Trouble trouble_of(const ContactFault& fault) {
    set_fault(fault);
    return fault.kind == ContactFault::Kind::not_finite ? Trouble::not_finite : Trouble::surfaces;
  }

  double chosen_step_ = 0;        // s, without a given one
  double start_ = -1, end_ = -1;  // s: when the rates are of
  std::vector<double> start_rate_, end_rate_;
};

}  // namespace

std::unique_ptr<Integrator> make_verlet_integrator(const Scene& scene, Dynamics& dynamics) {
  return std::make_unique<VerletIntegrator>(scene, dynamics);
}

}  // namespace weft::sim
