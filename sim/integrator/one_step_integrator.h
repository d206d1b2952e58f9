// Base of the one-step methods: steps on a grid or of chosen length, shortened until they succeed
// and keep surfaces apart, and states in between.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "sim/integrator/accepted_step.h"
#include "sim/integrator/integrator.h"
#include "sim/integrator/step_failures.h"
#include "sim/integrator/veto_window.h"
#include "sim/motion/motion_limits.h"

namespace weft::sim {

// With `time.step`, times are its multiples (for `static`, multiples of the time between frames). A
// step that fails is taken in parts, halved until they succeed. The length is doubled again, up to
// the next multiple, after one success. Where the doubled length fails again, it takes two
// successes, then four .. 16.
// Without `time.step`, the method chooses the length of the next step. Where pins or obstacles
// move, steps of either kind end earlier (motion_limits.h), and steps of a grid go on from there to
// its next time. More than 100 cuts to keep surfaces apart in 200 accepted steps end the run.
class OneStepIntegrator : public Integrator {
 public:
  OneStepIntegrator(const Scene& scene, Dynamics& dynamics);

  [[nodiscard]] std::optional<Failure> step() final;
  double time() const final { return accepted_.time(); }
  double last_step() const final { return accepted_.time() - accepted_.start_time(); }
  std::span<const double> state() const final { return accepted_.state(); }
  // Interpolates positions by the cubic through positions and velocities at both ends, and
  // velocities by its derivative.
  [[nodiscard]] std::optional<Failure> state_at(double time, std::span<double> y) const override;
  IntegratorCounts counts() const override { return counts_; }
  void restart(double time, std::span<const double> y) final;

 protected:
  using Trouble = StepTrouble;
  // Tries a step from time() and state() to `end` and leaves it in `y`. A method that has no fixed
  // step may end elsewhere, and says where. On trouble, may name what stands in the way by
  // set_fault() or set_place().
  virtual Trouble attempt(double& end, std::span<double> y) = 0;
  // The method has checked the way it took, which need not be straight.
  virtual bool checks_its_own_path() const { return false; }
  // A prescribed motion starts, stops or passes a keyframe at time(): earlier slopes say nothing
  // about what follows, and where its velocity jumps, nothing about the state either.
  virtual void pass_event(bool /*jumps*/) {}
  // The state has become another one: nothing known of earlier steps holds.
  virtual void forget() {}
  // Writes or reads what this class holds.
  void transfer_steps(StateArchive& archive);
  // Called before the first step. May refuse to begin.
  virtual std::optional<Failure> refusal() { return std::nullopt; }

  bool is_fixed() const { return step_.has_value(); }
  // Sets the length of the next step, or of the next try. Precondition: there is no fixed step.
  void propose(double h) { size_ = h; }
  void set_fault(const std::optional<ContactFault>& fault) { fault_ = fault; }
  const std::optional<ContactFault>& fault() const { return fault_; }
  void set_place(int particle) { place_ = particle; }
  // Asks for a reason to stop, between the parts of a long try. If there is one, the try ends with
  // any trouble, and step() fails with the reason.
  bool should_stop() {
    if (!stopped_) stopped_ = reason_to_stop();
    return stopped_.has_value();
  }

  // Returns the latest end (s) that motions allow a step that is to end at `wanted`. Returns
  // nothing where no step is short enough; step() then fails with the reason.
  std::optional<double> latest_end(double wanted);
  bool motions_limit_steps() const { return motion_limits_.apply(); }

  const Scene& scene() const { return scene_; }
  Dynamics& dynamics() const { return dynamics_; }
  // Positions of all particles at time(); empty without contact, where no path is checked.
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
  std::optional<double> step_;  // s, of the grid
  AcceptedStep accepted_;
  double size_ = 0;                                                      // s, of the next try
  double longest_after_veto_ = std::numeric_limits<double>::infinity();  // s, of chosen steps
  std::int64_t completed_steps_ = 0;                                     // of the grid
  int successes_ = 0, patience_ = 1;  // of a length, and how many before it is doubled
  IntegratorCounts counts_;
  std::optional<ContactFault> fault_;
  VetoWindow veto_window_;
  double window_start_ = 0;    // s
  double window_allowed_ = 0;  // s: what its steps might have advanced within the motions' limits
  double allowed_ = 0;         // s, of the step in hand
  int place_ = -1;
  std::optional<Failure> stopped_;  // ends the step in hand
};

}  // namespace weft::sim
