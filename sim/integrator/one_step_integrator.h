// Base of the one-step methods. Steps end on a grid of times, or the method chooses their lengths.
// A step that fails, or lets surfaces meet, is tried again with a shorter length.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "sim/integrator/accepted_step.h"
#include "sim/integrator/integrator.h"
#include "sim/integrator/short_steps.h"
#include "sim/integrator/step_failures.h"
#include "sim/integrator/veto_window.h"
#include "sim/motion/motion_limits.h"

namespace weft::sim {

// With `time.step`, steps end at its multiples (for `static`, at multiples of the time between
// frames). The length of a trial that fails is halved. Successful steps double the length again, up
// to `time.step`. The number of successes required for that is 1 at first. Each failed trial
// doubles this number, up to 16, or to 2 with `time.newton`. After as many successes of full
// length, it is 1 again.
//
// Without `time.step`, the method chooses the length of the next step. Moving pins or obstacles may
// end any step earlier (motion_limits.h). On a grid, the step after it ends at the next multiple at
// the latest. More than 100 cuts to keep surfaces apart in a window of 200 accepted steps end the
// run. A run on a grid may end after fewer cuts (one_step_integrator.cpp).
class OneStepIntegrator : public Integrator {
 public:
  OneStepIntegrator(const Scene& scene, Dynamics& dynamics);

  [[nodiscard]] std::optional<Failure> step() final;
  double time() const final { return accepted_.time(); }
  double last_step() const final { return accepted_.time() - accepted_.start_time(); }
  std::span<const double> state() const final { return accepted_.state(); }
  // Interpolates by AcceptedStep::interpolate().
  [[nodiscard]] std::optional<Failure> state_at(double time, std::span<double> y) const override;
  IntegratorCounts counts() const override { return counts_; }
  void restart(double time, std::span<const double> y) final;

 protected:
  using Trouble = StepTrouble;
  // Tries a step from time() and state() to `end` and stores its end state in `y`. A method without
  // a fixed step may end the step at another time, which it writes to `end`. On trouble, the method
  // may name the cause by set_fault() or set_place(), and set `end` to time() to end the run.
  virtual Trouble attempt(double& end, std::span<double> y) = 0;
  // True if attempt() itself checks its path, which need not be straight.
  virtual bool checks_its_own_path() const { return false; }
  // Called when an accepted step ends at an event (MotionLimits::next_event()). Slopes of earlier
  // steps do not extrapolate beyond time(). If a velocity or a curve `jumps`, earlier states do not
  // extrapolate either.
  virtual void pass_event(bool /*jumps*/) {}
  // Called after restart() has replaced the state: discards data of earlier steps.
  virtual void forget() {}
  // Writes or reads the members of this class.
  void transfer_steps(StateArchive& archive);
  // Called before the first step. If it returns a failure, the run does not begin.
  virtual std::optional<Failure> refusal() { return std::nullopt; }

  // Returns the shortest length (s) to which a failed step may be cut.
  virtual double shortest_step() const { return short_steps_.shortest(); }
  // Returns the failure of a run whose shortest step fails by `trouble`.
  virtual Failure final_failure(Trouble trouble) const;

  bool is_fixed() const { return step_.has_value(); }
  // Sets the length of the next step or trial. Precondition: there is no fixed step.
  void propose(double h) { size_ = h; }
  void set_fault(const std::optional<ContactFault>& fault) { fault_ = fault; }
  const std::optional<ContactFault>& fault() const { return fault_; }
  // Returns the trouble of a trial that fault() blocks.
  Trouble trouble_of_fault() const { return fault_ ? trouble_of(*fault_) : Trouble::surfaces; }
  void set_place(int particle) { place_ = particle; }
  // Names the largest part of the error of a successful trial.
  void set_error_limit(StepLimit limit) { limit_ = limit; }
  int place() const { return place_; }
  // Asks for a reason to stop, between the parts of a long trial. If it returns true, the trial
  // must return a Trouble other than `none`. step() then fails with the reason.
  bool should_stop() {
    if (!stopped_) stopped_ = reason_to_stop();
    return stopped_.has_value();
  }

  // Returns the latest end (s) that motions allow for a step that should end at `wanted`. Returns
  // nothing if no step is short enough; step() then fails with the reason.
  std::optional<double> latest_end(double wanted);
  bool motions_limit_steps() const { return motion_limits_.apply(); }
  // Returns MotionLimits::next_event() (s) after time().
  double next_event() const { return motion_limits_.next_event(time()); }

  const Scene& scene() const { return scene_; }
  Dynamics& dynamics() const { return dynamics_; }
  // Returns AcceptedStep::positions().
  const std::vector<Vec3>& positions() const { return accepted_.positions(); }

 private:
  double grid_time() const;
  double wanted_time() const;
  std::optional<double> next_time();
  Trouble check_path(double time, std::span<const double> y);
  void accept(double time);
  void count(Trouble trouble);
  std::optional<Failure> too_many_vetoes();

  const Scene& scene_;
  Dynamics& dynamics_;
  MotionLimits motion_limits_;
  std::optional<double> step_;  // length of a grid step (s); empty: the method chooses
  AcceptedStep accepted_;
  ShortSteps short_steps_;
  double size_ = 0;  // proposed length of the next trial (s)
  // Bound (s) of chosen steps after a veto.
  double longest_after_veto_ = std::numeric_limits<double>::infinity();
  std::int64_t completed_steps_ = 0;  // number of grid steps completed
  // Number of successful steps of one length, and number required to double the length.
  int successes_ = 0, patience_ = 1;
  IntegratorCounts counts_;
  std::optional<ContactFault> fault_;
  VetoWindow veto_window_;
  double window_start_ = 0;    // start of the present veto window (s)
  double window_allowed_ = 0;  // sum of allowed_ over the window's steps (s)
  double allowed_ = 0;         // length that motions allow for the present trial (s)
  int place_ = -1;
  StepLimit limit_ = StepLimit::given;  // what limits the present step
  std::optional<Failure> stopped_;      // reason why the present step must end
};

}  // namespace weft::sim
