#include <algorithm>
#include <cmath>

#include "sim/integrator/integrator_makers.h"
#include "sim/integrator/stage_integrator.h"
#include "sim/motion/tolerances.h"

namespace weft::sim {

namespace {

class EulerIntegrator final : public StageIntegrator {
 public:
  EulerIntegrator(const Scene& scene, Dynamics& dynamics) : StageIntegrator(scene, dynamics) {
    if (is_fixed()) return;
    rate_.resize(dynamics.state_size());
    tested_rate_.resize(dynamics.state_size());
    weight_.resize(dynamics.state_size());
    error_.resize(dynamics.state_size());
  }

  int last_order() const override { return 1; }
  void transfer(StateArchive& archive) override {
    take_accepted_rate();
    archive(event_time_, rate_);
    StageIntegrator::transfer(archive);
  }

 private:
  Trouble attempt(double& end, std::span<double> y) override {
    take_accepted_rate();
    const double h = end - time();
    Trouble trouble = solve_stage(end, h, y);
    if (trouble != Trouble::none || is_fixed()) return trouble;
    trouble = test_error(h, y);
    if (trouble == Trouble::none) tested_end_ = end;
    return trouble;
  }

  // Estimates the local error, h^2 y'' / 2, from the slopes of this step and the last one. In the
  // first step, after a restart and after an event, the slope at the start of the step replaces
  // that of the last step. Otherwise a long step at rest before the event would hide the change of
  // the slope.
  Trouble test_error(double h, std::span<const double> y) {
    const bool begins_anew = last_step() == 0 || event_time_ == time();
    if (begins_anew) {
      set_fault(dynamics().rate(time(), state(), rate_));
      if (fault()) return trouble_of_fault();
    }
    if (!error_weights(scene(), state(), weight_)) return Trouble::not_finite;
    const double factor = h * h / (h + (begins_anew ? 0 : last_step()));
    double sum = 0;
    for (std::size_t i = 0; i < y.size(); ++i) {
      error_[i] = factor * ((y[i] - state()[i]) / h - rate_[i]);
      sum += error_[i] * error_[i] * weight_[i] * weight_[i];
    }
    const double size = std::sqrt(sum / static_cast<double>(y.size()));
    propose(h * std::clamp(0.9 / std::sqrt(std::max(size, 1e-10)), 0.1, 2.0));
    if (!(size <= 1)) {
      set_place(worst_particle(error_, weight_));
      return Trouble::error_too_large;
    }
    for (std::size_t i = 0; i < y.size(); ++i) {
      tested_rate_[i] = (y[i] - state()[i]) / h;
      error_[i] *= weight_[i];
    }
    set_error_limit(largest_error_part(dynamics(), error_));
    return Trouble::none;
  }
  // A trial that passes the error test may still be refused for its path. Its slope is then not
  // that of the last step.
  void take_accepted_rate() {
    if (tested_end_ == time()) rate_.swap(tested_rate_);
    tested_end_ = -1;
  }
  void pass_event(bool) override { event_time_ = time(); }
  void forget() override {
    tested_end_ = -1;
    event_time_ = time();
    StageIntegrator::forget();
  }

  double event_time_ = -1;  // time of the last event or restart (s)
  // Slope of the last step. test_error() may replace it by the slope at the start of the present
  // step.
  std::vector<double> rate_;
  // Slope of the last trial that passed the error test, and its end (s); -1: none, or it is taken.
  std::vector<double> tested_rate_;
  double tested_end_ = -1;
  std::vector<double> weight_, error_;  // empty with a fixed step
};

}  // namespace

std::unique_ptr<Integrator> make_euler_integrator(const Scene& scene, Dynamics& dynamics) {
  return std::make_unique<EulerIntegrator>(scene, dynamics);
}

}  // namespace weft::sim
